// Fragment shader: computes the colour of a pixel from its sums (paper Eq. 2), as resolve.wgsl, which
// lists the other implementations.
uniform sampler2D color_sums;
uniform sampler2D weight_sums;
uniform int last_row;  // of the picture, where the target's rows count from below; 0 elsewhere
uniform int first_column;  // of the picture in the target

#ifdef LEVELED

// The next coarser target of a level (0: the picture), with the coarser ones, and its first pixel in its texture.
#ifndef LEVEL
#define LEVEL 0
#endif
#if LEVEL == 2
#define coarse_colors color_sums
#define coarse_weights weight_sums
#elif LEVEL == 1
uniform sampler2D color_sums_2;
uniform sampler2D weight_sums_2;
#define coarse_colors color_sums_2
#define coarse_weights weight_sums_2
#else
uniform sampler2D color_sums_1;
uniform sampler2D weight_sums_1;
#define coarse_colors color_sums_1
#define coarse_weights weight_sums_1
#endif

// Adds the next coarser target, enlarged twice, at a pixel of one that begins `begin` pixels before the
// picture. Same formula: enlarge in mobilegs/render/levels.py, enlarged in resolve.wgsl.
void add_enlarged(ivec2 pixel, int begin, inout vec4 color, inout vec4 weights) {
  ivec2 coarse_from = LEVEL == 2 ? ivec2(regions[3].xy) : ivec2(0);
  ivec2 at = pixel - begin;
  ivec2 nearest = (at >> 1) + 1;
  ivec2 other = nearest + 2 * (at & 1) - 1 + coarse_from;
  nearest += coarse_from;
  ivec2 b = ivec2(other.x, nearest.y);
  ivec2 c = ivec2(nearest.x, other.y);
  vec4 coarse = 0.5625 * texelFetch(coarse_colors, nearest, 0) + 0.1875 * texelFetch(coarse_colors, b, 0) +
      0.1875 * texelFetch(coarse_colors, c, 0) + 0.0625 * texelFetch(coarse_colors, other, 0);
  color = vec4(color.rgb + coarse.rgb, color.a * coarse.a);
  weights += 0.5625 * texelFetch(coarse_weights, nearest, 0) + 0.1875 * texelFetch(coarse_weights, b, 0) +
      0.1875 * texelFetch(coarse_weights, c, 0) + 0.0625 * texelFetch(coarse_weights, other, 0);
}
#endif

#if defined(LEVELED) && LEVEL > 0

layout(location = 0) out vec4 color_out;
layout(location = 1) out vec4 weight_out;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  ivec2 from = ivec2(regions[LEVEL].xy);
  color_out = texelFetch(color_sums, from + at, 0);
  weight_out = texelFetch(weight_sums, from + at, 0);
  add_enlarged(at, 1, color_out, weight_out);
}

#else

layout(location = 0) out vec4 color_out;

// The colour and alpha of a pixel, and its sums of weights.
vec4 resolved(ivec2 at, out vec4 weights) {
  vec4 sum = texelFetch(color_sums, at, 0);
#ifdef SORTED
  return vec4(sum.rgb + (1.0 - sum.a) * background.rgb, sum.a);
#else
  weights = texelFetch(weight_sums, at, 0);
#ifdef LEVELED
  add_enlarged(at, 0, sum, weights);
#endif
  float weight = weights.r;
  float behind = size.w * weight_scale;
  if (!(weight > 1e-12 * weight_scale)) { return vec4(background.rgb, 1.0 - sum.a); }
  if (weighting == 3) {
    return vec4((behind * background.rgb + sum.rgb) / (behind + weight), 1.0 - sum.a);
  }
  return vec4((1.0 - sum.a) * sum.rgb / weight + sum.a * background.rgb, 1.0 - sum.a);
#endif
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  at = ivec2(at.x - first_column, abs(last_row - at.y));
  vec4 weights;
  if (supersampling == 1) {
    color_out = resolved(at, weights);
    return;
  }
  vec4 sum = vec4(0.0);
  for (int k = 0; k < supersampling * supersampling; k++) {
    sum += resolved(at * supersampling + ivec2(k % supersampling, k / supersampling), weights);
  }
  color_out = sum / float(supersampling * supersampling);
}

#endif
