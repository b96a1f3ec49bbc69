// Evaluates the paper's network (section 3.2) for every Gaussian that can touch the picture, before
// project.wgsl reads its results as lobes of degree 0. Same formula: ViewNetwork in
// mobilegs/render/view_network.py; its weights are ordered by network_matrices in
// viewer/src/render/view_network.js and mobilegs/view/wgpu_renderer.py. The
// 64-wide layer is folded into the two heads. `Num` is f16 where the device has it; sums are f32.
// A work group evaluates 32 Gaussians: each of four invocations, a quarter of every layer.
alias Num4 = vec4<Num>;

const GAUSSIANS = 32u;
const QUARTERS = 4u;
const PARTS = 4u;  // of the first layer: 64 of its outputs at a time, as work groups have little memory
const NUM_MAX = 6e4;  // of f16

// A matrix takes four inputs to four outputs; of the first layer six follow each other, of the others 32.
const LAYER1 = 0u;
const OFFSETS2 = 384u;
const LAYER2 = 416u;
const HEADS = 2464u;
const HEAD_OFFSETS = 2496u;
@group(0) @binding(5) var<storage, read> weights: array<mat4x4<Num>>;

var<workgroup> hidden: array<Num4, 512>;  // four outputs of the first layer, of each Gaussian
var<workgroup> sums: array<vec2f, 128>;
var<workgroup> touching: atomic<u32>;
var<workgroup> any_touches: u32;

fn activated(x: vec4f) -> Num4 { return Num4(clamp(x, vec4f(0.0), vec4f(NUM_MAX))); }

@compute @workgroup_size(GAUSSIANS * QUARTERS)
fn evaluate_network(
    @builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32) {
  let own = local % GAUSSIANS;
  let quarter = local / GAUSSIANS;
  let place = (group.y * groups.x + group.x) * GAUSSIANS + own;
  let i = min(place, view.count - 1u);
  let shape = shape_of(i);
  let ellipse = ellipse_of(shape);
  if (quarter == 0u && ellipse.depth > view.near && touches(ellipse, 1.0)) {
    atomicMax(&touching, 1u);
  }
  workgroupBarrier();
  if (local == 0u) { any_touches = atomicLoad(&touching); }
  if (workgroupUniformLoad(&any_touches) == 0u) { return; }

  let away = shape.mean - view.position;
  let direction = away * inverseSqrt(max(dot(away, away), 1e-30));
  let fixed = inputs_of(i);  // one more: the base opacity
  let x0 = Num4(fixed[0]);
  let x1 = Num4(fixed[1]);
  let x2 = Num4(fixed[2]);
  let x3 = Num4(vec4f(direction, fixed[3].x));
  let x4 = Num4(vec4f(fixed[3].yzw, fixed[4].x));
  let x5 = Num4(vec4f(fixed[4].yz, 1.0, 0.0));
  let one = Num4(vec4f(1.0, 0.0, 0.0, 0.0));

  var at = OFFSETS2 + 8u * quarter;
  var a0 = vec4f(one * weights[at]);
  var a1 = vec4f(one * weights[at + 1u]);
  var a2 = vec4f(one * weights[at + 2u]);
  var a3 = vec4f(one * weights[at + 3u]);
  var a4 = vec4f(one * weights[at + 4u]);
  var a5 = vec4f(one * weights[at + 5u]);
  var a6 = vec4f(one * weights[at + 6u]);
  var a7 = vec4f(one * weights[at + 7u]);
  for (var part = 0u; part < PARTS; part++) {
    for (var four = 4u * quarter; four < 4u * quarter + 4u; four++) {
      let first = LAYER1 + 6u * (16u * part + four);
      let h = vec4f(x0 * weights[first]) + vec4f(x1 * weights[first + 1u])
          + vec4f(x2 * weights[first + 2u]) + vec4f(x3 * weights[first + 3u])
          + vec4f(x4 * weights[first + 4u]) + vec4f(x5 * weights[first + 5u]);
      hidden[GAUSSIANS * four + own] = activated(h);
    }
    workgroupBarrier();
    for (var four = 0u; four < 16u; four++) {
      let h = hidden[GAUSSIANS * four + own];
      at = LAYER2 + 32u * (16u * part + four) + 8u * quarter;
      a0 += vec4f(h * weights[at]);
      a1 += vec4f(h * weights[at + 1u]);
      a2 += vec4f(h * weights[at + 2u]);
      a3 += vec4f(h * weights[at + 3u]);
      a4 += vec4f(h * weights[at + 4u]);
      a5 += vec4f(h * weights[at + 5u]);
      a6 += vec4f(h * weights[at + 6u]);
      a7 += vec4f(h * weights[at + 7u]);
    }
    workgroupBarrier();
  }
  at = HEADS + 8u * quarter;
  let found = vec4f(activated(a0) * weights[at]) + vec4f(activated(a1) * weights[at + 1u])
      + vec4f(activated(a2) * weights[at + 2u]) + vec4f(activated(a3) * weights[at + 3u])
      + vec4f(activated(a4) * weights[at + 4u]) + vec4f(activated(a5) * weights[at + 5u])
      + vec4f(activated(a6) * weights[at + 6u]) + vec4f(activated(a7) * weights[at + 7u]);
  sums[local] = found.xy;
  workgroupBarrier();
  if (quarter > 0u || place >= view.count) { return; }
  let offsets = vec4f(one * weights[HEAD_OFFSETS]).xy;
  let total = sums[own] + sums[own + 32u] + sums[own + 64u] + sums[own + 96u] + offsets;
  // the constant harmonic of lobes
  seen[i] = as_lobes(vec2f(fixed[4].w, 0.0) + total / 0.28209479177387814);
}
