// The finest sampling interval of any camera at each mean. The reference, with the formula, is
// sampling_intervals in train/sampling.py.
#include "lanes.h"
#include "parallel.h"

#include <algorithm>
#include <cmath>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int BLOCK = 64 * LANES;  // means at a time, which stay in the first cache

// A camera as `packed` in train/sampling.py writes it. Borders are x / z of the image's sides.
struct Sampler {
  float rotation[3][3], translation[3];
  float left, right, top, bottom, near, interval;
};

// One column for each coordinate, so that a load reads LANES means.
struct Block {
  float position[3][BLOCK], finest[BLOCK];
};

void refine(Block& block, const Sampler& c, int count) {
  for (int i = 0; i < count; i += LANES) {
    vfloat p[3], at[3];
    for (int k = 0; k < 3; k++) p[k] = load(block.position[k] + i);
    for (int k = 0; k < 3; k++)
      at[k] = c.rotation[k][0] * p[0] + c.rotation[k][1] * p[1] + c.rotation[k][2] * p[2] +
              c.translation[k];
    vfloat x = at[0], y = at[1], z = at[2], best = load(block.finest + i);
    vint seen = (z > c.near) & (x > c.left * z) & (x < c.right * z);
    seen &= (y > c.top * z) & (y < c.bottom * z);
    store(block.finest + i, select(seen, min_of(best, z * c.interval), best));
  }
}

}  // namespace

EXPORT void mgs_sampling_intervals(int count, const float* means, int cameras,
                                   const float* packed, float* finest) {
  const Sampler* samplers = (const Sampler*)packed;
  parallel_for(count, BLOCK, [&](int64 from, int64 to) {
    Block block = {};
    int held = to - from;
    for (int i = 0; i < held; i++)
      for (int k = 0; k < 3; k++) block.position[k][i] = means[3 * (from + i) + k];
    std::fill(block.finest, block.finest + BLOCK, INFINITY);
    for (int c = 0; c < cameras; c++) refine(block, samplers[c], held);
    std::copy(block.finest, block.finest + held, finest + from);
  });
}
