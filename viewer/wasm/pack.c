/*
 * Words of a block of Gaussians for the renderers, four Gaussians at a time: pack.js has the reference,
 * and says what the words hold.
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

INLINE v128_t larger(v128_t most, v128_t value) { return wasm_f32x4_max(most, wasm_f32x4_abs(value)); }

/* The bits of the nearest float16, ties to even; at most 65504. float16.js has the reference. */
INLINE v128_t to_float16(v128_t x) {
  v128_t bits = x & INTEGERS(0x7fffffff);
  v128_t sign = wasm_u32x4_shr(x, 16) & INTEGERS(0x8000);
  v128_t subnormal = wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_nearest(wasm_f32x4_mul(bits, FLOATS(0x1p24f))));
  v128_t odd = wasm_u32x4_shr(bits, 13) & INTEGERS(1);
  v128_t sum = wasm_i32x4_add(wasm_i32x4_add(bits, INTEGERS(0xfff)), odd);
  v128_t normal = wasm_u32x4_shr(wasm_i32x4_sub(sum, INTEGERS(0x38000000)), 13);
  normal = wasm_i32x4_min(normal, INTEGERS(0x7bff));
  return sign | wasm_v128_bitselect(subnormal, normal, wasm_i32x4_lt(bits, INTEGERS(0x38800000)));
}

/* Two float16 in a word. */
INLINE v128_t float16_pair(v128_t low, v128_t high) {
  return to_float16(low) | wasm_i32x4_shl(to_float16(high), 16);
}

/* The byte of the least scale that reaches `most`: an exponent and three bits of the fraction. */
INLINE v128_t scale_byte(v128_t most) {
  v128_t byte = wasm_u32x4_shr(wasm_i32x4_add(most, INTEGERS(0xfffff)), 20);
  byte = wasm_i32x4_sub(byte, INTEGERS(LEAST_SCALE));
  return wasm_i32x4_min(wasm_i32x4_max(byte, INTEGERS(0)), INTEGERS(255));
}

/* The factor that brings the scale of a byte to 127. */
INLINE v128_t scale_factor(v128_t byte) {
  return wasm_f32x4_div(FLOATS(127), wasm_i32x4_shl(wasm_i32x4_add(byte, INTEGERS(LEAST_SCALE)), 20));
}

/* value * factor as a signed byte, in the low 8 bits. */
INLINE v128_t signed_byte(v128_t value, v128_t factor) {
  v128_t scaled = clamped(wasm_f32x4_mul(factor, value), FLOATS(-127), FLOATS(127));
  return wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_add(scaled, FLOATS(512.5f))) & INTEGERS(255);
}

/* A column's numbers for four Gaussians. */
INLINE v128_t column(const float *block, uint32_t i) { return wasm_v128_load(block + i * BLOCK); }

/* Stores a word for each of four Gaussians, `stride` words apart. */
INLINE void store(uint32_t *to, uint32_t stride, v128_t value) {
  wasm_v128_store32_lane(to, value, 0);
  wasm_v128_store32_lane(to + stride, value, 1);
  wasm_v128_store32_lane(to + 2 * stride, value, 2);
  wasm_v128_store32_lane(to + 3 * stride, value, 3);
}

/* The word of the standard deviations: steps of their bits, from `least_bits` on. */
INLINE v128_t sizes_word(const float *scales, float least_bits, float grow_bits) {
  v128_t word = INTEGERS(0);
  for (int axis = 2; axis >= 0; axis--) {
    v128_t bits = wasm_f32x4_convert_i32x4(column(scales, axis));
    v128_t share = wasm_f32x4_mul(wasm_f32x4_sub(bits, wasm_f32x4_splat(least_bits)), wasm_f32x4_splat(grow_bits));
    v128_t steps = axis < 2 ? FLOATS(2047) : FLOATS(1023); /* STEPS of pack.js */
    share = wasm_f32x4_mul(steps, clamped(share, FLOATS(0), FLOATS(1)));
    word = wasm_i32x4_shl(word, 11) | wasm_i32x4_trunc_sat_f32x4(wasm_f32x4_add(share, FLOATS(0.5f)));
  }
  return word;
}

/* The largest of a quaternion's four numbers in absolute value, and which it is. */
INLINE v128_t largest_number(const float *quats, v128_t *index) {
  v128_t largest = column(quats, 0);
  *index = INTEGERS(0);
  for (int i = 1; i < 4; i++) {
    v128_t number = column(quats, i);
    v128_t above = wasm_f32x4_gt(wasm_f32x4_abs(number), wasm_f32x4_abs(largest));
    largest = wasm_v128_bitselect(number, largest, above);
    *index = wasm_v128_bitselect(wasm_i32x4_splat(i), *index, above);
  }
  return largest;
}

/* The word of a rotation: which number is the largest, then the three others. */
INLINE v128_t rotation_word(const float *quats, v128_t largest, v128_t index) {
  /* a quaternion and its negative are one rotation */
  v128_t factor = wasm_v128_bitselect(FLOATS(-TURN), FLOATS(TURN), wasm_f32x4_lt(largest, FLOATS(0)));
  v128_t word = index;
  for (int i = 0; i < 3; i++) {
    v128_t behind = wasm_i32x4_le(index, wasm_i32x4_splat(i));
    v128_t number = wasm_v128_bitselect(column(quats, i + 1), column(quats, i), behind);
    number = wasm_f32x4_add(wasm_f32x4_mul(factor, number), FLOATS(1024.5f));
    word = wasm_i32x4_shl(word, 10) | (wasm_i32x4_trunc_sat_f32x4(number) & INTEGERS(1023));
  }
  return word;
}

/* Stores the four words of a colour. */
INLINE void pack_color(const float *sh, uint32_t *words) {
  v128_t most = FLOATS(0);
  for (int i = 3; i < 12; i++) most = larger(most, column(sh, i));
  v128_t byte = scale_byte(most);
  v128_t factor = scale_factor(byte);
  store(words, 4, float16_pair(column(sh, 0), column(sh, 1)));
  v128_t first = wasm_i32x4_shl(signed_byte(column(sh, 3), factor), 24);
  store(words + 1, 4, to_float16(column(sh, 2)) | wasm_i32x4_shl(byte, 16) | first);
  for (int i = 0; i < 2; i++) {
    v128_t word = INTEGERS(0);
    for (int j = 3; j >= 0; j--) {
      word = wasm_i32x4_shl(word, 8) | signed_byte(column(sh, 4 + 4 * i + j), factor);
    }
    store(words + 2 + i, 4, word);
  }
}

/* Stores the words of the lobes; returns the two bytes of their scales. Gaussians that are `hidden` get that logit. */
INLINE v128_t pack_lobes(const float *lobes, uint32_t *words, uint32_t pairs, uint32_t stride, v128_t hidden) {
  v128_t most = FLOATS(0);
  v128_t phi_most = FLOATS(0);
  for (uint32_t i = 1; i <= pairs; i++) {
    most = larger(most, column(lobes, 2 * i));
    phi_most = larger(phi_most, column(lobes, 2 * i + 1));
  }
  v128_t byte = scale_byte(most);
  v128_t factor = scale_factor(byte);
  v128_t phi_byte = scale_byte(phi_most);
  v128_t phi_factor = scale_factor(phi_byte);
  v128_t constant = float16_pair(column(lobes, 0), column(lobes, 1));
  v128_t invisible = (constant & INTEGERS(-65536)) | INTEGERS(INVISIBLE);
  store(words, stride, wasm_v128_bitselect(invisible, constant, hidden));
  for (uint32_t i = 2; i < 2 * pairs + 2; i += 4) {
    v128_t word = INTEGERS(0);
    for (int j = 2; j >= 0; j -= 2) {
      v128_t logit = signed_byte(column(lobes, i + j), factor);
      v128_t phi = signed_byte(column(lobes, i + j + 1), phi_factor);
      word = wasm_i32x4_shl(word, 16) | logit | wasm_i32x4_shl(phi, 8);
    }
    store(++words, stride, word);
  }
  return byte | wasm_i32x4_shl(phi_byte, 8);
}

/*
 * Writes the words of the shapes except for the positions, then of the colours, then of the lobes.
 *
 * Lobes have `pairs` of coefficients after the constant ones, and `stride` words.
 */
void pack(const float *scales, const float *quats, const float *sh, const float *lobes, uint32_t *words,
          uint32_t pairs, uint32_t stride, float least_bits, float grow_bits) {
  uint32_t *lobe_words = words + 8 * BLOCK;
  for (uint32_t row = 0; row < BLOCK; row += 4) {
    v128_t index;
    v128_t largest = largest_number(quats, &index);
    /* a quaternion of zeros hides its Gaussian */
    v128_t hidden = wasm_i32x4_eq(largest & INTEGERS(0x7fffffff), INTEGERS(0));
    v128_t lobe_scales = pack_lobes(lobes, lobe_words, pairs, stride, hidden);
    store(words + 1, 4, wasm_i32x4_shl(lobe_scales, 16));
    store(words + 2, 4, sizes_word(scales, least_bits, grow_bits));
    store(words + 3, 4, rotation_word(quats, largest, index));
    pack_color(sh, words + 4 * BLOCK);
    scales += 4;
    quats += 4;
    sh += 4;
    lobes += 4;
    words += 16;
    lobe_words += 4 * stride;
  }
}
