// Sorted blending in CUDA (render/sorted.py): C = sum(c a T) + T_end bg, T = prod(1 - a) over the
// Gaussians in front (3DGS, Eq. 3). A block per tile, forward and backward, front to back until
// T < 1e-4.
#pragma once
#include "cuda_common.h"

namespace {

template <bool DEPTH>
MGS_FN void sorted_forward(const View& view, const Splat* splats, const Lists& lists,
                           const Outputs& out) {
  __shared__ Batch<THREADS> batch;
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f;
  float r = 0, g = 0, b = 0, z = 0, t = here.inside ? 1.0f : 0.0f;
  Visits visits = visits_of(lists, blockIdx.x);
  for (int e = visits.first; e < visits.end; e += THREADS) {
    // also a barrier: all threads have read the previous batch
    if (!__syncthreads_or(t >= TRANSMITTANCE_MIN)) break;
    int count = stage_from(view, batch, visits, e, splats, here.level, false);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      if (!__any_sync(ALL, t >= TRANSMITTANCE_MIN)) break;
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        float alpha = min_of(alpha_at(place, falloff, x - place.x, y - place.y), ALPHA_MAX);
        float share = t >= TRANSMITTANCE_MIN ? alpha * t : 0.0f;
        r += share * color.x, g += share * color.y, b += share * color.z;
        if (DEPTH) z += share * color.w;
        t -= share;
      }
    }
  }
  if (!here.inside) return;
  int64 at = here.at, plane = pixel_count(view);
  const float values[5] = {r, g, b, t, z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 5 : 4); k++) out.sums[k * plane + at] = values[k];
  UNROLL
  for (int k = 0; k < 3; k++) out.image[3 * at + k] = values[k] + t * view.background[k];
  out.alpha[at] = 1 - t;
  if (DEPTH) out.depth[at] = z;
}

// State of one pixel in the backward pass, which goes front to back like the forward pass.
struct Walk {
  float x, y;        // pixel centre
  float r, g, b, z;  // dL/d image and depth
  float rest;        // part of the loss gradient due to the Gaussians behind and the background
  float t;           // transmittance; 0 outside the image
};

template <bool DEPTH>
MGS_FN Walk start_walk(const View& view, const ThreadPixel& here, const float* sums,
                       const OutputGradients& in) {
  Walk w = {here.x + 0.5f, here.y + 0.5f, 0, 0, 0, 0, 0, 0};
  if (!here.inside) return w;
  int64 at = here.at, plane = pixel_count(view);
  const float *p = sums + at, *g = in.image + 3 * at;
  float t = p[3 * plane];
  w.t = 1;
  if (in.image) w.r = g[0], w.g = g[1], w.b = g[2];
  w.rest = -(in.alpha ? in.alpha[at] : 0.0f) * t + w.r * (p[0] + t * view.background[0]) +
           w.g * (p[plane] + t * view.background[1]) +
           w.b * (p[2 * plane] + t * view.background[2]);
  if (DEPTH && in.depth) w.z = in.depth[at], w.rest += w.z * p[4 * plane];
  return w;
}

template <bool DEPTH>
MGS_FN void walk_past(Walk& w, float raw, float dx, float dy, const float4& color,
                      Sums<float>& sums) {
  float alpha = min_of(raw, ALPHA_MAX), share = alpha * w.t;
  sums.r += share * w.r, sums.g += share * w.g, sums.b += share * w.b;
  float value = w.r * color.x + w.g * color.y + w.b * color.z;
  if (DEPTH) {
    sums.z += share * w.z;
    value += w.z * color.w;
  }
  w.rest -= share * value;
  w.t -= share;
  // dL/dalpha = T value - rest / (1 - alpha), times alpha
  float g_q = share * value - alpha * w.rest * reciprocal(1.0f - alpha);
  add_moments(sums, raw > ALPHA_MAX ? 0.0f : g_q, dx, dy);
}

// Each warp takes its 8 x 8 pixels, two per thread, through the entries of the batch. It writes its
// sums to `parts` and a bit per entry that it used to `reached`. Returns false once all pixels are
// finished.
template <bool DEPTH>
MGS_FN bool walk_batch(const Batch<WALK_BATCH>& batch, int count, const ThreadPixel& here,
                       Walk* walks, float (*parts)[SUMS], unsigned* reached) {
  for (int base = 0; base < count; base += WARP) {
    unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 8), used = 0;
    if (!__any_sync(ALL, walks[0].t >= TRANSMITTANCE_MIN || walks[1].t >= TRANSMITTANCE_MIN))
      left = 0;
    for (; left; left &= left - 1) {
      int k = base + __ffs(left) - 1;
      float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
      float raw[2], dx = walks[0].x - place.x;
      UNROLL
      for (int j = 0; j < 2; j++) {
        raw[j] = alpha_at(place, falloff, dx, walks[j].y - place.y);
        if (!(walks[j].t >= TRANSMITTANCE_MIN)) raw[j] = 0;
      }
      if (!__any_sync(ALL, raw[0] > 0 || raw[1] > 0)) continue;
      Sums<float> sums = {};
      UNROLL
      for (int j = 0; j < 2; j++)
        walk_past<DEPTH>(walks[j], raw[j], dx, walks[j].y - place.y, color, sums);
      Total total = add_lanes(sums);
      if (total.component >= 0) parts[k][total.component] = total.value;
      used |= left & (0 - left);
    }
    if (lane_of_thread() == 0) reached[base / WARP] = used;
  }
  return walks[0].t >= TRANSMITTANCE_MIN || walks[1].t >= TRANSMITTANCE_MIN;
}

// Writes each entry's sums over the tile to its slot, added in the order of the warps, and marks
// the slot as reached. Slots of entries behind the early stop are not written.
template <bool DEPTH>
MGS_FN void sorted_backward(const View& view, const Splat* splats, const Lists& lists,
                            const float* sums, const OutputGradients& in, float* slot_sums,
                            unsigned char* slot_reached) {
  constexpr int WARPS = WALK_THREADS / WARP;
  __shared__ Batch<WALK_BATCH> batch;
  __shared__ float parts[WARPS][WALK_BATCH][SUMS];
  __shared__ unsigned reached[WARPS][WALK_BATCH / WARP];
  int warp = warp_of_thread();
  ThreadPixel upper = thread_pixel(view, warp % 2 * 8, warp / 2 * 8);
  ThreadPixel lower = thread_pixel(view, warp % 2 * 8, warp / 2 * 8 + 4);
  Walk walks[2] = {start_walk<DEPTH>(view, upper, sums, in),
                   start_walk<DEPTH>(view, lower, sums, in)};
  bool open = true;
  Visits visits = visits_of(lists, blockIdx.x);
  for (int e = visits.first; e < visits.end; e += WALK_BATCH) {
    if (!__syncthreads_or(open)) break;
    int count = stage_from(view, batch, visits, e, splats, upper.level, false);
    __syncthreads();
    open = walk_batch<DEPTH>(batch, count, upper, walks, parts[warp], reached[warp]);
    __syncthreads();
    for (int item = threadIdx.x; item < count * SUMS; item += WALK_THREADS) {
      int k = item / SUMS, component = item % SUMS;
      float total = 0;
      bool any = false;
      for (int w = 0; w < WARPS; w++)
        if (reached[w][k / WARP] >> k % WARP & 1) total += parts[w][k][component], any = true;
      if (!any) continue;
      int64 slot = lists.slots[e + k];
      slot_sums[slot * SUMS + component] = total;
      if (component == 0) slot_reached[slot] = 1;
    }
  }
}

}  // namespace
