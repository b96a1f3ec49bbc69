// The lane type V of pairs.h: on the CPU a vector of LANES floats, one pixel per lane, in CUDA a
// float. Vectors are GCC/Clang vector extensions: the auto-vectoriser missed a loop and lost 6.5x.
#pragma once

#if defined(__CUDACC_RTC__) || defined(__CUDACC__)
#define MGS_FN __device__ __forceinline__
#define UNROLL _Pragma("unroll")
// a loop of unknown length would move the arrays that it indexes out of the registers
#define FOR_EACH_SH(i, size) UNROLL for (int i = 0; i < 16; i++) if (i < size)
typedef long long int64;
MGS_FN float select(bool mask, float a, float b) { return mask ? a : b; }
MGS_FN float min_of(float a, float b) { return fminf(a, b); }
MGS_FN float max_of(float a, float b) { return fmaxf(a, b); }
MGS_FN float exp2_of(float x) { return exp2f(x); }
MGS_FN float reciprocal(float x) { return __fdividef(1.0f, x); }
MGS_FN float splat_value(float, float x) { return x; }
#else
#include <math.h>
#include <stdint.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif
#define MGS_FN static inline __attribute__((always_inline))
#define FOR_EACH_SH(i, size) for (int i = 0; i < size; i++)
typedef int64_t int64;
#ifndef LANES
#define LANES 4
#endif
typedef float vfloat __attribute__((vector_size(4 * LANES)));
typedef int32_t vint __attribute__((vector_size(4 * LANES)));
typedef float vfloat_unaligned __attribute__((vector_size(4 * LANES), aligned(4), may_alias));
typedef int32_t vint_unaligned __attribute__((vector_size(4 * LANES), aligned(4), may_alias));

MGS_FN float min_of(float a, float b) { return a < b ? a : b; }
MGS_FN float max_of(float a, float b) { return a > b ? a : b; }
MGS_FN vfloat select(vint mask, vfloat a, vfloat b) { return mask ? a : b; }
#if defined(__AVX512F__) && LANES == 16
MGS_FN vfloat min_of(vfloat a, vfloat b) { return (vfloat)_mm512_min_ps((__m512)a, (__m512)b); }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return (vfloat)_mm512_max_ps((__m512)a, (__m512)b); }
MGS_FN vfloat rough_reciprocal(vfloat x) { return (vfloat)_mm512_rcp14_ps((__m512)x); }
#elif defined(__AVX__) && LANES == 8
MGS_FN vfloat min_of(vfloat a, vfloat b) { return (vfloat)_mm256_min_ps((__m256)a, (__m256)b); }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return (vfloat)_mm256_max_ps((__m256)a, (__m256)b); }
MGS_FN vfloat rough_reciprocal(vfloat x) { return (vfloat)_mm256_rcp_ps((__m256)x); }
#else
MGS_FN vfloat min_of(vfloat a, vfloat b) { return a < b ? a : b; }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return a > b ? a : b; }
MGS_FN vfloat rough_reciprocal(vfloat x) { return 1.0f / x; }
#endif
// 1 / x by one Newton step from the 12 or 14 bits of the instruction: a division takes 16 cycles.
MGS_FN vfloat reciprocal(vfloat x) {
  vfloat y = rough_reciprocal(x);
  return y * (2.0f - x * y);
}
MGS_FN vfloat splat_value(vfloat, float x) { return x - (vfloat){}; }
MGS_FN vfloat load(const float* p) { return *(const vfloat_unaligned*)p; }
MGS_FN void store(float* p, vfloat v) { *(vfloat_unaligned*)p = v; }
MGS_FN vint load(const int32_t* p) { return *(const vint_unaligned*)p; }
MGS_FN void store(int32_t* p, vint v) { *(vint_unaligned*)p = v; }
MGS_FN vfloat iota() {
  vfloat v;
  for (int i = 0; i < LANES; i++) v[i] = (float)i;
  return v;
}
typedef float vquad __attribute__((vector_size(16)));
MGS_FN float sum_of(vfloat v) {
  union {
    vfloat whole;
    vquad quads[LANES / 4];
  } u = {v};
  for (int step = LANES / 8; step >= 1; step /= 2)
    for (int i = 0; i < step; i++) u.quads[i] += u.quads[i + step];
  vquad q = u.quads[0];
  return (q[0] + q[2]) + (q[1] + q[3]);
}
// True if any lane of `a` is at least `b`.
MGS_FN bool any_at_least(vfloat a, float b) {
#if defined(__AVX512F__) && LANES == 16
  return _mm512_cmp_ps_mask((__m512)a, _mm512_set1_ps(b), _CMP_GE_OQ) != 0;
#elif defined(__AVX__) && LANES == 8
  return _mm256_movemask_ps(_mm256_cmp_ps((__m256)a, _mm256_set1_ps(b), _CMP_GE_OQ)) != 0;
#else
  bool any = false;
  for (int i = 0; i < LANES; i++) any |= a[i] >= b;
  return any;
#endif
}
// 2^x for x <= 0 with a relative error of 2.4e-7; results below 2^-24 become about 2^-24.
// Adding 1.5 * 2^23 leaves the rounded integer in the low bits of the sum.
MGS_FN vfloat exp2_of(vfloat x) {
  x = max_of(x, splat_value(x, -24.0f));
  vfloat shifted = x + 12582912.0f;
  vfloat f = x - (shifted - 12582912.0f);
  vfloat p = f * 1.327647174e-3f + 9.675541540e-3f;
  p = p * f + 5.550713276e-2f;
  p = p * f + 2.402211972e-1f;
  p = p * f + 6.931469671e-1f;
  p = p * f + 1.0f;
  return (vfloat)((vint)p + ((vint)shifted << 23));
}
#endif
