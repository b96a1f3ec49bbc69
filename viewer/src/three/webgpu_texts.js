/** Shaders that only three.js needs, in WGSL; each follows view.wgsl. They do the same as those in webgl_texts.js. */

import { MOST_LAYERS } from "./placed_camera.js";

/** Bindings behind those of the renderer. */
export const PLACED = 8;
export const DEPTH = 9;
export const BLOCKS = 10;
export const WIDE_BLOCKS = 11;
export const PICTURE = 12;
/** Of the colours of layers; the next one is that of their proximities. */
export const LAYERS = 13;
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
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
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

/** The depths of a Gaussian, for the two shaders that follow. */
const NEAREST_OF = `
const DEPTH_SPREAD_MIN = 1e-3;  // of the depth, so that no edge is harder

// A depth that nearly nothing of a Gaussian comes before.
fn nearest_of(e: Ellipse) -> f32 {
  return max(e.depth * (1.0 - 3.0 * DEPTH_SPREAD_MIN) - 3.0 * sqrt(e.depth_variance), view.nearest);
}
`;

/** Behind project.wgsl: Gaussians that opaque meshes hide in one part and not in another are drawn at full size. */
export const PROJECT = `${NEAREST_OF}
@group(0) @binding(${BLOCKS}) var blocks: texture_2d<f32>;
@group(0) @binding(${WIDE_BLOCKS}) var wide_blocks: texture_2d<f32>;

fn partly_hidden(e: Ellipse, opacity: f32, level: u32) -> bool {
  let extent = e.depth - nearest_of(e);
  let nearness = min(view.nearest / (e.depth + vec2f(extent, -extent)), vec2f(1.0));
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
  return nearness.y > 0.998 * range.x && nearness.x < 1.002 * range.y;
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

/**
 * Behind splat.wgsl and `nearnessAt`: adds the proximities of Gaussians up, and how opaque meshes hide a part of one.
 *
 * Along the ray of a pixel, a Gaussian has a mean depth, which is linear in the pixel, and a spread. The share of it
 * that lies before the mesh is kept: the same formula is in tests/support/placed_scenes.py.
 */
export const SPLAT = `${NEAREST_OF}
struct PlacedCorner {  // as LevelCorner
  @builtin(position) position: vec4f,
  @location(0) @interpolate(flat) axes: vec4f,
  @location(1) @interpolate(flat) color: vec4f,
  @location(2) @interpolate(flat) center: vec4f,
  @location(3) @interpolate(flat) region: vec4f,
  @location(4) @interpolate(flat) proximity: f32,
  @location(5) @interpolate(flat) depths: vec4f,  // at the centre, its slope per pixel, and its standard deviation beside the slope
  @location(6) @interpolate(flat) level: u32,
  @location(7) @interpolate(flat) seen: vec4f,
}

@vertex
fn placed_corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PlacedCorner {
  var out: PlacedCorner;
  out.position = NOWHERE;
  let place = place_in(vertex, instance);
  if (place >= listed.count) { return out; }
  let e = listed_ellipse(place);
  let corner = level_corner(vertex, place, e, select(view.size, view.whole, LEVELED));
  out.position = vec4f(corner.position.xy, min(view.nearest / nearest_of(e), 1.0), 1.0);
  out.axes = corner.axes;
  out.color = corner.color;
  out.center = corner.center;
  out.region = corner.region;
  out.proximity = PROXIMITY_SCALE * sqrt(min(view.nearest / e.depth, 1.0));
  out.level = order[place] >> LEVEL_SHIFT;
  out.depths = depths_of(e, f32(1u << out.level));
  out.seen = corner.seen;
  return out;
}

@vertex
fn placed_corner_of_pass(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> PlacedCorner {
  var out: PlacedCorner;
  out.position = NOWHERE;
  let place = place_in(vertex, instance);
  if (place >= listed.count) { return out; }
  let e = listed_ellipse(place);
  let corner = pass_corner(vertex, place, e);
  out.position = corner.position;
  out.axes = corner.axes;
  out.center = corner.center;
  out.seen = corner.seen;
  out.depths = depths_of(e, 4.0);
  return out;
}

// In a target whose pixels have sides of \`side\` pixels.
fn depths_of(e: Ellipse, side: f32) -> vec4f {
  let c = e.depth_covariance;
  let slope = (e.variance.yx * c - e.covariance * c.yx) / e.determinant;
  let least = DEPTH_SPREAD_MIN * e.depth;
  return vec4f(e.depth, side * slope, sqrt(max(e.depth_variance - dot(slope, c), least * least)));
}

@fragment
fn add_moments(corner: PlacedCorner) -> Sums {
  let alpha = alpha_in(corner.region, corner.position.xy, corner.axes, corner.center);
  return moments_of(alpha, corner.color, corner.proximity);
}

@fragment
fn add_moments_seen(corner: PlacedCorner) -> Sums {
  let alpha = alpha_in(corner.region, corner.position.xy, corner.axes, corner.center);
  return moments_of(alpha, dimmed(corner.color, corner.position.xy, corner.seen), corner.proximity);
}

@fragment
fn add_before_meshes(corner: PlacedCorner) -> Sums {
  return moments_of(alpha_before(corner), corner.color, corner.proximity);
}

@fragment
fn add_before_meshes_seen(corner: PlacedCorner) -> Sums {
  return moments_of(alpha_before(corner), dimmed(corner.color, corner.position.xy, corner.seen), corner.proximity);
}

@fragment
fn add_depth_before_meshes(corner: PlacedCorner) -> @location(0) vec4f {
  let position = corner.position.xy;
  let share = share_in_front(corner.depths, position - corner.center.xy, vec2i(position), 2u);
  return share * depth_of(alpha_at(position, corner.axes, corner.center), corner.seen.w);
}

fn alpha_before(corner: PlacedCorner) -> f32 {
  let position = corner.position.xy;
  let alpha = alpha_in(corner.region, position, corner.axes, corner.center);
  let at = vec2i(position - corner.region.xy);
  return alpha * share_in_front(corner.depths, position - corner.center.xy, at, corner.level);
}

fn moments_of(alpha: f32, color: vec4f, proximity: f32) -> Sums {
  let sums = sums_of(alpha, color);
  return Sums(sums.color, sums.weights.r * vec4f(1.0, proximity, proximity * proximity, 0.0));
}

// The share of a Gaussian that lies before the opaque mesh at a pixel of a level's target, \`offset\` from its centre.
fn share_in_front(depths: vec4f, offset: vec2f, at: vec2i, level: u32) -> f32 {
  // a target begins one of its pixels before the picture
  let nearness = nearness_at(select((at - 1) << vec2u(level), at, level == 0u));
  if (!(nearness > 0.0)) { return 1.0; }
  let before = (view.nearest / nearness - depths.x - dot(depths.yz, offset)) / depths.w;
  return 1.0 / (1.0 + exp(-1.702 * before));  // close to the normal distribution
}
`;

const SHOWN = `
struct Shown {
  color: vec4f,    // with alpha
  proximity: f32,  // mean
}
`;

/**
 * Behind resolve.wgsl: a pixel of a picture without layers, and a scene as a layer of another one, with the mean
 * proximity and its standard deviation.
 *
 * @param {boolean} leveled
 */
export const sums = (leveled) => `${SHOWN}
fn all_sums_at(at: vec2i) -> Sums { return ${leveled ? "sums_of_levels(at)" : "sums_at(at)"}; }

fn shown_at(first: vec2i) -> Shown {
  let side = i32(view.supersampling);
  var color = vec4f();
  var weights = vec4f();
  for (var k = 0; k < samples(); k++) {
    let sums = all_sums_at(first + vec2i(k % side, k / side));
    color += resolved(sums);
    weights = sums.weights;
  }
  return Shown((1.0 - view.faded) * color / f32(samples()), weights.g / weights.r);
}

struct Layer {
  @location(0) color: vec4f,
  @location(1) proximity: vec4f,
}

@fragment
fn layer_of(@builtin(position) position: vec4f) -> Layer {
  var sum = vec4f();
  var moments = vec2f();
  for (var k = 0; k < samples(); k++) {
    let sums = all_sums_at(sample_of(position, k));
    let one = resolved(sums);
    sum += one;
    moments += one.a * sums.weights.gb / max(sums.weights.r, 1e-12 * view.weight_scale);
  }
  moments /= max(sum.a, 1e-6);
  let spread = sqrt(max(moments.y - moments.x * moments.x, 0.0));
  return Layer((1.0 - view.faded) * sum / f32(samples()), vec4f(moments.x, spread, 0.0, 0.0));
}
`;

/**
 * Behind resolve.wgsl: a pixel of a picture with several layers, which it composites: `composite` of
 * mobilegs/render/layers.py, which explains it.
 */
export const COMPOSITE = `${SHOWN}
@group(0) @binding(${LAYERS}) var layer_colors: texture_2d_array<f32>;
@group(0) @binding(${LAYERS + 1}) var layer_proximities: texture_2d_array<f32>;

const EXTENT = 0.4;
const TRANSMITTANCE_MIN = 1e-4;
const THIN = 1e-4;

fn shown_at(first: vec2i) -> Shown {
  let at = first / i32(view.supersampling);
  let layers = textureNumLayers(layer_colors);
  var colors: array<vec3f, ${MOST_LAYERS}>;
  var slabs: array<vec3f, ${MOST_LAYERS}>;  // the nearer end, the farther end, optical depth per proximity
  var edge = -1.0;
  for (var i = 0u; i < layers; i++) {
    let color = textureLoad(layer_colors, at, i, 0);
    let found = textureLoad(layer_proximities, at, i, 0).rg;
    let slab = vec2f(found.x * (1.0 + THIN) + EXTENT * found.y, max(found.x * (1.0 - THIN) - EXTENT * found.y, 0.0));
    colors[i] = color.rgb / max(color.a, TRANSMITTANCE_MIN);
    slabs[i] = vec3f(slab, -log(max(1.0 - color.a, TRANSMITTANCE_MIN)) / max(slab.x - slab.y, 1e-9));
    if (!(color.a > 0.0)) { slabs[i] = vec3f(-1.0); }
    edge = max(edge, slabs[i].x);
  }
  var image = vec3f();
  var left = 1.0;
  var proximity = 0.0;
  while (edge > 0.0) {
    var next = -1.0;
    for (var i = 0u; i < layers; i++) {
      if (slabs[i].x < edge) { next = max(next, slabs[i].x); }
      if (slabs[i].y < edge) { next = max(next, slabs[i].y); }
    }
    if (next < 0.0) { break; }
    var color = vec3f();
    var total = 0.0;
    for (var i = 0u; i < layers; i++) {
      if (slabs[i].x < edge || slabs[i].y > next) { continue; }
      let part = slabs[i].z * (edge - next);
      color += part * colors[i];
      total += part;
    }
    let share = left * (1.0 - exp(-total));
    image += share * color / max(total, 1e-12);
    proximity += share * 0.5 * (edge + next);
    left -= share;
    edge = next;
  }
  return Shown(vec4f(image, 1.0 - left), proximity / max(1.0 - left, 1e-6));
}
`;

/** Behind resolve.wgsl and `sums` or `COMPOSITE`: draws a picture over the framebuffer, with alpha. */
export const OVER = `${PLACED_TEXT}
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
  return mixed(shown_at(pixel_of(position)).color, position);
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
  return Drawn(mixed(shown_at(at).color, position), depth);
}

@fragment
fn draw_depth(@builtin(position) position: vec4f) -> Drawn {
  let shown = shown_at(pixel_of(position));
  if (!(shown.color.a > 0.5)) { discard; }
  let proximity = shown.proximity / PROXIMITY_SCALE;
  return Drawn(vec4f(), depth_of(proximity * proximity));
}
`;
