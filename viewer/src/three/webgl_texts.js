/** Shaders that only three.js needs, in GLSL; each follows view.glsl. */

import { MOST_LAYERS } from "./placed_camera.js";

const NEARNESS_AT = `
uniform sampler2D scene_depth;
uniform ivec2 first;        // pixel of the viewport in the framebuffer
uniform vec4 to_nearness;   // a factor and an offset of the depth; depth of empty pixels; log2(far + 1) or 0

// The nearness of the opaque mesh at a pixel of the sums; 0 without one.
float nearness_at(ivec2 at) {
  float depth = texelFetch(scene_depth, first + clamp(at, ivec2(0), ivec2(size.xy) - 1) / supersampling, 0).r;
  if (depth == to_nearness.z) { return 0.0; }
  float found = to_nearness.x * depth + to_nearness.y;
  if (to_nearness.w > 0.0) { found = to_nearness.x / (exp2(depth * to_nearness.w) - 1.0); }
  return clamp(found, 0.0, 1.0);
}
`;

/**
 * Fragment shader: the nearness of the opaque meshes, in the targets of all levels. In the coarse ones any pixel of
 * a block will do: Gaussians that only a part of a block hides are drawn at full size.
 */
export const NEARNESS = `${NEARNESS_AT}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
#ifdef LEVELED
  for (int level = 1; level < 4; level++) {
    ivec2 from = ivec2(regions[level].xy);
    if (any(lessThan(at, from)) || any(greaterThanEqual(at, ivec2(regions[level].zw)))) { continue; }
    at = (at - from - 1) << level;  // a target begins one of its pixels before the picture
    break;
  }
#endif
  gl_FragDepth = 0.5 + 0.5 * nearness_at(at);
}
`;

/** Fragment shader: the least and the largest nearness in a block of 8 x 8 pixels; with WIDE, of as many blocks. */
export const BLOCKS = `${NEARNESS_AT}
uniform sampler2D blocks;
out vec4 found;

void main() {
  ivec2 corner = 8 * ivec2(gl_FragCoord.xy);
  vec2 range = vec2(1.0, 0.0);
  for (int k = 0; k < 64; k++) {
    ivec2 at = corner + ivec2(k & 7, k >> 3);
#ifdef WIDE
    vec2 block = texelFetch(blocks, min(at, textureSize(blocks, 0) - 1), 0).rg;
    range = vec2(min(range.x, block.x), max(range.y, block.y));
#else
    float nearness = nearness_at(at);
    range = vec2(min(range.x, nearness), max(range.y, nearness));
#endif
  }
  found = vec4(range, 0.0, 0.0);
}
`;

/**
 * For both shaders of splat.glsl: how opaque meshes hide a part of a Gaussian.
 *
 * Along the ray of a pixel, a Gaussian has a mean depth, which is linear in the pixel, and a spread. The share of it
 * that lies before the mesh is kept: the same formula is in tests/support/placed_scenes.py.
 */
export const MESHES = `
#define MESHES
#ifdef VERTEX

uniform sampler2D blocks;       // least and largest nearness in blocks of 8 x 8 pixels
uniform sampler2D wide_blocks;  // of 64 x 64

const float DEPTH_SPREAD_MIN = 1e-3;  // of the depth, so that no edge is harder

vec4 depths_of(Ellipse e) {
  vec2 c = e.depth_covariance;
  vec2 slope = vec2(e.variance.y * c.x - e.covariance * c.y, e.variance.x * c.y - e.covariance * c.x) / e.determinant;
  float least = DEPTH_SPREAD_MIN * e.depth;
  return vec4(e.depth, slope, sqrt(max(e.depth_variance - dot(slope, c), least * least)));
}

// A depth that nearly nothing of a Gaussian comes before.
float nearest_of(Ellipse e) {
  return max(e.depth * (1.0 - 3.0 * DEPTH_SPREAD_MIN) - 3.0 * sqrt(e.depth_variance), whole.z);
}

bool partly_hidden(Ellipse e, float opacity, int level) {
  float extent = e.depth - nearest_of(e);
  vec2 nearness = min(whole.z / (e.depth + vec2(extent, -extent)), 1.0);
  vec2 box = reach_of(opacity) * sqrt(e.variance) + float(4 << level);  // enlarging spreads it
  ivec2 low = clamp(ivec2(e.center - box), ivec2(0), ivec2(size.xy) - 1) >> 3;
  ivec2 high = clamp(ivec2(e.center + box), ivec2(0), ivec2(size.xy) - 1) >> 3;
  bool far = any(greaterThan(high - low, ivec2(5)));
  if (far) {
    low >>= 3;
    high >>= 3;
  }
  if (any(greaterThan(high - low, ivec2(15)))) { return true; }
  vec2 range = vec2(1.0, 0.0);
  for (int y = low.y; y <= high.y; y++) {
    for (int x = low.x; x <= high.x; x++) {
      vec2 block = far ? texelFetch(wide_blocks, ivec2(x, y), 0).rg : texelFetch(blocks, ivec2(x, y), 0).rg;
      range = vec2(min(range.x, block.x), max(range.y, block.y));
    }
  }
  // blocks are float16
  return nearness.y > 0.998 * range.x && nearness.x < 1.002 * range.y;
}

#else
${NEARNESS_AT}
// The share of a Gaussian that lies before the opaque mesh at a pixel of a level's target, ${"`"}offset${"`"} from its centre.
float share_in_front(vec4 depths, vec2 offset, ivec2 at, int level) {
  float nearness = nearness_at(level == 0 ? at : (at - 1) << level);  // a target begins one of its pixels before
  if (!(nearness > 0.0)) { return 1.0; }
  float before = (whole.z / nearness - depths.x - dot(depths.yz, offset)) / depths.w;
  return 1.0 / (1.0 + exp(-1.702 * before));  // close to the normal distribution
}

#endif
`;

/**
 * Fragment shader, behind resolve.glsl: a scene as a layer of the picture, with the mean proximity and its standard
 * deviation.
 */
export const LAYER = `
layout(location = 1) out vec4 proximity_out;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * supersampling;
  vec4 sum = vec4(0.0);
  vec2 moments = vec2(0.0);
  for (int k = 0; k < supersampling * supersampling; k++) {
    vec4 weights;
    vec4 one = resolved(first + ivec2(k % supersampling, k / supersampling), weights);
    sum += one;
    moments += one.a * weights.gb / max(weights.r, 1e-12 * weight_scale);
  }
  moments /= max(sum.a, 1e-6);
  color_out = (1.0 - whole.w) * sum / float(supersampling * supersampling);
  proximity_out = vec4(moments.x, sqrt(max(moments.y - moments.x * moments.x, 0.0)), 0.0, 0.0);
}
`;

/** Composites the layers of a pixel: `composite` of mobilegs/render/layers.py, which explains it. */
const COMPOSITE = `
uniform highp sampler2DArray layer_colors;
uniform highp sampler2DArray layer_proximities;
uniform int layers;

const float EXTENT = 0.4;
const float TRANSMITTANCE_MIN = 1e-4;
const float THIN = 1e-4;

vec4 composite(ivec2 at, out float proximity) {
  vec3 colors[${MOST_LAYERS}];
  vec3 slabs[${MOST_LAYERS}];  // the nearer end, the farther end, optical depth per proximity
  float edge = -1.0;
  for (int i = 0; i < layers; i++) {
    vec4 color = texelFetch(layer_colors, ivec3(at, i), 0);
    vec2 found = texelFetch(layer_proximities, ivec3(at, i), 0).rg;
    vec2 slab = vec2(found.x * (1.0 + THIN) + EXTENT * found.y, max(found.x * (1.0 - THIN) - EXTENT * found.y, 0.0));
    colors[i] = color.rgb / max(color.a, TRANSMITTANCE_MIN);
    slabs[i] = vec3(slab, -log(max(1.0 - color.a, TRANSMITTANCE_MIN)) / max(slab.x - slab.y, 1e-9));
    if (!(color.a > 0.0)) { slabs[i] = vec3(-1.0); }
    edge = max(edge, slabs[i].x);
  }
  vec3 image = vec3(0.0);
  float left = 1.0;
  proximity = 0.0;
  while (edge > 0.0) {
    float next = -1.0;
    for (int i = 0; i < layers; i++) {
      if (slabs[i].x < edge) { next = max(next, slabs[i].x); }
      if (slabs[i].y < edge) { next = max(next, slabs[i].y); }
    }
    if (next < 0.0) { break; }
    vec3 color = vec3(0.0);
    float total = 0.0;
    for (int i = 0; i < layers; i++) {
      if (slabs[i].x < edge || slabs[i].y > next) { continue; }
      float part = slabs[i].z * (edge - next);
      color += part * colors[i];
      total += part;
    }
    float share = left * (1.0 - exp(-total));
    image += share * color / max(total, 1e-12);
    proximity += share * 0.5 * (edge + next);
    left -= share;
    edge = next;
  }
  proximity /= max(1.0 - left, 1e-6);
  return vec4(image, 1.0 - left);
}
`;

/**
 * Fragment shader, behind resolve.glsl: draws the sums over the framebuffer, with alpha.
 *
 * LINEAR: the framebuffer has linear colours, which are mixed with the sums as they are displayed. EDGES: it has
 * several samples per pixel, of which an opaque mesh may cover some; one draw is for those and another for the rest,
 * each with the sums of a neighbour that the mesh covers, or not. DEPTH: writes the mean depth instead. LAYERS: the
 * picture has several.
 */
export const OVER = `${NEARNESS_AT}
#ifdef LAYERS
${COMPOSITE}
#endif
uniform sampler2D picture;  // a copy of the framebuffer, if it has linear colours
uniform bool behind_edges;  // whether samples behind the edges of opaque meshes are drawn

vec3 displayed(vec3 c) {
  return mix(1.055 * pow(max(c, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}

vec3 linear(vec3 c) {
  return mix(pow(max(c + 0.055, vec3(0.0)) / 1.055, vec3(2.4)), c / 12.92, vec3(lessThanEqual(c, vec3(0.04045))));
}

// The depth in the framebuffer of a nearness.
float depth_of(float nearness) {
  float found = to_nearness.w > 0.0
      ? log2(1.0 + to_nearness.x / nearness) / to_nearness.w
      : (nearness - to_nearness.y) / to_nearness.x;
  return clamp(found, 0.0, 1.0);
}

void main() {
  ivec2 at = (ivec2(gl_FragCoord.xy) - first) * supersampling;
#ifdef EDGES
  vec2 range = vec2(2.0, -1.0);
  ivec2 nearest, farthest;
  for (int k = 0; k < 9; k++) {
    ivec2 next = clamp(at + supersampling * (ivec2(k % 3, k / 3) - 1), ivec2(0), ivec2(size.xy) - 1);
    float nearness = nearness_at(next);
    if (nearness > range.y) { nearest = next; }
    if (nearness < range.x) { farthest = next; }
    range = vec2(min(range.x, nearness), max(range.y, nearness));
  }
  bool edge = range.x < 0.95 * range.y;
  if (behind_edges && !edge) { discard; }
  if (edge) { at = (behind_edges ? farthest : nearest) / supersampling * supersampling; }
  gl_FragDepth = edge ? depth_of(0.5 * (range.x + range.y)) : to_nearness.z;
#endif
#ifdef LAYERS
  float proximity;
  vec4 sum = composite(at / supersampling, proximity);
#else
  vec4 sum = vec4(0.0);
  vec4 weights;
  for (int k = 0; k < supersampling * supersampling; k++) {
    sum += resolved(at + ivec2(k % supersampling, k / supersampling), weights);
  }
  sum *= (1.0 - whole.w) / float(supersampling * supersampling);
  float proximity = weights.g / weights.r;
#endif
#ifdef DEPTH
  if (!(sum.a > 0.5)) { discard; }
  proximity /= PROXIMITY_SCALE;
  gl_FragDepth = depth_of(proximity * proximity);
#endif
#ifdef LINEAR
  // blending adds what is left of the target
  vec4 behind = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
  float rest = 1.0 - sum.a;
  float alpha = sum.a + rest * behind.a;
  vec3 mixed = sum.rgb + rest * behind.a * displayed(behind.rgb / max(behind.a, 1e-6));
  sum.rgb = alpha * linear(mixed / max(alpha, 1e-6)) - rest * behind.rgb;
#endif
  color_out = sum;
}
`;
