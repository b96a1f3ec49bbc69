// Fragment shader: computes the colour of a pixel from its sums (paper Eq. 2), as resolve.wgsl, which
// lists the other implementations.
uniform sampler2D color_sums;
uniform sampler2D weight_sums;
uniform int last_row;  // of the picture, where the target's rows count from below; 0 elsewhere

out vec4 color_out;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  at.y = abs(last_row - at.y);
  vec4 sum = texelFetch(color_sums, at, 0);
#ifdef SORTED
  color_out = vec4(sum.rgb + (1.0 - sum.a) * background.rgb, sum.a);
#else
  float weight = texelFetch(weight_sums, at, 0).r;
  float behind = size.w * weight_scale;
  if (!(weight > 1e-12 * weight_scale)) {
    color_out = vec4(background.rgb, 1.0 - sum.a);
  } else if (weighting == 3) {
    color_out = vec4((behind * background.rgb + sum.rgb) / (behind + weight), 1.0 - sum.a);
  } else {
    color_out = vec4((1.0 - sum.a) * sum.rgb / weight + sum.a * background.rgb, 1.0 - sum.a);
  }
#endif
}
