// A scene in floats, as wide.wgsl has it: of any degree, sorted or not.
uniform sampler2D shapes;  // three texels a Gaussian: half axes in the world; w is the centre

Shape shape_of(int i) {
  vec4 a = texelFetch(shapes, texel(3 * i), 0);
  vec4 b = texelFetch(shapes, texel(3 * i + 1), 0);
  vec4 c = texelFetch(shapes, texel(3 * i + 2), 0);
  return Shape(vec3(a.w, b.w, c.w), mat3(a.xyz, b.xyz, c.xyz));
}

#ifdef VERTEX

uniform sampler2D looks;      // r, g, b, weight
uniform sampler2D opacities;

Look look_of(int i) {
  vec4 color = texelFetch(looks, texel(i), 0);
  return Look(color.rgb, color.w, texelFetch(opacities, texel(i), 0).r);
}

#else

uniform sampler2D colors;  // a texel a coefficient
uniform sampler2D lobes;   // a texel a coefficient: logit of opacity, phi before its ReLU
layout(location = 0) out vec4 look_out;
layout(location = 1) out float opacity_out;

vec3 color_along(int i, float basis[16]) {
  vec3 color = vec3(0.5);
  for (int k = 0; k < sh_size; k++) {
    color += basis[k] * texelFetch(colors, texel(sh_size * i + k), 0).rgb;
  }
  return color;
}

vec2 lobes_along(int i, float basis[16]) {
  vec2 seen = vec2(0.0);
  for (int k = 0; k < lobe_size; k++) {
    seen += basis[k] * texelFetch(lobes, texel(lobe_size * i + k), 0).rg;
  }
  return seen;
}

void keep(Look look) {
  look_out = vec4(look.color, look.weight);
  opacity_out = look.opacity;
}

#endif
