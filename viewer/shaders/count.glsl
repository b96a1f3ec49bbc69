// Fragment shader: the root of a Gaussian's area in pixels, and its level, as count.wgsl. A pixel of the
// target is a Gaussian.
out vec4 found;

void main() {
  found = vec4(0.0);
  int i = int(gl_FragCoord.y) * 4096 + int(gl_FragCoord.x);
  if (i >= count) { return; }
  Look look = look_of(i);
  if (!(look.opacity > 0.0)) { return; }
  Ellipse e = ellipse_of(shape_of(i));
  float opacity = look.opacity;
  vec2 side = size.xy;
#ifdef LEVELED
  int level = level_of(e, look.weight / weight_scale);
  side = regions[level].zw - regions[level].xy;
  if (level > 0) {
    Ellipse coarse = to_level(e, level);
    opacity *= fading(e, coarse, level);
    e = coarse;
  }
  found.y = float(level);
#endif
  float reach = reach_of(max(opacity, scale_bits.z));
  vec2 box = reach * sqrt(e.variance);
  vec2 share = max(min(e.center + box, side) - max(e.center - box, vec2(0.0)), vec2(0.0)) / max(2.0 * box, vec2(1e-9));
  found.x = sqrt(3.14159265 * reach * reach * sqrt(e.determinant) * share.x * share.y);
}
