// Reads packed scenes (render/pack.js), as packed.wgsl does.
uniform usampler2D shapes;

vec4 bytes_of(uint word) {
  int w = int(word);
  return vec4(ivec4(w << 24, w << 16, w << 8, w) >> 24) / 127.0;
}

// The scale of bytes: exponent and three mantissa bits of a float, from 2^-16 on.
float scale_of(uint byte) { return uintBitsToFloat(((byte & 255u) + 888u) << 20); }

Shape shape_of(int i) {
  uvec4 words = texelFetch(shapes, texel(i), 0);
  vec3 stored = vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
  vec3 steps = vec3(uvec3(words.z, words.z >> 11, words.z >> 22) & uvec3(2047u, 2047u, 1023u));
  // the bits of a float approximate its logarithm
  vec3 scales = uintBitsToFloat(uvec3(scale_bits.x + scale_bits.y * steps / vec3(2047.0, 2047.0, 1023.0)));
  // the largest component of a unit quaternion follows from the others
  int w = int(words.w);
  vec3 q = vec3(ivec3(w << 2, w << 12, w << 22) >> 22) * (0.7071067811865476 / 511.0);
  float rest = sqrt(max(0.0, 1.0 - dot(q, q)));
  uint largest = words.w >> 30;
  vec4 r = largest == 0u ? vec4(rest, q) : largest == 1u ? vec4(q.x, rest, q.yz)
      : largest == 2u ? vec4(q.xy, rest, q.z) : vec4(q, rest);  // w, x, y, z
  vec3 a = vec3(1.0 - 2.0 * (r.z * r.z + r.w * r.w), 2.0 * (r.y * r.z + r.x * r.w),
      2.0 * (r.y * r.w - r.x * r.z));
  vec3 b = vec3(2.0 * (r.y * r.z - r.x * r.w), 1.0 - 2.0 * (r.y * r.y + r.w * r.w),
      2.0 * (r.z * r.w + r.x * r.y));
  vec3 c = vec3(2.0 * (r.y * r.w + r.x * r.z), 2.0 * (r.z * r.w - r.x * r.y),
      1.0 - 2.0 * (r.y * r.y + r.z * r.z));
  return Shape(frame.xyz + frame.w * stored, mat3(a * scales.x, b * scales.y, c * scales.z));
}

#ifdef VERTEX

uniform usampler2D looks;

Look look_of(int i) {
  uvec2 look = texelFetch(looks, texel(i), 0).rg;
  uvec3 rgb = uvec3(look.x, look.x >> 9, look.x >> 18) & uvec3(511u);
  return Look(
      vec3(rgb) * exp2(float(look.x >> 27) - 24.0), unpackHalf2x16(look.y).y,
      float(look.y & 65535u) / 65535.0);
}

#else

uniform usampler2D colors;
uniform usampler2D lobes;
layout(location = 0) out uvec2 look_out;

vec3 color_along(int i, float basis[16]) {
  uvec4 words = texelFetch(colors, texel(i), 0);
  vec3 constant = vec3(unpackHalf2x16(words.x), unpackHalf2x16(words.y).x);
  float last = bytes_of(words.y).w;
  vec4 one = bytes_of(words.z);
  vec4 two = bytes_of(words.w);
  vec3 sloped = basis[1] * vec3(last, one.xy) + basis[2] * vec3(one.zw, two.x) +
      basis[3] * two.yzw;
  return 0.5 + basis[0] * constant + scale_of(words.y >> 16) * sloped;
}

vec2 two(int word, float a, float b) {
  vec4 pair = bytes_of(texelFetch(lobes, texel(word), 0).r);
  return a * pair.xy + b * pair.zw;
}

// Unrolled: arrays with a variable index are in memory, not in registers.
vec2 lobes_along(int i, float basis[16]) {
  int first = (lobe_size + 2) / 2 * i;
  vec2 sloped = vec2(0.0);
  if (lobe_size > 1) {
    sloped += two(first + 1, basis[1], basis[2]);
    sloped += two(first + 2, basis[3], basis[4]);
  }
  if (lobe_size > 4) {
    sloped += two(first + 3, basis[5], basis[6]);
    sloped += two(first + 4, basis[7], basis[8]);
  }
  if (lobe_size > 9) {
    sloped += two(first + 5, basis[9], basis[10]);
    sloped += two(first + 6, basis[11], basis[12]);
    sloped += two(first + 7, basis[13], basis[14]);
    sloped += two(first + 8, basis[15], 0.0);
  }
  uint word = texelFetch(shapes, texel(i), 0).y;
  return basis[0] * unpackHalf2x16(texelFetch(lobes, texel(first), 0).r) +
      vec2(scale_of(word >> 16), scale_of(word >> 24)) * sloped;
}

void keep(Look look) {
  float most = clamp(max(look.color.r, max(look.color.g, look.color.b)), 1e-4, 6e4);
  float exponent = floor(log2(most)) + 1.0;  // most < 2^exponent
  uvec3 rgb = uvec3(min(look.color, vec3(6e4)) * exp2(9.0 - exponent) + 0.5);
  rgb = min(rgb, uvec3(511u));
  look_out = uvec2(
      rgb.r | rgb.g << 9 | rgb.b << 18 | uint(exponent + 15.0) << 27,
      uint(look.opacity * 65535.0 + 0.5) | packHalf2x16(vec2(0.0, min(look.weight, 6e4))));
}

#endif
