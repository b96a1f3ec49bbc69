/* Dense layers and unit vectors: block_memory.js has the reference. */

#include "kernels.h"

/* LENGTH_MIN of block_memory.js. */
static const float LENGTH_MIN = 1e-12f;

/*
 * y = max(s, slope * s) with s = weights * x + offsets.
 *
 * Four outputs of eight Gaussians are summed in registers, so that a loaded number is used four or
 * eight times. `outputs` is a multiple of 4; `weights` holds four outputs together, input by input.
 * Each sum adds the inputs in their order to the offset, as the reference does.
 */
void layer(const float *weights, const float *offsets, const float *x, float *y, uint32_t inputs,
           uint32_t outputs, float slope) {
  v128_t slopes = wasm_f32x4_splat(slope);
  for (const float *last = offsets + outputs; offsets < last; offsets += 4) {
    const float *end = weights + 4 * inputs;
    for (uint32_t row = 0; row < BLOCK; row += 8) {
      v128_t sums[4][2];
      for (int j = 0; j < 4; j++) sums[j][0] = sums[j][1] = wasm_v128_load32_splat(offsets + j);
      const float *from = x + row;
      for (const float *weight = weights; weight < end; weight += 4, from += BLOCK) {
        v128_t x0 = wasm_v128_load(from);
        v128_t x1 = wasm_v128_load(from + 4);
        for (int j = 0; j < 4; j++) {
          v128_t w = wasm_v128_load32_splat(weight + j);
          sums[j][0] = wasm_f32x4_add(sums[j][0], wasm_f32x4_mul(w, x0));
          sums[j][1] = wasm_f32x4_add(sums[j][1], wasm_f32x4_mul(w, x1));
          /* load the next weight only now: all four at once take more registers than there are */
          __asm__ volatile("" ::: "memory");
        }
      }
      for (int j = 0; j < 4; j++) {
        for (int k = 0; k < 2; k++) {
          v128_t sum = sums[j][k];
          wasm_v128_store(y + row + j * BLOCK + 4 * k, wasm_f32x4_max(sum, wasm_f32x4_mul(sum, slopes)));
        }
      }
    }
    weights = end;
    y += 4 * BLOCK;
  }
}

/* Divides the `width` numbers of each Gaussian, at least one, by their length; x and y may be the same block. */
void units(const float *x, float *y, uint32_t width) {
  const float *end = x + width * BLOCK;
  for (uint32_t row = 0; row < BLOCK; row += 4) {
    v128_t sum = wasm_f32x4_const_splat(0);
    const float *from = x + row;
    do {
      v128_t value = wasm_v128_load(from);
      sum = wasm_f32x4_add(sum, wasm_f32x4_mul(value, value));
      from += BLOCK;
    } while (from < end);
    v128_t length = wasm_f32x4_max(wasm_f32x4_sqrt(sum), wasm_f32x4_const_splat(LENGTH_MIN));
    v128_t factor = wasm_f32x4_div(wasm_f32x4_const_splat(1), length);
    from = x + row;
    float *to = y + row;
    do {
      wasm_v128_store(to, wasm_f32x4_mul(wasm_v128_load(from), factor));
      from += BLOCK;
      to += BLOCK;
    } while (from < end);
  }
}
