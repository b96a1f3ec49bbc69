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
extern Index threadIdx, blockIdx, blockDim;

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
inline float __fdividef(float a, float b) { return a / b; }
inline int __popc(unsigned x) { return __builtin_popcount(x); }
inline int __ffs(unsigned x) { return __builtin_ffs((int)x); }

// Waits for the block or the warp. Returns the values that its threads passed in.
enum class Group { BLOCK, WARP };
const uint32_t* exchange(Group group, const char* what, uint32_t value);

inline void __syncthreads() { exchange(Group::BLOCK, "syncthreads", 0); }
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
inline T __shfl_xor_sync(unsigned, T value, int offset) {
  static_assert(sizeof(T) == sizeof(uint32_t));
  union {
    T whole;
    uint32_t bits;
  } mine = {value};
  const uint32_t* all = exchange(Group::WARP, "shfl_xor", mine.bits);
  mine.bits = all[(threadIdx.x % 32) ^ offset];
  return mine.whole;
}
