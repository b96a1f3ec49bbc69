/** Shaders that only three.js needs, in WGSL; each follows view.wgsl. They do the same as those in webgl_texts.js. */

/** Bindings behind those of the renderer. */
export const PLACED = 8;
export const DEPTH = 9;
export const BLOCKS = 10;
export const WIDE_BLOCKS = 11;
export const PICTURE = 12;
/** Bytes of `Placed`. */
export const PLACED_BYTES = 32;

const PLACED_TEXT = `
struct Placed {
  to_nearness: vec4f,  // a factor and an offset of the depth; depth of empty pixels; log2(far / near) or 0
  first: vec2i,        // pixel of the viewport in the framebuffer
}

@group(0) @binding(${PLACED}) var<uniform> placed: Placed;

fn inside(at: vec2i) -> vec2i { return clamp(at, vec2i(), vec2i(view.size) - 1); }
`;

/** Reads the depth of opaque meshes. @param {boolean} multisampled */
export const nearnessAt = (multisampled) => `${PLACED_TEXT}
@group(0) @binding(${DEPTH}) var scene_depth: ${multisampled ? "texture_depth_multisampled_2d" : "texture_depth_2d"};

// The nearness of the opaque mesh at a pixel of the sums; 0 without one.
fn nearness_at(at: vec2i) -> f32 {
  let depth = textureLoad(scene_depth, placed.first + inside(at) / i32(view.supersampling), 0);
  let how = placed.to_nearness;
  if (depth == how.z) { return 0.0; }
  return clamp(select(how.x * depth + how.y, exp2(-depth * how.w), how.w > 0.0), 0.0, 1.0);
}
`;

/** The nearness in the targets of all levels, and in blocks of 8 x 8 and of 64 x 64 pixels. */
export const NEARNESS = `
@group(0) @binding(${BLOCKS}) var blocks: texture_2d<f32>;

@vertex
fn whole_target(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
  return vec4f(f32((vertex << 1u) & 2u) * 2.0 - 1.0, f32(vertex & 2u) * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn nearness_of_levels(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
  var at = vec2i(position.xy);
  for (var level = 1u; level < 4u; level++) {
    let region = vec4i(view.regions[level]);
    if (any(at < region.xy) || any(at >= region.zw)) { continue; }
    at = (at - region.xy - 1) << vec2u(level);  // a target begins one of its pixels before the picture
    break;
  }
  return nearness_at(at);
}

@fragment
fn range_of_pixels(@builtin(position) position: vec4f) -> @location(0) vec4f {
  var range = vec2f(1.0, 0.0);
  for (var k = 0; k < 64; k++) {
    let nearness = nearness_at(8 * vec2i(position.xy) + vec2i(k & 7, k >> 3u));
    range = vec2f(min(range.x, nearness), max(range.y, nearness));
  }
  return vec4f(range, 0.0, 0.0);
}

@fragment
fn range_of_blocks(@builtin(position) position: vec4f) -> @location(0) vec4f {
  var range = vec2f(1.0, 0.0);
  for (var k = 0; k < 64; k++) {
    let at = min(8 * vec2i(position.xy) + vec2i(k & 7, k >> 3u), vec2i(textureDimensions(blocks)) - 1);
    let block = textureLoad(blocks, at, 0).rg;
    range = vec2f(min(range.x, block.x), max(range.y, block.y));
  }
  return vec4f(range, 0.0, 0.0);
}
`;

/** Behind project.wgsl: Gaussians that opaque meshes hide in one part and not in another are drawn at full size. */
export const PROJECT = `
@group(0) @binding(${BLOCKS}) var blocks: texture_2d<f32>;
@group(0) @binding(${WIDE_BLOCKS}) var wide_blocks: texture_2d<f32>;

fn partly_hidden(e: Ellipse, opacity: f32, level: u32) -> bool {
  let nearness = min(view.nearest / e.depth, 1.0);
  let box = reach_of(opacity) * sqrt(e.variance) + f32(4u << level);  // enlarging spreads it
  let last = vec2i(view.size) - 1;
  var low = clamp(vec2i(e.center - box), vec2i(), last) >> vec2u(3u);
  var high = clamp(vec2i(e.center + box), vec2i(), last) >> vec2u(3u);
  let far = any(high - low > vec2i(5));
  if (far) {
    low >>= vec2u(3u);
    high >>= vec2u(3u);
  }
  if (any(high - low > vec2i(15))) { return true; }
  var range = vec2f(1.0, 0.0);
  for (var y = low.y; y <= high.y; y++) {
    for (var x = low.x; x <= high.x; x++) {
      var block: vec2f;
      if (far) { block = textureLoad(wide_blocks, vec2i(x, y), 0).rg; } else { block = textureLoad(blocks, vec2i(x, y), 0).rg; }
      range = vec2f(min(range.x, block.x), max(range.y, block.y));
    }
  }
  // blocks are float16
  return nearness > 0.998 * range.x && nearness < 1.002 * range.y;
}

@compute @workgroup_size(BATCH)
fn project_in_depth(
    @builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32) {
  let i = (group.y * groups.x + group.x) * BATCH + local;
  var seen: Seen;
  if (i < view.count) { seen = look_at(i); }
  if (seen.level > 0u && partly_hidden(ellipse_of(shape_of(i)), seen.look.opacity, seen.level)) { seen.level = 0u; }
  append_to_list(i, local, seen);
}
`;

/** Behind resolve.wgsl: draws the sums over the framebuffer, with alpha. @param {boolean} leveled */
export const over = (leveled) => `${PLACED_TEXT}
@group(0) @binding(${DEPTH}) var sums_depth: texture_depth_2d;  // the nearness of opaque meshes
@group(0) @binding(${PICTURE}) var picture: texture_2d<f32>;  // a copy of the framebuffer

override BEHIND_EDGES = false;  // whether samples behind the edges of opaque meshes are drawn

fn displayed(c: vec3f) -> vec3f {
  return select(1.055 * pow(max(c, vec3f()), vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn linear(c: vec3f) -> vec3f {
  return select(pow(max(c + 0.055, vec3f()) / 1.055, vec3f(2.4)), c / 12.92, c <= vec3f(0.04045));
}

// The depth in the framebuffer of a nearness.
fn depth_of(nearness: f32) -> f32 {
  let how = placed.to_nearness;
  return clamp(select((nearness - how.y) / how.x, -log2(nearness) / how.w, how.w > 0.0), 0.0, 1.0);
}

// The sums at a pixel, with alpha.
fn mean_at(first: vec2i) -> vec4f {
  let side = i32(view.supersampling);
  var sum = vec4f();
  for (var k = 0; k < side * side; k++) {
    let at = first + vec2i(k % side, k / side);
    sum += ${leveled ? "resolved_levels(at)" : "resolved(sums_at(at))"};
  }
  return sum / f32(side * side);
}

// Colours are mixed as they are displayed; blending adds what is left of the target.
fn mixed(sum: vec4f, position: vec4f) -> vec4f {
  let behind = textureLoad(picture, vec2i(position.xy), 0);
  let rest = 1.0 - sum.a;
  let alpha = sum.a + rest * behind.a;
  let color = sum.rgb + rest * behind.a * displayed(behind.rgb / max(behind.a, 1e-6));
  return vec4f(alpha * linear(color / max(alpha, 1e-6)) - rest * behind.rgb, sum.a);
}

fn pixel_of(position: vec4f) -> vec2i { return (vec2i(position.xy) - placed.first) * i32(view.supersampling); }

@fragment
fn draw_over(@builtin(position) position: vec4f) -> @location(0) vec4f {
  return mixed(mean_at(pixel_of(position)), position);
}

struct Drawn {
  @location(0) color: vec4f,
  @builtin(frag_depth) depth: f32,
}

// Of a pixel with several samples an opaque mesh may cover some. One draw is for those and another for the rest, each
// with the sums of a neighbour that the mesh covers, or not.
@fragment
fn draw_over_samples(@builtin(position) position: vec4f) -> Drawn {
  var at = pixel_of(position);
  var range = vec2f(2.0, -1.0);
  var nearest: vec2i;
  var farthest: vec2i;
  for (var k = 0; k < 9; k++) {
    let next = inside(at + i32(view.supersampling) * (vec2i(k % 3, k / 3) - 1));
    let nearness = textureLoad(sums_depth, next, 0);
    if (nearness > range.y) { nearest = next; }
    if (nearness < range.x) { farthest = next; }
    range = vec2f(min(range.x, nearness), max(range.y, nearness));
  }
  let edge = range.x < 0.95 * range.y;
  if (BEHIND_EDGES && !edge) { discard; }
  var depth = placed.to_nearness.z;
  if (edge) {
    at = select(nearest, farthest, BEHIND_EDGES) / i32(view.supersampling) * i32(view.supersampling);
    depth = depth_of(0.5 * (range.x + range.y));
  }
  return Drawn(mixed(mean_at(at), position), depth);
}

@fragment
fn draw_depth(@builtin(position) position: vec4f) -> Drawn {
  let at = pixel_of(position);
  if (!(mean_at(at).a > 0.5)) { discard; }
  // of all levels
  var sum = textureLoad(weights, at, 0).rg;
  for (var level = 1u; level < ${leveled ? 4 : 1}u; level++) {
    sum += textureLoad(weights, vec2i(view.regions[level].xy) + (at >> vec2u(level)) + 1, 0).rg;
  }
  return Drawn(vec4f(), depth_of(sum.y / sum.x));
}
`;
