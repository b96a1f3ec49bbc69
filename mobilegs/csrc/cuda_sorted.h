// Sorted blending on the GPU: per tile both ways, front to back, until the light is used up.
#pragma once
#include "cuda_common.h"

namespace {

template <bool DEPTH>
MGS_FN void sorted_forward(const View& view, const Splat* splats, const Lists& lists,
                           const Picture& out) {
  __shared__ Batch<MANY> batch;
  Spot spot = spot_of(view);
  float x = spot.x + 0.5f, y = spot.y + 0.5f;
  float r = 0, g = 0, b = 0, z = 0, t = spot.inside ? 1.0f : 0.0f;
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += MANY) {
    int count = end - e < MANY ? (int)(end - e) : MANY;
    // also keeps the previous batch until everybody has read it
    if (!__syncthreads_or(t >= TRANSMITTANCE_MIN)) break;
    if ((int)threadIdx.x < count)
      stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], false);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      if (!__any_sync(ALL, t >= TRANSMITTANCE_MIN)) break;
      unsigned left = touching(batch, base, count, spot.patch_x, spot.patch_y, 8, 4);
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
  if (!spot.inside) return;
  int64 at = index_of(view, spot), plane = (int64)view.width * view.height;
  const float values[5] = {r, g, b, t, z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 5 : 4); k++) out.sums[k * plane + at] = values[k];
  UNROLL
  for (int k = 0; k < 3; k++) out.image[3 * at + k] = values[k] + t * view.background[k];
  out.alpha[at] = 1 - t;
  if (DEPTH) out.depth[at] = z;
}

// One pixel of the backward walk, which goes front to back like the forward one.
struct Walk {
  float x, y;        // pixel centre
  float r, g, b, z;  // dL/d of what the Gaussians' shares multiply
  float rest;        // what the Gaussians still to come, and the background, add to dL
  float t;           // light left; 0 outside the picture
};

template <bool DEPTH>
MGS_FN Walk start_walk(const View& view, const Spot& spot, const float* sums,
                       const PictureGradients& in) {
  Walk w = {spot.x + 0.5f, spot.y + 0.5f, 0, 0, 0, 0, 0, 0};
  if (!spot.inside) return w;
  int64 at = index_of(view, spot), plane = (int64)view.width * view.height;
  const float *p = sums + at, *g = in.image + 3 * at;
  float t = p[3 * plane];
  w.t = 1, w.r = g[0], w.g = g[1], w.b = g[2];
  w.rest = -in.alpha[at] * t + w.r * (p[0] + t * view.background[0]) +
           w.g * (p[plane] + t * view.background[1]) +
           w.b * (p[2 * plane] + t * view.background[2]);
  if (DEPTH) w.z = in.depth[at], w.rest += w.z * p[4 * plane];
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

// Each warp walks 8 x 8 pixels, two a thread, past the entries of the batch; adds its sums to its
// part of `parts` and tells in `reached` which entries it met. Returns whether light is left.
template <bool DEPTH>
MGS_FN bool walk_batch(const Batch<WALK_BATCH>& batch, int count, const Spot& spot, Walk* walks,
                       float (*parts)[SUMS], unsigned* reached) {
  for (int base = 0; base < count; base += WARP) {
    unsigned left = touching(batch, base, count, spot.patch_x, spot.patch_y, 8, 8), met = 0;
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
      if (total.mine >= 0) parts[k][total.mine] = total.value;
      met |= left & (0 - left);
    }
    if (lane_of_thread() == 0) reached[base / WARP] = met;
  }
  return walks[0].t >= TRANSMITTANCE_MIN || walks[1].t >= TRANSMITTANCE_MIN;
}

// Writes each entry's sums over the tile to the entry's own slot, in the order of the warps, and
// marks the slot; entries that no light reached are left alone.
template <bool DEPTH>
MGS_FN void sorted_backward(const View& view, const Splat* splats, const Lists& lists,
                            const float* sums, const PictureGradients& in, float* slot_sums,
                            unsigned char* slot_reached) {
  constexpr int WARPS = WALKERS / WARP;
  __shared__ Batch<WALK_BATCH> batch;
  __shared__ float parts[WARPS][WALK_BATCH][SUMS];
  __shared__ unsigned reached[WARPS][WALK_BATCH / WARP];
  int warp = warp_of_thread();
  Spot upper = spot_of(view, warp % 2 * 8, warp / 2 * 8);
  Spot lower = spot_of(view, warp % 2 * 8, warp / 2 * 8 + 4);
  Walk walks[2] = {start_walk<DEPTH>(view, upper, sums, in),
                   start_walk<DEPTH>(view, lower, sums, in)};
  bool open = true;
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += WALK_BATCH) {
    int count = end - e < WALK_BATCH ? (int)(end - e) : WALK_BATCH;
    if (!__syncthreads_or(open)) break;
    if ((int)threadIdx.x < count)
      stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], false);
    __syncthreads();
    open = walk_batch<DEPTH>(batch, count, upper, walks, parts[warp], reached[warp]);
    __syncthreads();
    for (int item = threadIdx.x; item < count * SUMS; item += WALKERS) {
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
