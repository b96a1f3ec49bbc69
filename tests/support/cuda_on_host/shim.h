// The part of CUDA C++ that cuda.cu needs, for a host compiler. Every CUDA thread is a fiber;
// barriers, votes and shuffles switch fibers.
#pragma once
#include <math.h>
#include <stdint.h>

#define __CUDACC__ 1
#define __device__
#define __global__
#define __grid_constant__
#define __forceinline__ inline __attribute__((always_inline))
#define __launch_bounds__(...)
#define __shared__ static  // one block runs at a time

struct Index {
  unsigned x;
};
extern Index threadIdx, blockIdx, blockDim, gridDim;

struct alignas(16) float4 {
  float x, y, z, w;
};
struct alignas(8) float2 {
  float x, y;
};
struct alignas(8) short4 {
  short x, y, z, w;
};
inline float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }
inline float2 make_float2(float x, float y) { return {x, y}; }
inline short4 make_short4(short x, short y, short z, short w) { return {x, y, z, w}; }
inline float __fmul_rn(float a, float b) { return a * b; }
inline float __fdividef(float a, float b) { return a / b; }
inline float __fmaf_rn(float a, float b, float c) { return std::fma(a, b, c); }
inline int __float_as_int(float x) {
  int bits;
  __builtin_memcpy(&bits, &x, sizeof(bits));
  return bits;
}
inline float __int_as_float(int bits) {
  float x;
  __builtin_memcpy(&x, &bits, sizeof(x));
  return x;
}
inline int atomicAdd(int* at, int value) {
  int before = *at;
  *at += value;
  return before;
}
inline int __popc(unsigned x) { return __builtin_popcount(x); }
inline int __ffs(unsigned x) { return __builtin_ffs((int)x); }

// Waits for the block or the warp. Returns the values that its threads passed in.
enum class Group { BLOCK, WARP };
const uint32_t* exchange(Group group, const char* what, uint32_t value);

inline void __syncthreads() { exchange(Group::BLOCK, "syncthreads", 0); }
inline void __syncwarp() { exchange(Group::WARP, "syncwarp", 0); }
inline int __syncthreads_or(int value) {
  const uint32_t* all = exchange(Group::BLOCK, "syncthreads_or", value != 0);
  int any = 0;
  for (unsigned i = 0; i < blockDim.x; i++) any |= all[i];
  return any;
}
inline unsigned __ballot_sync(unsigned, int value) {
  const uint32_t* all = exchange(Group::WARP, "ballot", value != 0);
  unsigned bits = 0;
  for (int i = 0; i < 32; i++) bits |= all[i] << i;
  return bits;
}
inline int __any_sync(unsigned mask, int value) { return __ballot_sync(mask, value) != 0; }
template <class T>
inline T shuffled(const char* what, T value, int source) {
  static_assert(sizeof(T) == sizeof(uint32_t));
  union {
    T whole;
    uint32_t bits;
  } mine = {value};
  mine.bits = exchange(Group::WARP, what, mine.bits)[source];
  return mine.whole;
}
template <class T>
inline T __shfl_xor_sync(unsigned, T value, int offset) {
  return shuffled("shfl_xor", value, (threadIdx.x % 32) ^ offset);
}
template <class T>
inline T __shfl_up_sync(unsigned, T value, int offset) {
  int lane = threadIdx.x % 32;
  return shuffled("shfl_up", value, lane < offset ? lane : lane - offset);
}
template <class T>
inline T __shfl_sync(unsigned, T value, int lane) {
  return shuffled("shfl", value, lane);
}
