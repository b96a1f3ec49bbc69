/*
 * Words of a block of Gaussians for the renderers, four Gaussians at a time: `defined` of pack.js is
 * the reference, and pack.js says what the words hold.
 */

#include "kernels.h"

/* INVISIBLE and LEAST_SCALE of pack.js. */
enum { INVISIBLE = 0xf0e2, LEAST_SCALE = 8 * (127 - 16) };
/* TURN of pack.js. */
static const float TURN = (float)(511 / 0.7071067811865476);

#define FLOATS(value) wasm_f32x4_const_splat(value)
#define INTEGERS(value) wasm_i32x4_const_splat(value)

INLINE v128_t clamped(v128_t value, v128_t low, v128_t high) {
  return wasm_f32x4_min(wasm_f32x4_max(value, low), high);
}

/* The bits of the nearest float16, ties to even; at most 65504. `toHalf` of half.js. */
INLINE v128_t to_float16(v128_t x) {
  v128_t bits = wasm_v128_and(x, INTEGERS(0x7fffffff));
  v128_t sign = wasm_v128_and(wasm_u32x4_shr(x, 16), INTEGERS(0x8000));
  v128_t subnormal = wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_nearest(wasm_f32x4_mul(bits, FLOATS(0x1p24f))));
  v128_t odd = wasm_v128_and(wasm_u32x4_shr(bits, 13), INTEGERS(1));
  v128_t sum = wasm_i32x4_add(wasm_i32x4_add(bits, INTEGERS(0xfff)), odd);
  v128_t normal = wasm_u32x4_shr(wasm_i32x4_sub(sum, INTEGERS(0x38000000)), 13);
  normal = wasm_i32x4_min(normal, INTEGERS(0x7bff));
  return wasm_v128_or(sign, wasm_v128_bitselect(subnormal, normal, wasm_i32x4_lt(bits, INTEGERS(0x38800000))));
}

/* Two float16 in a word. */
INLINE v128_t float16_pair(v128_t low, v128_t high) {
  return wasm_v128_or(to_float16(low), wasm_i32x4_shl(to_float16(high), 16));
}

/* The byte of the least scale that reaches `most`: exponent and three bits of its fraction. */
INLINE v128_t scale_byte(v128_t most) {
  v128_t byte = wasm_u32x4_shr(wasm_i32x4_add(most, INTEGERS(0xfffff)), 20);
  byte = wasm_i32x4_sub(byte, INTEGERS(LEAST_SCALE));
  return wasm_i32x4_min(wasm_i32x4_max(byte, INTEGERS(0)), INTEGERS(255));
}

/* The factor that brings the scale of a byte to 127. */
INLINE v128_t scale_factor(v128_t byte) {
  return wasm_f32x4_div(FLOATS(127), wasm_i32x4_shl(wasm_i32x4_add(byte, INTEGERS(LEAST_SCALE)), 20));
}

/* The signed byte of value * factor, in the low 8 bits. */
INLINE v128_t signed_byte(v128_t value, v128_t factor) {
  v128_t scaled = clamped(wasm_f32x4_mul(factor, value), FLOATS(-127), FLOATS(127));
  return wasm_v128_and(wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_add(scaled, FLOATS(512.5f))), INTEGERS(255));
}

INLINE v128_t larger(v128_t most, v128_t value) { return wasm_f32x4_max(most, wasm_f32x4_abs(value)); }

/* A number of four Gaussians. */
INLINE v128_t column(const float *block, uint32_t i) { return wasm_v128_load(block + i * BLOCK); }

/* Stores a word of four Gaussians, `stride` words apart. */
INLINE void store(uint32_t *to, uint32_t stride, v128_t value) {
  wasm_v128_store32_lane(to, value, 0);
  wasm_v128_store32_lane(to + stride, value, 1);
  wasm_v128_store32_lane(to + 2 * stride, value, 2);
  wasm_v128_store32_lane(to + 3 * stride, value, 3);
}

/*
 * Writes the words of the shapes, but for the positions, then of the colours, then of the lobes.
 *
 * A Gaussian has `pairs` of coefficients of its lobes after the constant ones, and `stride` words for
 * its lobes. Sizes are steps of the bits of the standard deviations, from `least_bits` on.
 */
void pack(const float *scales, const float *quats, const float *sh, const float *lobes, uint32_t *words,
          uint32_t pairs, uint32_t stride, float least_bits, float grow_bits) {
  uint32_t *lobe_words = words + 8 * BLOCK;
  for (uint32_t row = 0; row < BLOCK; row += 4) {
    /* sizes */
    v128_t sizes = INTEGERS(0);
    for (int axis = 2; axis >= 0; axis--) {
      v128_t bits = wasm_f32x4_convert_i32x4(column(scales, axis));
      v128_t share = wasm_f32x4_mul(wasm_f32x4_sub(bits, wasm_f32x4_splat(least_bits)), wasm_f32x4_splat(grow_bits));
      share = clamped(share, FLOATS(0), FLOATS(1));
      share = wasm_f32x4_add(wasm_f32x4_mul(wasm_f32x4_splat(axis < 2 ? 2047 : 1023), share), FLOATS(0.5f));
      sizes = wasm_v128_or(wasm_i32x4_shl(sizes, 11), wasm_i32x4_trunc_sat_f32x4(share));
    }
    store(words + 2, 4, sizes);

    /* rotation: the number of the largest part, then the three others */
    v128_t largest = column(quats, 0);
    v128_t index = INTEGERS(0);
    for (int i = 1; i < 4; i++) {
      v128_t part = column(quats, i);
      v128_t above = wasm_f32x4_gt(wasm_f32x4_abs(part), wasm_f32x4_abs(largest));
      largest = wasm_v128_bitselect(part, largest, above);
      index = wasm_v128_bitselect(wasm_i32x4_splat(i), index, above);
    }
    v128_t lost = wasm_i32x4_eq(wasm_v128_and(largest, INTEGERS(0x7fffffff)), INTEGERS(0));
    v128_t turn = wasm_v128_bitselect(FLOATS(-TURN), FLOATS(TURN), wasm_f32x4_lt(largest, FLOATS(0)));
    v128_t rotation = index;
    for (int i = 0; i < 3; i++) {
      v128_t behind = wasm_i32x4_le(index, wasm_i32x4_splat(i));
      v128_t part = wasm_f32x4_mul(turn, wasm_v128_bitselect(column(quats, i + 1), column(quats, i), behind));
      part = wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_add(part, FLOATS(1024.5f)));
      rotation = wasm_v128_or(wasm_i32x4_shl(rotation, 10), wasm_v128_and(part, INTEGERS(1023)));
    }
    store(words + 3, 4, rotation);

    /* colour */
    v128_t most = FLOATS(0);
    for (int i = 3; i < 12; i++) most = larger(most, column(sh, i));
    v128_t byte = scale_byte(most);
    v128_t factor = scale_factor(byte);
    uint32_t *colors = words + 4 * BLOCK;
    store(colors, 4, float16_pair(column(sh, 0), column(sh, 1)));
    v128_t word = wasm_v128_or(to_float16(column(sh, 2)), wasm_i32x4_shl(byte, 16));
    word = wasm_v128_or(word, wasm_i32x4_shl(signed_byte(column(sh, 3), factor), 24));
    store(colors + 1, 4, word);
    for (int i = 0; i < 2; i++) {
      word = INTEGERS(0);
      for (int j = 3; j >= 0; j--) {
        word = wasm_v128_or(wasm_i32x4_shl(word, 8), signed_byte(column(sh, 4 + 4 * i + j), factor));
      }
      store(colors + 2 + i, 4, word);
    }

    /* lobes */
    most = FLOATS(0);
    v128_t phi_most = FLOATS(0);
    for (uint32_t i = 1; i <= pairs; i++) {
      most = larger(most, column(lobes, 2 * i));
      phi_most = larger(phi_most, column(lobes, 2 * i + 1));
    }
    byte = scale_byte(most);
    factor = scale_factor(byte);
    v128_t phi_byte = scale_byte(phi_most);
    v128_t phi_factor = scale_factor(phi_byte);
    word = float16_pair(column(lobes, 0), column(lobes, 1));
    /* a quaternion of zeros hides its Gaussian */
    v128_t hidden = wasm_v128_or(wasm_v128_and(word, INTEGERS(-65536)), INTEGERS(INVISIBLE));
    store(lobe_words, stride, wasm_v128_bitselect(hidden, word, lost));
    uint32_t *to = lobe_words;
    for (uint32_t i = 2; i < 2 * pairs + 2; i += 4) {
      word = INTEGERS(0);
      for (int j = 2; j >= 0; j -= 2) {
        v128_t logit = signed_byte(column(lobes, i + j), factor);
        v128_t phi = signed_byte(column(lobes, i + j + 1), phi_factor);
        word = wasm_v128_or(wasm_i32x4_shl(word, 16), wasm_v128_or(logit, wasm_i32x4_shl(phi, 8)));
      }
      store(++to, stride, word);
    }
    store(words + 1, 4, wasm_i32x4_shl(wasm_v128_or(byte, wasm_i32x4_shl(phi_byte, 8)), 16));

    scales += 4;
    quats += 4;
    sh += 4;
    lobes += 4;
    words += 16;
    lobe_words += 4 * stride;
  }
}
