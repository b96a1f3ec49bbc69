// Draws each Gaussian as the quad around the ellipse where alpha is at least 1/255, as splat.wgsl
// does. In the targets the picture's first row is row 0, so that gl_FragCoord counts as it does.
#ifdef VERTEX

uniform sampler2D splat_axes;    // as project.glsl writes them
uniform sampler2D splat_places;
uniform sampler2D splat_colors;
#ifdef SORTED
uniform usampler2D order;  // far ones first
#endif

flat out vec4 axes;    // offsets in pixels to standard deviations
flat out vec4 color;   // w: weight
flat out vec3 center;  // z: opacity

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // nowhere
  axes = vec4(0.0);
  color = vec4(0.0);
  center = vec3(0.0);
  int place = gl_InstanceID * BATCH + gl_VertexID / 4;
  if (place >= count) { return; }
#ifdef SORTED
  place = int(texelFetch(order, texel(place), 0).r);
#endif
  vec4 where = texelFetch(splat_places, texel(place), 0);
  if (!(where.w > 0.0)) { return; }
  vec4 halves = texelFetch(splat_axes, texel(place), 0);
  vec2 lengths = vec2(dot(halves.xy, halves.xy), dot(halves.zw, halves.zw));
  axes = halves / lengths.xxyy;
  color = texelFetch(splat_colors, texel(place), 0);
  center = where.xyz;
  // a hair wider: rasterisers snap corners to fractions of a pixel
  vec2 reach = where.w + 0.02 * inversesqrt(lengths);
  vec2 side = reach * (vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0);
  vec2 at = where.xy + side.x * halves.xy + side.y * halves.zw;
  gl_Position = vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0);
}

#else

flat in vec4 axes;
flat in vec4 color;
flat in vec3 center;

layout(location = 0) out vec4 color_out;  // sort-free: sum of c a w; a becomes the product of 1 - a
#ifndef SORTED
layout(location = 1) out vec4 weight_out;  // sum of a w
#endif

void main() {
  // from the fragment's own position: interpolated coordinates carry the rasteriser's snapping
  vec2 d = gl_FragCoord.xy - center.xy;
  vec2 q = vec2(dot(axes.xy, d), dot(axes.zw, d));
  float alpha = center.z * exp(-0.5 * dot(q, q));
  alpha = alpha >= ALPHA_MIN ? min(alpha, ALPHA_MAX) : 0.0;
#ifdef SORTED
  color_out = vec4(color.rgb * alpha, alpha);
#else
  float weighted = alpha * color.w;
  color_out = vec4(color.rgb * weighted, alpha);
  weight_out = vec4(weighted, 0.0, 0.0, 0.0);
#endif
}

#endif
