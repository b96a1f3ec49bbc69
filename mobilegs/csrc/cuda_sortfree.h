// Sort-free blending in CUDA (render/sortfree.py, paper Eq. 2): sums of c a w, a w and the product
// T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in pairs.h. Forward a
// block per tile, backward a warp per Gaussian.
#pragma once
#include "cuda_common.h"

namespace {

// First pass of TWO_PASS: the depth up to which Gaussians count at each pixel.
MGS_FN void find_surfaces(const View& view, const Splat* splats, const Lists& lists,
                          float* limits) {
  __shared__ Batch<THREADS> batch;
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f, limit = NO_SURFACE;
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += THREADS) {
    int count = end - e < THREADS ? (int)(end - e) : THREADS;
    __syncthreads();  // all threads have read the previous batch
    if ((int)threadIdx.x < count) {
      const Splat& s = splats[lists.ids[e + threadIdx.x]];
      stage(batch, threadIdx.x, s, false);
      batch.falloff[threadIdx.x].z = limit_of(s);
      if (s.opacity < SURFACE_ALPHA) batch.box[threadIdx.x] = make_short4(0, 0, 0, 0);
    }
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k];
        float alpha = alpha_at(place, falloff, x - place.x, y - place.y);
        if (alpha >= SURFACE_ALPHA) limit = min_of(limit, falloff.z);
      }
    }
  }
  if (here.inside) limits[index_of(view, here)] = limit;
}

// `limits` come from the first pass of TWO_PASS; at a surface T is 0.
template <bool DEPTH, bool SURFACES>
MGS_FN void sortfree_forward(const View& view, const Splat* splats, const Lists& lists,
                             const Outputs& out, const float* limits) {
  __shared__ Batch<THREADS> batch;
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f;
  float limit = SURFACES && here.inside ? limits[index_of(view, here)] : NO_SURFACE;
  Pixel p = {0, 0, 0, 0, 0, limit < NO_SURFACE ? 0.0f : 1.0f};
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += THREADS) {
    int count = end - e < THREADS ? (int)(end - e) : THREADS;
    __syncthreads();  // all threads have read the previous batch
    if ((int)threadIdx.x < count)
      stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], true);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        if (SURFACES && color.w > limit) continue;  // w is 1, so color.w is the depth
        float alpha = min_of(alpha_at(place, falloff, x - place.x, y - place.y), ALPHA_MAX);
        p.r += alpha * color.x, p.g += alpha * color.y, p.b += alpha * color.z;
        p.w += alpha * falloff.z;
        p.t -= p.t * alpha;
        if (DEPTH) p.z += alpha * color.w;
      }
    }
  }
  if (!here.inside) return;
  int64 at = index_of(view, here), plane = (int64)view.width * view.height;
  const float values[6] = {p.r, p.g, p.b, p.w, p.t, p.z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 6 : 5); k++) out.sums[k * plane + at] = values[k];
  sortfree_resolve(view, p, out.image + 3 * at, out.alpha + at, DEPTH ? out.depth + at : nullptr);
}

// dL/d of every pixel's sums, as (r, g, b, w) and (t, z).
template <bool DEPTH>
MGS_FN void sortfree_pixels(const View& view, const float* sums, const OutputGradients& in,
                            float4* colors, float2* others) {
  int64 at = global_thread(), plane = (int64)view.width * view.height;
  if (at >= plane) return;
  const float* p = sums + at;
  Pixel pixel = {p[0],         p[plane],    p[2 * plane], DEPTH ? p[5 * plane] : 0.0f,
                 p[3 * plane], p[4 * plane]};
  Pixel d = sortfree_pixel_adjoint(view, pixel, in.image + 3 * at, in.alpha[at],
                                   DEPTH ? in.depth[at] : 0.0f);
  colors[at] = make_float4(d.r, d.g, d.b, d.w);
  others[at] = make_float2(d.t, d.z);
}

// dL/d of all pixels' sums, which Gaussians gather; `limits` only for TWO_PASS.
struct PixelGradients {
  const float4* colors;
  const float2* others;
  const float* limits;
};

// Sums over every `step`-th pixel of a Gaussian's box, starting with pixel `first`.
template <bool DEPTH, bool SURFACES>
MGS_FN Sums<float> gather_box(const View& view, const Splat& s, const PixelGradients& pixels,
                              int first, int step) {
  Sums<float> sums = {};
  int width = s.x1 - s.x0, x = s.x0 + first % width, y = s.y0 + first / width;
  int step_x = step % width, step_y = step / width;
  while (y < s.y1) {
    float dx = x + 0.5f - s.x, dy = y + 0.5f - s.y;
    float raw = pair_alpha(dx, row_of(s, dy));
    int64 at = (int64)y * view.width + x;
    if (raw > 0 && (!SURFACES || s.z <= pixels.limits[at])) {
      float4 c = pixels.colors[at];
      float2 o = pixels.others[at];
      sortfree_pair_adjoint<DEPTH>(sums, s, raw, dx, dy, c.x, c.y, c.z, o.y, c.w, o.x);
    }
    x += step_x, y += step_y;
    if (x >= s.x1) x -= width, y++;
  }
  return sums;
}

// One warp per Gaussian, in `order` (by tile, for the caches); then the whole block takes those
// with a large box.
template <bool DEPTH, bool SURFACES>
MGS_FN void sortfree_gather(const View& view, int n, const Splat* splats, const int64* order,
                            const PixelGradients& pixels, float* totals) {
  constexpr int WARPS = THREADS / WARP;
  __shared__ float parts[WARPS][SUMS];
  __shared__ int large[WARPS];  // the Gaussian, or -1
  int warp = warp_of_thread(), lane = lane_of_thread();
  int64 k = (int64)blockIdx.x * WARPS + warp;
  int64 i = k < n ? order[k] : -1;
  bool shown = i >= 0 && visible(splats[i]);
  if (lane == 0) large[warp] = -1;
  if (shown) {
    Splat s = splats[i];
    if ((int64)(s.x1 - s.x0) * (s.y1 - s.y0) > LARGE) {
      if (lane == 0) large[warp] = (int)i;
    } else {
      Total total = add_lanes(gather_box<DEPTH, SURFACES>(view, s, pixels, lane, WARP));
      if (total.component >= 0) totals[i * SUMS + total.component] = total.value;
    }
  }
  __syncthreads();
  for (int turn = 0; turn < WARPS; turn++) {
    int64 id = large[turn];
    if (id < 0) continue;
    Splat s = splats[id];
    Total total = add_lanes(gather_box<DEPTH, SURFACES>(view, s, pixels, threadIdx.x, THREADS));
    if (total.component >= 0) parts[warp][total.component] = total.value;
    __syncthreads();
    if (threadIdx.x < SUMS) {
      float sum = 0;
      for (int w = 0; w < WARPS; w++) sum += parts[w][threadIdx.x];
      totals[id * SUMS + threadIdx.x] = sum;
    }
    __syncthreads();
  }
}

}  // namespace
