// Fragment shader: computes opacity, weight w and colour of every Gaussian for the camera, as
// project.wgsl. A pixel of the targets is a Gaussian.
// Spherical harmonics in direction d. Same formula: sh_basis in mobilegs/spherical_harmonics.py and
// csrc/core.h, harmonics in project.wgsl.
void harmonics(int size, vec3 d, out float b[16]) {
  for (int k = 0; k < 16; k++) { b[k] = 0.0; }
  b[0] = 0.28209479177387814;
  if (size < 4) { return; }
  const float c1 = 0.4886025119029199;
  b[1] = -c1 * d.y;
  b[2] = c1 * d.z;
  b[3] = -c1 * d.x;
  if (size < 9) { return; }
  vec3 s = d * d;
  b[4] = 1.0925484305920792 * d.x * d.y;
  b[5] = -1.0925484305920792 * d.y * d.z;
  b[6] = 0.31539156525252005 * (2.0 * s.z - s.x - s.y);
  b[7] = -1.0925484305920792 * d.x * d.z;
  b[8] = 0.5462742152960396 * (s.x - s.y);
  if (size < 16) { return; }
  b[9] = -0.5900435899266435 * d.y * (3.0 * s.x - s.y);
  b[10] = 2.890611442640554 * d.x * d.y * d.z;
  b[11] = -0.4570457994644658 * d.y * (4.0 * s.z - s.x - s.y);
  b[12] = 0.3731763325901154 * d.z * (2.0 * s.z - 3.0 * s.x - 3.0 * s.y);
  b[13] = -0.4570457994644658 * d.x * (4.0 * s.z - s.x - s.y);
  b[14] = 1.445305721320277 * d.z * (s.x - s.y);
  b[15] = -0.5900435899266435 * d.x * (s.x - 3.0 * s.y);
}

// The weight w of sort-free blending (paper Eq. 3): w = phi^2 + phi / d^2 + exp(s_max / d), the exponent
// clamped; 3 is the linear form of SortFreeGS. Same formula: Weighting.weights in mobilegs/render/sortfree.py,
// weight_of in csrc/core.h (CPU and CUDA) and in project.wgsl.
float weight_of(float depth, float largest, float phi) {
  if (weighting == 3) { return max(0.0, 1.0 - depth / size.z) * phi; }
  float w = phi * phi;
  if (weighting != 1) { w += phi / (depth * depth); }
  if (weighting != 2) { w += exp(min(largest / depth, background.w)); }
  return w;
}

// Centre and radius of a sphere: Gaussians that reach out of it by two standard deviations are not drawn. Radius 0: all are.
uniform vec4 crop;

Look look_at(int i) {
  Look look = Look(vec3(0.0), 0.0, 0.0);
  if (i >= count) { return look; }
  Shape shape = shape_of(i);
  if (box[0].w > 0.0 && (any(lessThan(shape.mean, box[0].xyz)) || any(greaterThan(shape.mean, box[1].xyz)))) { return look; }
  Ellipse e = ellipse_of(shape);
  if (!(e.depth > position.w) || !(e.compensation > 0.0)) { return look; }
  vec3 away = shape.mean - position.xyz;
  float basis[16];
  harmonics(max(sh_size, lobe_size), away * inversesqrt(dot(away, away)), basis);
  vec2 seen = lobes_along(i, basis);
  float opacity = 1.0 / (1.0 + exp(min(-seen.x, 80.0)));
  if (!(opacity > scale_bits.z)) { return look; }
  vec2 reach = reach_of(opacity) * sqrt(e.variance);
  if (any(lessThan(e.center + reach, vec2(0.5)))) { return look; }
  if (any(greaterThan(e.center - reach, size.xy - 0.5))) { return look; }
  vec3 a = shape.axes[0];
  vec3 b = shape.axes[1];
  vec3 c = shape.axes[2];
  float largest = sqrt(max(dot(a, a), max(dot(b, b), dot(c, c))));
  if (crop.w > 0.0 && distance(shape.mean, crop.xyz) + 2.0 * largest > crop.w) { return look; }
  vec4 color = vec4(color_along(i, basis), 1.0);
  look.color = max(color.rgb + vec3(dot(grade[0], color), dot(grade[1], color), dot(grade[2], color)), vec3(0.0));
  look.weight = weight_of(e.depth, largest, max(seen.y, 0.0)) * weight_scale;
  look.opacity = opacity;
  return look;
}

void main() { keep(look_at(int(gl_FragCoord.y) * 4096 + int(gl_FragCoord.x))); }
