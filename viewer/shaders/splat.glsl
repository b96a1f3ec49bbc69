// Draws each Gaussian as the quad around the ellipse where alpha is at least alpha_min, as splat.wgsl
// does. In the targets the picture's first row is row 0, so that gl_FragCoord counts as it does.
// Of weighting 4, DEPTH_PASS draws the picture of the depth pass, and VISIBLE is what follows: depth_moments and
// visibility in mobilegs/render/depth_pass.py, with the same constants.
#ifdef VERTEX

#ifdef SORTED
uniform usampler2D order;  // far ones first
#endif

flat out vec4 axes;    // offsets in pixels to standard deviations
flat out vec4 color;   // w: weight
flat out vec4 center;  // z: opacity, w: compensation
#ifdef LEVELED
flat out vec4 region;  // first pixel and end of its level's target
#endif
#ifdef MOMENTS
flat out float proximity;
#endif
#ifdef MESHES
flat out vec4 depths;  // at the centre, its slope per pixel, and its standard deviation beside the slope
flat out int coarseness;  // level
#endif
#ifdef DEPTH_PASS
flat out float log_depth;
const float PASS_BLUR = 2.25;
#endif
#ifdef VISIBLE
flat out vec4 seen;  // from pixels of the target to those of the picture: a factor z, then xy more; w: log_depth
#endif

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // nowhere
  axes = vec4(0.0);
  color = vec4(0.0);
  center = vec4(0.0);
#ifdef LEVELED
  region = vec4(0.0);
#endif
#ifdef MOMENTS
  proximity = 0.0;
#endif
#ifdef MESHES
  depths = vec4(0.0);
  coarseness = 0;
#endif
#ifdef DEPTH_PASS
  log_depth = 0.0;
#endif
#ifdef VISIBLE
  seen = vec4(0.0);
#endif
#ifdef STRIPS
  int i = gl_InstanceID;
#else
  int i = gl_InstanceID * BATCH + gl_VertexID / 4;
#endif
  if (i >= count) { return; }
#ifdef SORTED
  i = int(texelFetch(order, texel(i), 0).r);
#endif
  Look look = look_of(i);
  if (!(look.opacity > 0.0)) { return; }
  Ellipse e = ellipse_of(shape_of(i));
  float opacity = look.opacity;
  vec2 target = size.xy;
  float nearest_depth = e.depth;
#ifdef MOMENTS
  proximity = PROXIMITY_SCALE * sqrt(min(whole.z / e.depth, 1.0));
#endif
#ifdef MESHES
  depths = depths_of(e);
  nearest_depth = nearest_of(e);
#endif
#ifdef DEPTH_PASS
  log_depth = log(e.depth) - log(size.z);
  Ellipse coarse = shrunk(e, 2, -PASS_BLUR);
  opacity *= fading(e, coarse, 2);
  if (!(opacity > scale_bits.z)) { return; }
  e = coarse;
  target = regions[2].zw - regions[2].xy;
#ifdef MESHES
  depths.yz *= 4.0;
  coarseness = 2;
  nearest_depth = whole.z;  // no depth is compared
#endif
#elif defined(LEVELED)
  int level = level_of(e, look.weight / weight_scale);
#ifdef MESHES
  if (level > 0 && partly_hidden(e, opacity, level)) { level = 0; }
  depths.yz *= float(1 << level);
  coarseness = level;
#endif
  if (level > 0) {
    Ellipse coarse = to_level(e, level);
    opacity *= fading(e, coarse, level);
    e = coarse;
  }
  region = regions[level];
#ifdef VISIBLE
  seen.z = 0.25 * float(1 << level);
  seen.xy = 1.0 - seen.z * (region.xy + vec2(level > 0));
#endif
  e.center += region.xy;
  target = whole.xy;
#elif defined(VISIBLE)
  seen.xyz = vec3(1.0, 1.0, 0.25);
#endif
#ifdef VISIBLE
  seen.w = log(e.depth) - log(size.z);
#endif

  // eigenvalues, the smaller one from the determinant; the sum that is the larger one does not cancel
  float skew = 0.5 * (e.variance.x - e.variance.y);
  float cov = e.covariance;
  float root = sqrt(skew * skew + cov * cov);
  float large = 0.5 * (e.variance.x + e.variance.y) + root;
  vec2 way = vec2(1.0, 0.0);
  if (root > 0.0) {
    way = normalize(skew > 0.0 ? vec2(root + skew, cov) : vec2(cov, root - skew));
  }
  vec2 sizes = sqrt(vec2(large, e.determinant / large));
  vec2 across = vec2(-way.y, way.x);
  axes = vec4(way, across) / sizes.xxyy;
  color = vec4(look.color, look.weight);
  center = vec4(e.center, opacity, e.compensation);
  // a hair wider: rasterisers snap corners to fractions of a pixel
  vec2 side = (reach_of(opacity) * sizes + 0.02) *
      (vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
  vec2 at = e.center + side.x * way + side.y * across;
  gl_Position = vec4(at / target * 2.0 - 1.0, min(whole.z / nearest_depth, 1.0), 1.0);
}

#else

flat in vec4 axes;
flat in vec4 color;
flat in vec4 center;
#ifdef LEVELED
flat in vec4 region;
#endif
#ifdef MOMENTS
flat in float proximity;
#endif
#ifdef MESHES
flat in vec4 depths;
flat in int coarseness;
#endif
#ifdef DEPTH_PASS
flat in float log_depth;
#endif
#ifdef VISIBLE
flat in vec4 seen;
uniform sampler2D moments;  // of alpha: the picture of the depth pass
const float DEPTH_FLOOR = 0.02;
const float DEPTH_SLOPE = 0.4;
const float ALPHAS_MIN = 1e-6;
const float ALPHAS_MAX = 16.0;

// The factor of the Gaussian's weight at the pixel.
float visibility() {
  vec3 found = textureLod(moments, (gl_FragCoord.xy * seen.z + seen.xy) / vec2(textureSize(moments, 0)), 0.0).rgb;
  vec2 mean = found.gb / max(found.r, ALPHAS_MIN);
  float deviation = sqrt(max(mean.y - mean.x * mean.x, 0.0));
  return exp(-min(found.r, ALPHAS_MAX) * clamp(DEPTH_SLOPE * (seen.w - mean.x) / (deviation + DEPTH_FLOOR), -0.5, 0.5));
}
#endif

layout(location = 0) out vec4 color_out;  // sort-free: sum of c a w; a becomes the product of 1 - a
#if !defined(SORTED) && !defined(DEPTH_PASS)
layout(location = 1) out vec4 weight_out;  // sum of a w; with MOMENTS also times the proximity and its square
#endif

void main() {
  // from the fragment's own position: interpolated coordinates carry the rasteriser's snapping
  vec2 d = gl_FragCoord.xy - center.xy;
  vec2 q = vec2(dot(axes.xy, d), dot(axes.zw, d));
  float alpha = center.z * exp(-0.5 * dot(q, q));
  float edge = float(soft_edge) * scale_bits.z;
  alpha = alpha >= scale_bits.z ? min(center.w * (alpha - edge), ALPHA_MAX) : 0.0;
#ifdef LEVELED
  // not into the target of another level
  if (any(lessThan(gl_FragCoord.xy, region.xy)) || any(greaterThan(gl_FragCoord.xy, region.zw))) { alpha = 0.0; }
#endif
#ifdef MESHES
#ifdef LEVELED
  alpha *= share_in_front(depths, d, ivec2(gl_FragCoord.xy - region.xy), coarseness);
#else
  alpha *= share_in_front(depths, d, ivec2(gl_FragCoord.xy), coarseness);
#endif
#endif
#ifdef SORTED
  color_out = vec4(color.rgb * alpha, alpha);
#elif defined(DEPTH_PASS)
  color_out = alpha * vec4(1.0, log_depth, log_depth * log_depth, 0.0);
#else
  float weighted = alpha * color.w;
#ifdef VISIBLE
  weighted *= visibility();
#endif
  color_out = vec4(color.rgb * weighted, alpha);
#ifdef MOMENTS
  weight_out = weighted * vec4(1.0, proximity, proximity * proximity, 0.0);
#else
  weight_out = vec4(weighted, 0.0, 0.0, 0.0);
#endif
#endif
}

#endif
