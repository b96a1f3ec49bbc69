// Projects every Gaussian, as project.py and sortfree.py define it: what a picture needs of it goes
// to `splats`. Sort-free, the visible ones lie there in any order; sorted, each in its own place.
override SORTED = false;

struct Drawn {
  index_count: u32,  // the indirect draw's arguments
  batches: atomic<u32>,
  first_index: u32,
  base_vertex: u32,
  first_instance: u32,
  visible: atomic<u32>,
}

@group(0) @binding(0) var<uniform> view: View;
// three vectors a Gaussian: half axes at one standard deviation, in the world; w is the centre
@group(0) @binding(1) var<storage, read> shapes: array<vec4f>;
@group(0) @binding(2) var<storage, read> colors: array<f32>;   // harmonics, r, g, b inside
@group(0) @binding(3) var<storage, read> lobes: array<vec2f>;  // logit of opacity, phi before its ReLU
@group(0) @binding(4) var<storage, read_write> splats: array<Splat>;
@group(0) @binding(5) var<storage, read_write> drawn: Drawn;

fn harmonics(size: u32, d: vec3f) -> array<f32, 16> {
  var b: array<f32, 16>;
  b[0] = 0.28209479177387814;
  if (size < 4u) { return b; }
  const c1 = 0.4886025119029199;
  b[1] = -c1 * d.y;
  b[2] = c1 * d.z;
  b[3] = -c1 * d.x;
  if (size < 9u) { return b; }
  let s = d * d;
  b[4] = 1.0925484305920792 * d.x * d.y;
  b[5] = -1.0925484305920792 * d.y * d.z;
  b[6] = 0.31539156525252005 * (2.0 * s.z - s.x - s.y);
  b[7] = -1.0925484305920792 * d.x * d.z;
  b[8] = 0.5462742152960396 * (s.x - s.y);
  if (size < 16u) { return b; }
  b[9] = -0.5900435899266435 * d.y * (3.0 * s.x - s.y);
  b[10] = 2.890611442640554 * d.x * d.y * d.z;
  b[11] = -0.4570457994644658 * d.y * (4.0 * s.z - s.x - s.y);
  b[12] = 0.3731763325901154 * d.z * (2.0 * s.z - 3.0 * s.x - 3.0 * s.y);
  b[13] = -0.4570457994644658 * d.x * (4.0 * s.z - s.x - s.y);
  b[14] = 1.445305721320277 * d.z * (s.x - s.y);
  b[15] = -0.5900435899266435 * d.x * (s.x - 3.0 * s.y);
  return b;
}

fn weight_of(depth: f32, largest: f32, phi: f32) -> f32 {
  if (view.weighting == 3u) { return max(0.0, 1.0 - depth / view.sigma) * phi; }
  var w = phi * phi;
  if (view.weighting != 1u) { w += phi / (depth * depth); }
  if (view.weighting != 2u) { w += exp(min(largest / depth, view.exponent_max)); }
  return w;
}

// reach stays 0 where the Gaussian cannot touch the picture
fn project(i: u32) -> Splat {
  var splat: Splat;
  let a = shapes[3u * i];
  let b = shapes[3u * i + 1u];
  let c = shapes[3u * i + 2u];
  let mean = vec4f(a.w, b.w, c.w, 1.0);
  let z = dot(view.row_z, mean);
  if (!(z > view.near)) { return splat; }
  let t = vec2f(dot(view.row_x, mean), dot(view.row_y, mean)) / z;
  let uv = clamp(t, view.limits.xz, view.limits.yw);

  // rows of the projected square root of the covariance
  let axes = mat3x3f(a.xyz, b.xyz, c.xyz);
  let depths = view.row_z.xyz * axes;
  let px = (view.focal.x / z) * (view.row_x.xyz * axes - uv.x * depths);
  let py = (view.focal.y / z) * (view.row_y.xyz * axes - uv.y * depths);
  let var_x = dot(px, px) + BLUR;
  let var_y = dot(py, py) + BLUR;
  let cov = dot(px, py);
  // Cauchy-Binet: the determinant as a sum of squares cannot cancel
  let crossed = cross(px, py);
  let det = dot(crossed, crossed) + BLUR * (var_x + var_y - BLUR);

  let away = mean.xyz - view.position;
  let basis = harmonics(max(view.sh_size, view.lobe_size), away * inverseSqrt(dot(away, away)));
  var seen = vec2f(0.0);
  for (var k = 0u; k < view.lobe_size; k++) { seen += basis[k] * lobes[view.lobe_size * i + k]; }
  let opacity = 1.0 / (1.0 + exp(-seen.x));
  if (!(opacity > ALPHA_MIN)) { return splat; }
  let reach = sqrt(2.0 * log(255.0 * opacity));
  let center = view.focal * t + view.center;
  let box = reach * sqrt(vec2f(var_x, var_y));
  if (any(center + box < vec2f(0.5)) || any(center - box > view.size - 0.5)) { return splat; }

  // eigenvalues, the smaller one from the determinant; the sum that is the larger one does not cancel
  let skew = 0.5 * (var_x - var_y);
  let root = sqrt(skew * skew + cov * cov);
  let large = 0.5 * (var_x + var_y) + root;
  var way = vec2f(1.0, 0.0);
  if (root > 0.0) {
    way = normalize(select(vec2f(cov, root - skew), vec2f(root + skew, cov), skew > 0.0));
  }
  var color = vec3f(0.5);
  for (var k = 0u; k < view.sh_size; k++) {
    let at = 3u * (view.sh_size * i + k);
    color += basis[k] * vec3f(colors[at], colors[at + 1u], colors[at + 2u]);
  }
  let largest = sqrt(max(dot(a.xyz, a.xyz), max(dot(b.xyz, b.xyz), dot(c.xyz, c.xyz))));
  splat.center = center;
  splat.major = way * sqrt(large);
  splat.minor = vec2f(-way.y, way.x) * sqrt(det / large);
  splat.opacity = opacity;
  splat.color = max(color, vec3f(0.0));
  splat.weight = weight_of(z, largest, max(seen.y, 0.0)) * view.weight_scale;
  splat.reach = reach;
  return splat;
}

@compute @workgroup_size(64)
fn project_all(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
  let i = id.y * groups.x * 64u + id.x;  // a row of work groups is not long enough for all
  if (i >= view.count) { return; }
  let splat = project(i);
  if (SORTED) {
    splats[i] = splat;
    return;
  }
  if (splat.reach > 0.0) {
    let place = atomicAdd(&drawn.visible, 1u);
    if (place % BATCH == 0u) { atomicMax(&drawn.batches, place / BATCH + 1u); }
    splats[place] = splat;
  }
}
