// A scene in 32-bit floats: of any degree, sorted or not.
// three vectors a Gaussian: half axes at one standard deviation, in the world; w is the centre
@group(0) @binding(1) var<storage, read> shapes: array<vec4f>;
@group(0) @binding(2) var<storage, read> colors: array<f32>;   // harmonics, r, g, b inside
@group(0) @binding(3) var<storage, read> lobes: array<vec2f>;  // logit of opacity, phi before its ReLU
// of scenes with a network: what it takes besides the direction, and its results, which are the lobes
@group(0) @binding(4) var<storage, read> inputs: array<vec4f>;
@group(0) @binding(6) var<storage, read_write> seen: array<vec2f>;

struct StoredLook {
  color: vec4f,  // w: weight
  opacity: f32,
}

fn shape_of(i: u32) -> Shape {
  let a = shapes[3u * i];
  let b = shapes[3u * i + 1u];
  let c = shapes[3u * i + 2u];
  return Shape(vec3f(a.w, b.w, c.w), mat3x3f(a.xyz, b.xyz, c.xyz));
}

fn color_along(i: u32, basis: array<f32, 16>) -> vec3f {
  var b = basis;
  var color = vec3f(0.5);
  for (var k = 0u; k < view.sh_size; k++) {
    let at = 3u * (view.sh_size * i + k);
    color += b[k] * vec3f(colors[at], colors[at + 1u], colors[at + 2u]);
  }
  return color;
}

fn lobes_along(i: u32, basis: array<f32, 16>) -> vec2f {
  var b = basis;
  var seen = vec2f(0.0);
  for (var k = 0u; k < view.lobe_size; k++) { seen += b[k] * lobes[view.lobe_size * i + k]; }
  return seen;
}

// 12 harmonics, three scales, a quaternion, each of length 1; and the base opacity as a lobe.
fn inputs_of(i: u32) -> array<vec4f, 5> {
  let at = 5u * i;
  return array<vec4f, 5>(inputs[at], inputs[at + 1u], inputs[at + 2u], inputs[at + 3u], inputs[at + 4u]);
}

fn as_lobes(found: vec2f) -> vec2f { return found; }

fn store(look: Look) -> StoredLook {
  return StoredLook(vec4f(look.color, look.weight), look.opacity);
}

fn stored(look: StoredLook) -> Look { return Look(look.color.rgb, look.color.w, look.opacity); }
