// Sort-free blending in CUDA (render/sortfree.py, paper Eq. 2): sums of c a w, a w and the product
// T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in pairs.h. Forward a
// block per tile, backward a warp per Gaussian. With levels (render/levels.py), the tiles are those of
// all targets; each target is then enlarged and added to the next finer one.
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
      stage(view, batch, threadIdx.x, s, false);
      batch.falloff[threadIdx.x].z = limit_of(s);
      if (s.log2_opacity < -1) batch.box[threadIdx.x] = make_short4(0, 0, 0, 0);
    }
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k];
        float raw = alpha_at(place, falloff, x - place.x, y - place.y);
        float alpha = finish_alpha(raw, batch.edge[k]);
        if (alpha >= SURFACE_ALPHA) limit = min_of(limit, falloff.z);
      }
    }
  }
  if (here.inside) limits[here.at] = limit;
}

// `limits` come from the first pass of TWO_PASS; at a surface T is 0.
template <bool DEPTH, bool SURFACES>
MGS_FN void sortfree_forward(const View& view, const Splat* splats, const Lists& lists,
                             const Outputs& out, const float* limits) {
  __shared__ Batch<THREADS> batch;
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f;
  float limit = SURFACES && here.inside ? limits[here.at] : NO_SURFACE;
  Pixel p = {0, 0, 0, 0, 0, limit < NO_SURFACE ? 0.0f : 1.0f};
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += THREADS) {
    int count = end - e < THREADS ? (int)(end - e) : THREADS;
    __syncthreads();  // all threads have read the previous batch
    if ((int)threadIdx.x < count)
      stage(view, batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], true);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        if (SURFACES && color.w > limit) continue;  // w is 1, so color.w is the depth
        float raw = alpha_at(place, falloff, x - place.x, y - place.y);
        float alpha = finish_alpha(raw, batch.edge[k]);
        p.r += alpha * color.x, p.g += alpha * color.y, p.b += alpha * color.z;
        p.w += alpha * falloff.z;
        p.t -= p.t * alpha;
        if (DEPTH) p.z += alpha * color.w;
      }
    }
  }
  if (!here.inside) return;
  int64 at = here.at, plane = pixel_count(view);
  const float values[6] = {p.r, p.g, p.b, p.w, p.t, p.z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 6 : 5); k++) out.sums[k * plane + at] = values[k];
  if (level_count(view) == 1)
    sortfree_resolve(view, p, out.image + 3 * at, out.alpha + at, DEPTH ? out.depth + at : nullptr);
}

// Adds the next coarser target, enlarged, to one pixel of a target (render/levels.py, `enlarge`).
// Keeps T of the pixel's own Gaussians in the last plane. At level 0 writes the image.
template <bool DEPTH>
MGS_FN void add_enlarged(const View& view, int level, const Outputs& out) {
  constexpr int C = DEPTH ? 6 : 5;
  Grid fine = grid_of(view, level), coarse = grid_of(view, level + 1);
  int64 place = global_thread(), plane = pixel_count(view);
  if (place >= (int64)fine.width * fine.height) return;
  int begin = level == 0 ? 0 : 1;
  int x = (int)(place % fine.width) - begin, y = (int)(place / fine.width) - begin;
  int near_x = (x >> 1) + 1, other_x = near_x + 2 * (x & 1) - 1;
  int near_y = (y >> 1) + 1, other_y = near_y + 2 * (y & 1) - 1;
  const float* from = out.sums + coarse.first_pixel;
  const float* near_row = from + (int64)near_y * coarse.width;
  const float* other_row = from + (int64)other_y * coarse.width;
  float* to = out.sums + fine.first_pixel + place;
  float values[6] = {0, 0, 0, 0, 0, 0};
  UNROLL
  for (int k = 0; k < C; k++) {
    const float *p = near_row + k * plane, *q = other_row + k * plane;
    float enlarged = 0.75f * (0.75f * p[near_x] + 0.25f * q[near_x]) +
                     0.25f * (0.75f * p[other_x] + 0.25f * q[other_x]);
    float own = to[k * plane];
    if (k == 4) to[C * plane] = own;
    values[k] = k == 4 ? own * enlarged : own + enlarged;
    to[k * plane] = values[k];
  }
  if (level > 0) return;
  Pixel p = {values[0], values[1], values[2], values[5], values[3], values[4]};
  sortfree_resolve(view, p, out.image + 3 * place, out.alpha + place,
                   DEPTH ? out.depth + place : nullptr);
}

// dL/d of every pixel's sums in the image, as (r, g, b, w) and (t, z). t is T dL/dT, with levels
// dL/dT until finish_gradients.
template <bool DEPTH>
MGS_FN void sortfree_pixels(const View& view, const float* sums, const OutputGradients& in,
                            float4* colors, float2* others) {
  int64 at = global_thread(), plane = pixel_count(view);
  if (at >= (int64)view.width * view.height) return;
  const float* p = sums + at;
  Pixel pixel = {p[0],         p[plane],    p[2 * plane], DEPTH ? p[5 * plane] : 0.0f,
                 p[3 * plane], p[4 * plane]};
  Pixel d = sortfree_pixel_adjoint(view, pixel, in.image + 3 * at, in.alpha[at],
                                   DEPTH ? in.depth[at] : 0.0f);
  colors[at] = make_float4(d.r, d.g, d.b, d.w);
  others[at] = make_float2(level_count(view) == 1 ? d.t * pixel.t : d.t, d.z);
}

// dL/d of one pixel of the next coarser target: the transpose of add_enlarged. `own` is the plane of
// T of each level's own Gaussians.
MGS_FN void reduce_gradients(const View& view, int level, const float* own, float4* colors,
                             float2* others) {
  Grid fine = grid_of(view, level), coarse = grid_of(view, level + 1);
  int64 place = global_thread();
  if (place >= (int64)coarse.width * coarse.height) return;
  // the four finer rows or columns begin at twice the pixel's number minus this
  int before = level == 0 ? 3 : 2;
  int from_x = 2 * (int)(place % coarse.width) - before;
  int from_y = 2 * (int)(place / coarse.width) - before;
  float4 color = make_float4(0, 0, 0, 0);
  float2 other = make_float2(0, 0);
  for (int i = 0; i < 4; i++) {
    int y = from_y + i;
    if (y < 0 || y >= fine.height) continue;
    for (int j = 0; j < 4; j++) {
      int x = from_x + j;
      if (x < 0 || x >= fine.width) continue;
      float share = (i % 3 == 0 ? 0.25f : 0.75f) * (j % 3 == 0 ? 0.25f : 0.75f);
      int64 at = fine.first_pixel + (int64)y * fine.width + x;
      float4 c = colors[at];
      float2 o = others[at];
      color.x += share * c.x, color.y += share * c.y;
      color.z += share * c.z, color.w += share * c.w;
      other.x += share * o.x * own[at], other.y += share * o.y;
    }
  }
  colors[coarse.first_pixel + place] = color;
  others[coarse.first_pixel + place] = other;
}

// dL/dT becomes T dL/dT in the pixels of all levels.
MGS_FN void finish_gradients(const View& view, const float* sums, float2* others) {
  int64 at = global_thread(), plane = pixel_count(view);
  if (at < plane) others[at].x *= sums[4 * plane + at];
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
  Grid grid = grid_of(view, s.level);
  float edge = edge_of(view, s);
  int width = s.x1 - s.x0, x = s.x0 + first % width, y = s.y0 + first / width;
  int step_x = step % width, step_y = step / width;
  while (y < s.y1) {
    float dx = x + 0.5f - s.x, dy = y + 0.5f - s.y;
    float raw = pair_alpha(dx, row_of(s, dy));
    int64 at = grid.first_pixel + (int64)y * grid.width + x;
    if (raw > 0 && (!SURFACES || s.z <= pixels.limits[at])) {
      float4 c = pixels.colors[at];
      float2 o = pixels.others[at];
      sortfree_pair_adjoint<DEPTH>(sums, s, raw, edge, dx, dy, c.x, c.y, c.z, o.y, c.w, o.x);
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
