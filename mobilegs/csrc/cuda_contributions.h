// Contributions in CUDA (render/contributions.py): a block walks a tile's list front to back, one
// thread per pixel, and writes each entry's share of the tile; a second kernel adds these.
#pragma once
#include "cuda_common.h"

namespace {

// Writes each entry's sum of shares (alpha T) and number of pixels to its slot, added in the order
// of the warps. Slots of entries behind the early stop are not written.
MGS_FN void measure_contributions(const View& view, const Splat* splats, const Lists& lists,
                                  float2* slots, int* winner, float* alpha) {
  __shared__ Batch<WALK_BATCH> batch;
  __shared__ float2 parts[WARPS][WALK_BATCH];
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f, t = here.inside ? 1.0f : 0.0f, best = 0;
  int best_id = -1;
  Visits visits = visits_of(lists, blockIdx.x);
  for (int e = visits.first; e < visits.end; e += WALK_BATCH) {
    // also a barrier: all threads have read the previous batch
    if (!__syncthreads_or(t >= TRANSMITTANCE_MIN)) break;
    int count = stage_from(view, batch, visits, e, splats, here.level, false);
    for (int k = lane_of_thread(); k < count; k += WARP)
      parts[warp_of_thread()][k] = make_float2(0, 0);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      if (!__any_sync(ALL, t >= TRANSMITTANCE_MIN)) break;
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k];
        float a = min_of(alpha_at(place, batch.falloff[k], x - place.x, y - place.y), ALPHA_MAX);
        float share = t >= TRANSMITTANCE_MIN ? a * t : 0.0f;
        t -= share;
        if (share > best) best = share, best_id = gaussian_at(visits, e + k);
        float weight = sum_of_lanes(share);
        int pixels = __popc(__ballot_sync(ALL, share > 0));
        if (lane_of_thread() == 0) parts[warp_of_thread()][k] = make_float2(weight, (float)pixels);
      }
    }
    __syncthreads();
    if ((int)threadIdx.x < count) {
      float2 total = make_float2(0, 0);
      for (int w = 0; w < WARPS; w++)
        total.x += parts[w][threadIdx.x].x, total.y += parts[w][threadIdx.x].y;
      slots[lists.slots[e + threadIdx.x]] = total;
    }
  }
  if (!here.inside) return;
  winner[here.at] = best_id;
  alpha[here.at] = 1 - t;
}

}  // namespace
