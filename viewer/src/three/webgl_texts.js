/** Shaders that only three.js needs, in GLSL; each follows view.glsl. */

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

/** For splat.glsl: whether opaque meshes hide one part of a Gaussian and not another. */
export const PARTLY_HIDDEN = `
#define PARTLY_HIDDEN
uniform sampler2D blocks;       // least and largest nearness in blocks of 8 x 8 pixels
uniform sampler2D wide_blocks;  // of 64 x 64

bool partly_hidden(Ellipse e, float opacity, int level) {
  float nearness = min(whole.z / e.depth, 1.0);
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
  return nearness > 0.998 * range.x && nearness < 1.002 * range.y;
}
`;

/**
 * Fragment shader, behind resolve.glsl: draws the sums over the framebuffer, with alpha.
 *
 * LINEAR: the framebuffer has linear colours, which are mixed with the sums as they are displayed. EDGES: it has
 * several samples per pixel, of which an opaque mesh may cover some; one draw is for those and another for the rest,
 * each with the sums of a neighbour that the mesh covers, or not. DEPTH: writes the mean depth instead.
 */
export const OVER = `${NEARNESS_AT}
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

// The sums of weights, and of weights times the nearness, of all levels.
vec2 weights_at(ivec2 at) {
  vec2 sum = texelFetch(weight_sums, at, 0).rg;
#ifdef LEVELED
  for (int level = 1; level < 4; level++) {
    sum += texelFetch(weight_sums, ivec2(regions[level].xy) + (at >> level) + 1, 0).rg;
  }
#endif
  return sum;
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
  vec4 sum = vec4(0.0);
  for (int k = 0; k < supersampling * supersampling; k++) {
    sum += resolved(at + ivec2(k % supersampling, k / supersampling));
  }
  sum /= float(supersampling * supersampling);
#ifdef DEPTH
  if (!(sum.a > 0.5)) { discard; }
  vec2 weights = weights_at(at);
  gl_FragDepth = depth_of(weights.y / weights.x);
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
