/* What the kernels share. A block of Gaussians holds its numbers in columns; pointers come from JavaScript. */

#include <stdint.h>
#include <wasm_simd128.h>

/* Gaussians in a block, and floats in a column; BLOCK of block_memory.js. */
enum { BLOCK = 128 };

#define INLINE static inline __attribute__((always_inline))
