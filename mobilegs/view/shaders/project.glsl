// Fragment shader: projects every Gaussian, as project.wgsl does. A pixel of the three targets is a
// Gaussian: once each, where a vertex shader would project it at each corner.
uniform sampler2D shapes;  // three texels a Gaussian: half axes in the world; w is the centre
uniform sampler2D colors;  // a texel a coefficient
uniform sampler2D lobes;   // a texel a coefficient: logit of opacity, phi before its ReLU

layout(location = 0) out vec4 axes_out;   // half axes of the ellipse, the major first, pixels
layout(location = 1) out vec4 place_out;  // centre in pixels; z: opacity, w: reach
layout(location = 2) out vec4 color_out;  // w: weight

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

float weight_of(float depth, float largest, float phi) {
  if (weighting == 3) { return max(0.0, 1.0 - depth / size.z) * phi; }
  float w = phi * phi;
  if (weighting != 1) { w += phi / (depth * depth); }
  if (weighting != 2) { w += exp(min(largest / depth, background.w)); }
  return w;
}

void main() {
  axes_out = vec4(0.0);
  place_out = vec4(0.0);  // reach stays 0 where the Gaussian cannot touch the picture
  color_out = vec4(0.0);
  int i = int(gl_FragCoord.y) * 4096 + int(gl_FragCoord.x);
  if (i >= count) { return; }

  vec4 a = texelFetch(shapes, texel(3 * i), 0);
  vec4 b = texelFetch(shapes, texel(3 * i + 1), 0);
  vec4 c = texelFetch(shapes, texel(3 * i + 2), 0);
  vec4 mean = vec4(a.w, b.w, c.w, 1.0);
  float z = dot(row_z, mean);
  if (!(z > position.w)) { return; }
  vec2 t = vec2(dot(row_x, mean), dot(row_y, mean)) / z;
  vec2 uv = clamp(t, limits.xz, limits.yw);

  // rows of the projected square root of the covariance
  mat3 axes = mat3(a.xyz, b.xyz, c.xyz);
  vec3 depths = row_z.xyz * axes;
  vec3 px = (lens.x / z) * (row_x.xyz * axes - uv.x * depths);
  vec3 py = (lens.y / z) * (row_y.xyz * axes - uv.y * depths);
  float var_x = dot(px, px) + BLUR;
  float var_y = dot(py, py) + BLUR;
  float cov = dot(px, py);
  // Cauchy-Binet: the determinant as a sum of squares cannot cancel
  vec3 crossed = cross(px, py);
  float det = dot(crossed, crossed) + BLUR * (var_x + var_y - BLUR);

  vec3 away = mean.xyz - position.xyz;
  float basis[16];
  harmonics(max(sh_size, lobe_size), away * inversesqrt(dot(away, away)), basis);
  vec2 seen = vec2(0.0);
  for (int k = 0; k < lobe_size; k++) {
    seen += basis[k] * texelFetch(lobes, texel(lobe_size * i + k), 0).rg;
  }
  float opacity = 1.0 / (1.0 + exp(min(-seen.x, 80.0)));
  if (!(opacity > ALPHA_MIN)) { return; }
  float reach = sqrt(2.0 * log(255.0 * opacity));
  vec2 center = lens.xy * t + lens.zw;
  vec2 box = reach * sqrt(vec2(var_x, var_y));
  if (any(lessThan(center + box, vec2(0.5)))) { return; }
  if (any(greaterThan(center - box, size.xy - 0.5))) { return; }

  // eigenvalues, the smaller one from the determinant; the sum that is the larger one does not cancel
  float skew = 0.5 * (var_x - var_y);
  float root = sqrt(skew * skew + cov * cov);
  float large = 0.5 * (var_x + var_y) + root;
  vec2 way = vec2(1.0, 0.0);
  if (root > 0.0) {
    way = normalize(skew > 0.0 ? vec2(root + skew, cov) : vec2(cov, root - skew));
  }
  vec3 color = vec3(0.5);
  for (int k = 0; k < sh_size; k++) {
    color += basis[k] * texelFetch(colors, texel(sh_size * i + k), 0).rgb;
  }
  float largest = sqrt(max(dot(a.xyz, a.xyz), max(dot(b.xyz, b.xyz), dot(c.xyz, c.xyz))));
  axes_out = vec4(way * sqrt(large), vec2(-way.y, way.x) * sqrt(det / large));
  place_out = vec4(center, opacity, reach);
  color_out = vec4(max(color, vec3(0.0)), weight_of(z, largest, max(seen.y, 0.0)) * weight_scale);
}
