// Reads packed scenes (render/pack.js): 52 bytes per Gaussian with lobes of degree 2, 8 for its look, and 4 for the list.
// x, y | z, two scales of lobes | scales, 11 + 11 + 10 bits | rotation
@group(0) @binding(1) var<storage, read> shapes: array<vec4u>;
// constant r, g | constant b, a scale, first coefficient | eight more
@group(0) @binding(2) var<storage, read> colors: array<vec4u>;
// constants | the other coefficients, logit and phi alternating, four per word
@group(0) @binding(3) var<storage, read> lobes: array<u32>;
// of scenes with a network: what it takes besides the direction, and its results, which are the lobes
// base opacity, first input | the other 18, two per word
@group(0) @binding(4) var<storage, read> inputs: array<u32>;
@group(0) @binding(6) var<storage, read_write> seen: array<u32>;

alias StoredLook = vec2u;  // r, g, b with an exponent | opacity, weight

// The scale of bytes: exponent and three mantissa bits of a float, from 2^-16 on.
fn scale_of(byte: u32) -> f32 { return bitcast<f32>(((byte & 255u) + 888u) << 20u); }

fn shape_of(i: u32) -> Shape {
  let words = shapes[i];
  let xy = unpack2x16float(words.x);
  let mean = view.frame.xyz + view.frame.w * vec3f(xy, unpack2x16float(words.y).x);
  let steps = vec3f(vec3u(words.z, words.z >> 11u, words.z >> 22u) & vec3u(2047u, 2047u, 1023u));
  // the bits of a float approximate its logarithm
  let bits = view.scale_bits.x + view.scale_bits.y * steps / vec3f(2047.0, 2047.0, 1023.0);
  let scales = bitcast<vec3f>(vec3u(bits));
  // the largest component of a unit quaternion follows from the others
  let thirds = vec3i(bitcast<i32>(words.w << 2u), bitcast<i32>(words.w << 12u),
      bitcast<i32>(words.w << 22u)) >> vec3u(22u);
  let q = vec3f(thirds) * (0.7071067811865476 / 511.0);
  let rest = sqrt(max(0.0, 1.0 - dot(q, q)));
  var r = vec4f(rest, q);  // w, x, y, z
  switch words.w >> 30u {
    case 1u: { r = vec4f(q.x, rest, q.yz); }
    case 2u: { r = vec4f(q.xy, rest, q.z); }
    case 3u: { r = vec4f(q, rest); }
    default: {}
  }
  let a = vec3f(1.0 - 2.0 * (r.z * r.z + r.w * r.w), 2.0 * (r.y * r.z + r.x * r.w),
      2.0 * (r.y * r.w - r.x * r.z));
  let b = vec3f(2.0 * (r.y * r.z - r.x * r.w), 1.0 - 2.0 * (r.y * r.y + r.w * r.w),
      2.0 * (r.z * r.w + r.x * r.y));
  let c = vec3f(2.0 * (r.y * r.w + r.x * r.z), 2.0 * (r.z * r.w - r.x * r.y),
      1.0 - 2.0 * (r.y * r.y + r.z * r.z));
  return Shape(mean, mat3x3f(a * scales.x, b * scales.y, c * scales.z));
}

fn color_along(i: u32, basis: array<f32, 16>) -> vec3f {
  let words = colors[i];
  let constant = vec3f(unpack2x16float(words.x), unpack2x16float(words.y).x);
  let last = unpack4x8snorm(words.y).w;
  let one = unpack4x8snorm(words.z);
  let two = unpack4x8snorm(words.w);
  let sloped = basis[1] * vec3f(last, one.xy) + basis[2] * vec3f(one.zw, two.x) +
      basis[3] * two.yzw;
  return 0.5 + basis[0] * constant + scale_of(words.y >> 16u) * sloped;
}

fn two(word: u32, a: f32, b: f32) -> vec2f {
  let pair = unpack4x8snorm(lobes[word]);
  return a * pair.xy + b * pair.zw;
}

// Unrolled: arrays with a variable index are in memory, not in registers.
fn lobes_along(i: u32, basis: array<f32, 16>) -> vec2f {
  let first = (view.lobe_size + 2u) / 2u * i;
  var sloped = vec2f(0.0);
  if (view.lobe_size > 1u) {
    sloped += two(first + 1u, basis[1], basis[2]);
    sloped += two(first + 2u, basis[3], basis[4]);
  }
  if (view.lobe_size > 4u) {
    sloped += two(first + 3u, basis[5], basis[6]);
    sloped += two(first + 4u, basis[7], basis[8]);
  }
  if (view.lobe_size > 9u) {
    sloped += two(first + 5u, basis[9], basis[10]);
    sloped += two(first + 6u, basis[11], basis[12]);
    sloped += two(first + 7u, basis[13], basis[14]);
    sloped += two(first + 8u, basis[15], 0.0);
  }
  let word = shapes[i].y;
  return basis[0] * unpack2x16float(lobes[first]) +
      vec2f(scale_of(word >> 16u), scale_of(word >> 24u)) * sloped;
}

// 12 harmonics, three scales, a quaternion, each of length 1; and the base opacity as a lobe.
fn inputs_of(i: u32) -> array<vec4f, 5> {
  let at = 10u * i;
  let first = inputs[at];
  var pairs: array<vec2f, 9>;
  for (var k = 0u; k < 9u; k++) { pairs[k] = unpack2x16snorm(inputs[at + 1u + k]); }
  return array<vec4f, 5>(
      vec4f(unpack2x16snorm(first).y, pairs[0], pairs[1].x),
      vec4f(pairs[1].y, pairs[2], pairs[3].x),
      vec4f(pairs[3].y, pairs[4], pairs[5].x),
      vec4f(pairs[5].y, pairs[6], pairs[7].x),
      vec4f(pairs[7].y, pairs[8], unpack2x16float(first).x));
}

fn as_lobes(found: vec2f) -> u32 { return pack2x16float(clamp(found, vec2f(-6e4), vec2f(6e4))); }

fn store(look: Look) -> StoredLook {
  let most = clamp(max(look.color.r, max(look.color.g, look.color.b)), 1e-4, 6e4);
  let exponent = floor(log2(most)) + 1.0;  // most < 2^exponent
  let parts = vec3u(min(look.color, vec3f(6e4)) * exp2(9.0 - exponent) + 0.5);
  let rgb = min(parts, vec3u(511u));
  return vec2u(
      rgb.r | (rgb.g << 9u) | (rgb.b << 18u) | (u32(exponent + 15.0) << 27u),
      u32(look.opacity * 65535.0 + 0.5) | pack2x16float(vec2f(0.0, min(look.weight, 6e4))));
}

fn stored(look: StoredLook) -> Look {
  let rgb = vec3u(look.x, look.x >> 9u, look.x >> 18u) & vec3u(511u);
  return Look(
      vec3f(rgb) * exp2(f32(look.x >> 27u) - 24.0), unpack2x16float(look.y).y,
      f32(look.y & 65535u) / 65535.0);
}
