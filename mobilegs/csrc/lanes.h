// The lane type V of core.h and pairs.h: in CUDA a float, on the CPU a vector of LANES floats, one
// Gaussian or one pixel per lane. Vectors are GCC/Clang vector extensions: the auto-vectoriser missed
// a loop and lost 6.5x.
#pragma once

#if defined(__CUDACC_RTC__) || defined(__CUDACC__)
#define MGS_CUDA 1
#define MGS_FN __device__ __forceinline__
#define MGS_CALL __device__
#define UNROLL _Pragma("unroll")
// a loop of unknown length would move the arrays that it indexes out of the registers
#define FOR_EACH_SH(i, size) UNROLL for (int i = 0; i < 16; i++) if (i < size)
typedef long long int64;
MGS_FN float min_of(float a, float b) { return fminf(a, b); }
MGS_FN float max_of(float a, float b) { return fmaxf(a, b); }
MGS_FN float exp2_of(float x) { return exp2f(x); }
MGS_FN float reciprocal(float x) { return __fdividef(1.0f, x); }
MGS_FN float exp_of(float x) { return expf(x); }
// not fused with a sum that follows
MGS_FN float rounded_product(float a, float b) { return __fmul_rn(a, b); }
// a vector of one lane
constexpr int LANES = 1;
typedef float vfloat, number;
typedef int vint;
MGS_FN float load(const float* p) { return *p; }
MGS_FN float sum_of(float x) { return x; }
MGS_FN int bits_of(float x) { return __float_as_int(x); }
MGS_FN float float_of(int bits) { return __int_as_float(bits); }
#else
#include <math.h>
#include <stdint.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif
#define MGS_FN static inline __attribute__((always_inline))
#define MGS_CALL
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
MGS_FN float exp_of(float x) { return expf(x); }
MGS_FN vfloat select(vint mask, vfloat a, vfloat b) { return mask ? a : b; }
#if defined(__AVX512F__) && LANES == 16
MGS_FN vfloat min_of(vfloat a, vfloat b) { return (vfloat)_mm512_min_ps((__m512)a, (__m512)b); }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return (vfloat)_mm512_max_ps((__m512)a, (__m512)b); }
MGS_FN vfloat rough_reciprocal(vfloat x) { return (vfloat)_mm512_rcp14_ps((__m512)x); }
MGS_FN vfloat sqrt_of(vfloat x) { return (vfloat)_mm512_sqrt_ps((__m512)x); }
MGS_FN vfloat floor_of(vfloat x) { return (vfloat)_mm512_floor_ps((__m512)x); }
#elif defined(__AVX__) && LANES == 8
MGS_FN vfloat min_of(vfloat a, vfloat b) { return (vfloat)_mm256_min_ps((__m256)a, (__m256)b); }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return (vfloat)_mm256_max_ps((__m256)a, (__m256)b); }
MGS_FN vfloat rough_reciprocal(vfloat x) { return (vfloat)_mm256_rcp_ps((__m256)x); }
MGS_FN vfloat sqrt_of(vfloat x) { return (vfloat)_mm256_sqrt_ps((__m256)x); }
MGS_FN vfloat floor_of(vfloat x) { return (vfloat)_mm256_floor_ps((__m256)x); }
#else
MGS_FN vfloat min_of(vfloat a, vfloat b) { return a < b ? a : b; }
MGS_FN vfloat max_of(vfloat a, vfloat b) { return a > b ? a : b; }
MGS_FN vfloat rough_reciprocal(vfloat x) { return 1.0f / x; }
MGS_FN vfloat sqrt_of(vfloat x) {
  for (int i = 0; i < LANES; i++) x[i] = sqrtf(x[i]);
  return x;
}
MGS_FN vfloat floor_of(vfloat x) {
  for (int i = 0; i < LANES; i++) x[i] = floorf(x[i]);
  return x;
}
#endif
// 1 / x by one Newton step from the 12 or 14 bits of the instruction: a division takes 16 cycles.
MGS_FN vfloat reciprocal(vfloat x) {
  vfloat y = rough_reciprocal(x);
  return y * (2.0f - x * y);
}
MGS_FN vfloat splat_value(vfloat, float x) { return x - (vfloat){}; }
MGS_FN vint bits_of(vfloat x) { return (vint)x; }
MGS_FN vfloat float_of(vint bits) { return (vfloat)bits; }
MGS_FN int32_t bits_of(float x) {
  int32_t bits;
  __builtin_memcpy(&bits, &x, sizeof(bits));
  return bits;
}
MGS_FN float float_of(int32_t bits) {
  float x;
  __builtin_memcpy(&x, &bits, sizeof(x));
  return x;
}
MGS_FN vfloat rounded_product(vfloat a, vfloat b) { return a * b; }
MGS_FN vfloat load(const float* p) { return *(const vfloat_unaligned*)p; }
// Joins ROWS parts of a vector, from p, p + step, ...
template <int ROWS>
MGS_FN vfloat load_rows(const float* p, int64 step) {
  if constexpr (ROWS == 1) return load(p);
#if defined(__AVX512F__) && LANES == 16
  if constexpr (ROWS == 2) {
    __m512d first = _mm512_castpd256_pd512(_mm256_loadu_pd((const double*)p));
    return (vfloat)_mm512_insertf64x4(first, _mm256_loadu_pd((const double*)(p + step)), 1);
  }
  if constexpr (ROWS == 4) {
    __m512 v = _mm512_castps128_ps512(_mm_loadu_ps(p));
    v = _mm512_insertf32x4(v, _mm_loadu_ps(p + step), 1);
    v = _mm512_insertf32x4(v, _mm_loadu_ps(p + 2 * step), 2);
    return (vfloat)_mm512_insertf32x4(v, _mm_loadu_ps(p + 3 * step), 3);
  }
#elif defined(__AVX__) && LANES == 8
  if constexpr (ROWS == 2)
    return (vfloat)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p)),
                                        _mm_loadu_ps(p + step), 1);
#endif
  vfloat v;
  for (int i = 0; i < LANES; i++) v[i] = p[i / (LANES / ROWS) * step + i % (LANES / ROWS)];
  return v;
}
MGS_FN void store(float* p, vfloat v) { *(vfloat_unaligned*)p = v; }
MGS_FN vint load(const int32_t* p) { return *(const vint_unaligned*)p; }
MGS_FN void store(int32_t* p, vint v) { *(vint_unaligned*)p = v; }
MGS_FN vfloat iota() {
  vfloat v;
  for (int i = 0; i < LANES; i++) v[i] = (float)i;
  return v;
}
typedef float vquad __attribute__((vector_size(16), may_alias));
// Sums of the lanes i, i + 4, i + 8 and so on, for i from 0 to 3.
MGS_FN vquad quad_of(vfloat v) {
  union {
    vfloat whole;
    vquad quads[LANES / 4];
  } u = {v};
  for (int step = LANES / 8; step >= 1; step /= 2)
    for (int i = 0; i < step; i++) u.quads[i] += u.quads[i + step];
  return u.quads[0];
}
MGS_FN float sum_of(vfloat v) {
  vquad q = quad_of(v);
  return (q[0] + q[2]) + (q[1] + q[3]);
}
// Writes the sums of 12 vectors, as sum_of finds them, to aligned room for 16. Each step adds halves
// of two vectors into one: a third of the instructions of 12 separate sums.
MGS_FN void store_sums(float* p, const vfloat* v) {
#if defined(__AVX512F__) && LANES == 16
  __m512 q[3];  // quads of four vectors each
  for (int i = 0; i < 3; i++, v += 4) {
    __m512 a = (__m512)v[0], b = (__m512)v[1], c = (__m512)v[2], d = (__m512)v[3];
    a = _mm512_shuffle_f32x4(a, b, 0x44) + _mm512_shuffle_f32x4(a, b, 0xee);
    c = _mm512_shuffle_f32x4(c, d, 0x44) + _mm512_shuffle_f32x4(c, d, 0xee);
    q[i] = _mm512_shuffle_f32x4(a, c, 0x88) + _mm512_shuffle_f32x4(a, c, 0xdd);
  }
  __m512 a = _mm512_unpacklo_ps(q[0], q[1]) + _mm512_unpackhi_ps(q[0], q[1]);
  __m512 b = _mm512_unpacklo_ps(q[2], q[2]) + _mm512_unpackhi_ps(q[2], q[2]);
  a = _mm512_shuffle_ps(a, b, 0x44) + _mm512_shuffle_ps(a, b, 0xee);  // by vector modulo 4
  const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
  _mm512_store_ps(p, _mm512_permutexvar_ps(order, a));
#else
  for (int i = 0; i < 3; i++, v += 4, p += 4) {
    vquad a = quad_of(v[0]), b = quad_of(v[1]), c = quad_of(v[2]), d = quad_of(v[3]);
    a = vquad{a[0], b[0], a[1], b[1]} + vquad{a[2], b[2], a[3], b[3]};
    c = vquad{c[0], d[0], c[1], d[1]} + vquad{c[2], d[2], c[3], d[3]};
    *(vquad*)p = vquad{a[0], a[1], c[0], c[1]} + vquad{a[2], a[3], c[2], c[3]};
  }
#endif
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
// 2^(n + f) for |f| <= 1/2 with a relative error of 2.4e-7. `shifted` is n + 1.5 * 2^23, which has the
// integer n in its low bits: adding that number rounds.
MGS_FN vfloat exp2_of_parts(vfloat shifted, vfloat f) {
  vfloat p = f * 1.327647174e-3f + 9.675541540e-3f;
  p = p * f + 5.550713276e-2f;
  p = p * f + 2.402211972e-1f;
  p = p * f + 6.931469671e-1f;
  p = p * f + 1.0f;
  return (vfloat)((vint)p + ((vint)shifted << 23));
}
// 2^x for x <= 0; results below 2^-24 become about 2^-24.
MGS_FN vfloat exp2_of(vfloat x) {
  x = max_of(x, splat_value(x, -24.0f));
  vfloat shifted = x + 12582912.0f;
  return exp2_of_parts(shifted, x - (shifted - 12582912.0f));
}
// e^x for |x| <= 87; others count as 87 or -87.
MGS_FN vfloat exp_of(vfloat x) {
  x = min_of(max_of(x, splat_value(x, -87.0f)), splat_value(x, 87.0f));
  vfloat shifted = x * 1.4426950408889634f + 12582912.0f;
  vfloat f = x * 1.4426950408889634f - (shifted - 12582912.0f);
  return exp2_of_parts(shifted, f + x * 1.92596299e-8f);
}
// log2 x of positive, finite numbers, with a relative error of 2e-7 (the polynomial of Cephes' logf).
MGS_FN vfloat log2_of(vfloat x) {
  vint exponent = ((vint)x - 0x3f3504f3) >> 23;
  vfloat f = (vfloat)((vint)x - (exponent << 23)) - 1.0f, square = f * f;
  vfloat p = f * 7.0376836292e-2f - 1.1514610310e-1f;
  p = p * f + 1.1676998740e-1f;
  p = p * f - 1.2420140846e-1f;
  p = p * f + 1.4249322787e-1f;
  p = p * f - 1.6668057665e-1f;
  p = p * f + 2.0000714765e-1f;
  p = p * f - 2.4999993993e-1f;
  p = p * f + 3.3333331174e-1f;
  p = f + square * (p * f - 0.5f);
  return __builtin_convertvector(exponent, vfloat) + p * 1.4426950408889634f;
}
// a, b, c and d are the rows of a matrix; afterwards its columns.
MGS_FN void transpose(vquad& a, vquad& b, vquad& c, vquad& d) {
#if defined(__x86_64__)
  __m128 p = (__m128)a, q = (__m128)b, r = (__m128)c, s = (__m128)d;
  _MM_TRANSPOSE4_PS(p, q, r, s);
  a = (vquad)p, b = (vquad)q, c = (vquad)r, d = (vquad)s;
#else
  vquad p = {a[0], b[0], c[0], d[0]}, q = {a[1], b[1], c[1], d[1]};
  vquad r = {a[2], b[2], c[2], d[2]}, s = {a[3], b[3], c[3], d[3]};
  a = p, b = q, c = r, d = s;
#endif
}
typedef float vquad_unaligned __attribute__((vector_size(16), aligned(4), may_alias));
typedef float number __attribute__((may_alias));  // rows may be structs
MGS_FN vquad quad_at(const float* p) { return *(const vquad_unaligned*)p; }
MGS_FN void set_quad(float* p, vquad v) { *(vquad_unaligned*)p = v; }
MGS_FN bool any_of(vint mask) {
#if defined(__AVX512F__) && LANES == 16
  return _mm512_test_epi32_mask((__m512i)mask, (__m512i)mask) != 0;
#else
  int any = 0;
  for (int i = 0; i < LANES; i++) any |= mask[i];
  return any != 0;
#endif
}
#endif
// The same for one Gaussian or pixel.
MGS_FN float select(bool mask, float a, float b) { return mask ? a : b; }
MGS_FN float splat_value(float, float x) { return x; }
MGS_FN float log2_of(float x) { return log2f(x); }
MGS_FN float sqrt_of(float x) { return sqrtf(x); }
MGS_FN float floor_of(float x) { return floorf(x); }
MGS_FN bool any_of(bool mask) { return mask; }

MGS_FN int lanes_of(float) { return 1; }
MGS_FN float load_as(const float* p, float) { return *p; }
MGS_FN void store(float* p, float v) { *p = v; }
#ifndef MGS_CUDA
MGS_FN int lanes_of(vfloat) { return LANES; }
MGS_FN vfloat load_as(const float* p, vfloat) { return load(p); }
#endif
// Transpose `many` rows of `width` numbers into `width` rows that lie `stride` apart, and back.
// row_of(i) is the address of row i.
template <class RowOf>
MGS_FN void rows_to_lanes(RowOf row_of, int width, int many, float* lanes, int64 stride) {
  int i = 0;
#ifndef MGS_CUDA
  for (; i + 4 <= many; i += 4) {
    const float *a = row_of(i), *b = row_of(i + 1), *c = row_of(i + 2), *d = row_of(i + 3);
    float* to = lanes + i;
    int k = 0;
    for (; k + 4 <= width; k += 4, to += 4 * stride) {
      vquad p = quad_at(a + k), q = quad_at(b + k), r = quad_at(c + k), s = quad_at(d + k);
      transpose(p, q, r, s);
      set_quad(to, p), set_quad(to + stride, q);
      set_quad(to + 2 * stride, r), set_quad(to + 3 * stride, s);
    }
    for (; k < width; k++, to += stride) to[0] = a[k], to[1] = b[k], to[2] = c[k], to[3] = d[k];
  }
#endif
  for (; i < many; i++) {
    const number* row = row_of(i);
    for (int k = 0; k < width; k++) lanes[k * stride + i] = row[k];
  }
}
template <class RowOf>
MGS_FN void lanes_to_rows(const float* lanes, int64 stride, int width, int many, RowOf row_of) {
  int i = 0;
#ifndef MGS_CUDA
  for (; i + 4 <= many; i += 4) {
    float *a = row_of(i), *b = row_of(i + 1), *c = row_of(i + 2), *d = row_of(i + 3);
    const float* from = lanes + i;
    int k = 0;
    for (; k + 4 <= width; k += 4, from += 4 * stride) {
      vquad p = quad_at(from), q = quad_at(from + stride);
      vquad r = quad_at(from + 2 * stride), s = quad_at(from + 3 * stride);
      transpose(p, q, r, s);
      set_quad(a + k, p), set_quad(b + k, q), set_quad(c + k, r), set_quad(d + k, s);
    }
    for (; k < width; k++, from += stride)
      a[k] = from[0], b[k] = from[1], c[k] = from[2], d[k] = from[3];
  }
#endif
  for (; i < many; i++) {
    number* row = row_of(i);
    for (int k = 0; k < width; k++) row[k] = lanes[k * stride + i];
  }
}
// Number `i` of a Gaussian, or of several: the lanes of a number lie side by side.
template <class V>
MGS_FN V number_at(const float* numbers, int i) {
  return load_as(numbers + i * lanes_of(V{}), V{});
}
template <class V>
MGS_FN void set_number(float* numbers, int i, V value) {
  store(numbers + i * lanes_of(V{}), value);
}
