// Sort-free blending in CUDA (render/sortfree.py, paper Eq. 2): sums of c a w, a w and the product
// T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in pairs.h. Forward a
// block per tile, backward a warp per Gaussian. With levels (render/levels.py), the tiles are those of
// all targets; each target is then enlarged and added to the next finer one.
#pragma once
#include "cuda_common.h"
#include "depth_pass.h"

namespace {

// The picture of the depth pass: planes of the sums of a, a ln z and a (ln z)^2. `splats` and the
// lists are those of depth_view.
MGS_FN void depth_moments(const View& pass, const Splat* splats, const Lists& lists,
                          float* moments) {
  __shared__ Batch<THREADS> batch;
  ThreadPixel here = thread_pixel(pass);
  float x = here.x + 0.5f, y = here.y + 0.5f, total = 0, first = 0, second = 0;
  Visits visits = visits_of(lists, blockIdx.x);
  for (int e = visits.first; e < visits.end; e += THREADS) {
    __syncthreads();  // all threads have read the previous batch
    int count = stage_from(pass, batch, visits, e, splats, here.level, false);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k];
        float raw = alpha_at(place, batch.falloff[k], x - place.x, y - place.y);
        float alpha = finish_alpha(raw, batch.edge[k]), log_z = batch.color[k].x;
        total += alpha, first += alpha * log_z, second += alpha * (log_z * log_z);
      }
    }
  }
  if (!here.inside) return;
  int64 plane = (int64)pass.width * pass.height;
  moments[here.at] = total, moments[plane + here.at] = first, moments[2 * plane + here.at] = second;
}

// With PASS, weights by the fog of `moments`; the last planes of the sums get it.
template <bool DEPTH, bool PASS>
MGS_FN void sortfree_forward(const View& view, const Splat* splats, const Lists& lists,
                             const Outputs& out, const float* moments) {
  __shared__ Batch<THREADS> batch;
  __shared__ float log_z[PASS ? THREADS : 1];
  ThreadPixel here = thread_pixel(view);
  float x = here.x + 0.5f, y = here.y + 0.5f;
  Pixel<float> p = {0, 0, 0, 0, 0, 1};
  Fog<float> fog = {};
  if (PASS && here.inside)
    fog = fog_of_pixel(grid_of(view, PASS_LEVEL), moments, here.level, here.x, here.y);
  Visits visits = visits_of(lists, blockIdx.x);
  for (int e = visits.first; e < visits.end; e += THREADS) {
    __syncthreads();  // all threads have read the previous batch
    int count = stage_from(view, batch, visits, e, splats, here.level, true);
    if (PASS && (int)threadIdx.x < count)
      log_z[threadIdx.x] = log_depth(splats[gaussian_at(visits, e + threadIdx.x)]);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, here.patch_x, here.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        float raw = alpha_at(place, falloff, x - place.x, y - place.y);
        float alpha = finish_alpha(raw, batch.edge[k]);
        p.t -= p.t * alpha;
        if (PASS) alpha *= visibility(fog, log_z[k]);
        p.r += alpha * color.x, p.g += alpha * color.y, p.b += alpha * color.z;
        p.w += alpha * falloff.z;
        if (DEPTH) p.z += alpha * color.w;
      }
    }
  }
  if (!here.inside) return;
  int64 at = here.at, plane = pixel_count(view);
  const float values[6] = {p.r, p.g, p.b, p.w, p.t, p.z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 6 : 5); k++) out.sums[k * plane + at] = values[k];
  int after = (DEPTH ? 6 : 5) + (level_count(view) > 1);
  if (PASS)
    out.sums[after * plane + at] = fog.density, out.sums[(after + 1) * plane + at] = fog.first,
                             out.sums[(after + 2) * plane + at] = fog.slope;
  if (level_count(view) > 1)
    out.sums[(after - 1) * plane + at] = p.t;
  else
    sortfree_resolve(view, p, out.image + 3 * at, out.alpha + at, DEPTH ? out.depth + at : nullptr);
}

// Adds each target, enlarged, to the next finer one (render/levels.py, `enlarge`), for one tile of the
// image, and writes its image. Coarser targets only get their T, which the backward pass needs;
// several blocks write the same one. One thread per pixel.
template <bool DEPTH>
MGS_FN void add_levels(const View& view, const Outputs& out) {
  constexpr int C = DEPTH ? 6 : 5;
  constexpr int SIDES[LEVELS] = {TILE, 10, 6, 4};  // of the region of each target that counts
  __shared__ float staged[2][100][C];              // the coarser region, and the present one
  Grid image = grid_of(view, 0);
  int left = blockIdx.x % image.across * TILE, top = blockIdx.x / image.across * TILE;
  int64 plane = pixel_count(view);
  for (int level = LEVELS - 1; level >= 0; level--) {
    Grid grid = grid_of(view, level);
    int side = SIDES[level], me = threadIdx.x;
    int x = (left >> level) + me % side, y = (top >> level) + me / side;
    __syncthreads();  // the coarser region is complete, and what lay in the present one's place read
    if (me >= side * side || x >= grid.width || y >= grid.height) continue;
    int64 place = (int64)y * grid.width + x;
    float* sums = out.sums + grid.first_pixel + place;
    float values[6];
    UNROLL
    for (int k = 0; k < C; k++) values[k] = sums[(k == 4 ? C : k) * plane];
    if (level < LEVELS - 1) {
      int begin = level == 0 ? 0 : 1;
      int near_x = ((x - begin) >> 1) + 1 - (left >> (level + 1));
      int near_y = ((y - begin) >> 1) + 1 - (top >> (level + 1));
      int other_x = near_x + 2 * ((x - begin) & 1) - 1;
      int other_y = near_y + 2 * ((y - begin) & 1) - 1;
      const float(*near_row)[C] = staged[(level + 1) % 2] + near_y * SIDES[level + 1];
      const float(*other_row)[C] = staged[(level + 1) % 2] + other_y * SIDES[level + 1];
      UNROLL
      for (int k = 0; k < C; k++) {
        float enlarged = 0.75f * (0.75f * near_row[near_x][k] + 0.25f * other_row[near_x][k]) +
                         0.25f * (0.75f * near_row[other_x][k] + 0.25f * other_row[other_x][k]);
        values[k] = k == 4 ? values[k] * enlarged : values[k] + enlarged;
      }
      sums[4 * plane] = values[4];
    }
    if (level > 0) {
      UNROLL
      for (int k = 0; k < C; k++) staged[level % 2][me][k] = values[k];
      continue;
    }
    UNROLL
    for (int k = 0; k < C; k++) sums[k * plane] = values[k];
    Pixel<float> p = {values[0], values[1], values[2], DEPTH ? values[5] : 0.0f,
                      values[3], values[4]};
    sortfree_resolve(view, p, out.image + 3 * place, out.alpha + place,
                     DEPTH ? out.depth + place : nullptr);
  }
}

// dL/d of all pixels' sums.
struct PixelGradients {
  float4* colors;       // r, g, b, w
  float2* others;       // T dL/dT, z
  float* carried;       // with levels: dL/dT times the T of the image's own Gaussians
  const float* fog;     // planes, only for DEPTH_PASS, for the gathering
};

template <bool DEPTH>
MGS_FN void sortfree_pixels(const View& view, const float* sums, const OutputGradients& in,
                            const PixelGradients& out) {
  int64 at = global_thread(), plane = pixel_count(view);
  if (at >= (int64)view.width * view.height) return;
  const float* p = sums + at;
  Pixel<float> pixel = {p[0],         p[plane],    p[2 * plane], DEPTH ? p[5 * plane] : 0.0f,
                        p[3 * plane], p[4 * plane]};
  float image[3] = {0, 0, 0};
  for (int k = 0; k < 3; k++)
    if (in.image) image[k] = in.image[3 * at + k];
  Pixel<float> d =
      sortfree_pixel_adjoint(view, pixel, image, in.alpha ? in.alpha[at] : 0.0f,
                             DEPTH && in.depth ? in.depth[at] : 0.0f);
  out.colors[at] = make_float4(d.r, d.g, d.b, d.w);
  out.others[at] = make_float2(d.t * pixel.t, d.z);
  if (level_count(view) > 1) out.carried[at] = d.t * p[(DEPTH ? 6 : 5) * plane];
}

// dL/d of the sums of a pixel with levels. `carried` is dL/dT times the T of the level's own
// Gaussians, which is dL/d of the enlarged T of coarser levels.
struct LevelPixel {
  float4 color;
  float carried, z;
};

// dL/d of the next coarser target, enlarged, at its pixel (x, y): the transpose of `enlarge`.
// read(x, y) returns pixels of the finer target, whose level is `level`.
template <class F>
MGS_FN LevelPixel reduce_at(const Grid& fine, int level, int x, int y, F read) {
  LevelPixel sum = {make_float4(0, 0, 0, 0), 0, 0};
  // the four finer rows or columns begin at twice the pixel's number minus this
  int before = level == 0 ? 3 : 2;
  for (int i = 0; i < 4; i++) {
    int from_y = 2 * y - before + i;
    if (from_y < 0 || from_y >= fine.height) continue;
    for (int j = 0; j < 4; j++) {
      int from_x = 2 * x - before + j;
      if (from_x < 0 || from_x >= fine.width) continue;
      float share = (i % 3 == 0 ? 0.25f : 0.75f) * (j % 3 == 0 ? 0.25f : 0.75f);
      LevelPixel p = read(from_x, from_y);
      sum.color.x += share * p.color.x, sum.color.y += share * p.color.y;
      sum.color.z += share * p.color.z, sum.color.w += share * p.color.w;
      sum.carried += share * p.carried, sum.z += share * p.z;
    }
  }
  return sum;
}

constexpr int COARSE = 4;  // side of a block's pixels in the coarsest target

// dL/d of the sums in all coarser targets, for the pixels that COARSE x COARSE of the coarsest target
// depend on; several blocks write the same ones. One thread per pixel.
template <bool DEPTH>
MGS_FN void reduce_levels(const View& view, const float* sums, const PixelGradients& out) {
  constexpr int MIDDLE = 2 * COARSE + 2, FINE = 2 * MIDDLE + 2;
  __shared__ LevelPixel fine[FINE * FINE], middle[MIDDLE * MIDDLE];
  Grid grids[LEVELS];
  UNROLL
  for (int level = 0; level < LEVELS; level++) grids[level] = grid_of(view, level);
  int across = (grids[3].width + COARSE - 1) / COARSE;
  int x3 = blockIdx.x % across * COARSE, y3 = blockIdx.x / across * COARSE;
  int x2 = 2 * x3 - 2, y2 = 2 * y3 - 2, x1 = 2 * x2 - 2, y1 = 2 * y2 - 2;
  int64 plane = pixel_count(view);
  // writes a pixel, and returns it as the next level reads it
  auto finish = [&](const Grid& grid, int x, int y, LevelPixel p) {
    int64 at = grid.first_pixel + (int64)y * grid.width + x;
    out.colors[at] = p.color;
    out.others[at] = make_float2(p.carried * sums[4 * plane + at], p.z);
    p.carried *= sums[(DEPTH ? 6 : 5) * plane + at];
    return p;
  };
  auto inside = [](const Grid& grid, int x, int y) {
    return x >= 0 && y >= 0 && x < grid.width && y < grid.height;
  };
  for (int k = threadIdx.x; k < FINE * FINE; k += THREADS) {
    int x = x1 + k % FINE, y = y1 + k / FINE;
    if (!inside(grids[1], x, y)) continue;
    LevelPixel p = reduce_at(grids[0], 0, x, y, [&](int x, int y) {
      int64 at = (int64)y * grids[0].width + x;
      return LevelPixel{out.colors[at], out.carried[at], DEPTH ? out.others[at].y : 0.0f};
    });
    fine[k] = finish(grids[1], x, y, p);
  }
  __syncthreads();
  for (int k = threadIdx.x; k < MIDDLE * MIDDLE; k += THREADS) {
    int x = x2 + k % MIDDLE, y = y2 + k / MIDDLE;
    if (!inside(grids[2], x, y)) continue;
    LevelPixel p = reduce_at(grids[1], 1, x, y,
                             [&](int x, int y) { return fine[(y - y1) * FINE + x - x1]; });
    middle[k] = finish(grids[2], x, y, p);
  }
  __syncthreads();
  int x = x3 + threadIdx.x % COARSE, y = y3 + threadIdx.x / COARSE;
  if (threadIdx.x >= COARSE * COARSE || !inside(grids[3], x, y)) return;
  LevelPixel p = reduce_at(grids[2], 2, x, y,
                           [&](int x, int y) { return middle[(y - y2) * MIDDLE + x - x2]; });
  finish(grids[3], x, y, p);
}

constexpr int GATHERED = 128;  // entries that a block looks at

// Sums over every `step`-th pixel of a Gaussian's box, starting with pixel `first`.
template <bool DEPTH, bool PASS>
MGS_FN Sums<float> gather_box(const View& view, const Splat& s, const PixelGradients& pixels,
                              int first, int step) {
  Sums<float> sums = {};
  Grid grid = grid_of(view, s.level);
  float edge = edge_of(view, s), log_z = PASS ? log_depth(s) : 0.0f;
  int64 plane = PASS ? pixel_count(view) : 0;
  int width = s.x1 - s.x0, x = s.x0 + first % width, y = s.y0 + first / width;
  int step_x = step % width, step_y = step / width;
  while (y < s.y1) {
    float dx = x + 0.5f - s.x, dy = y + 0.5f - s.y;
    float raw = pair_alpha(dx, row_of(s, dy));
    int64 at = grid.first_pixel + (int64)y * grid.width + x;
    if (raw > 0) {
      float4 c = pixels.colors[at];
      float2 o = pixels.others[at];
      if (PASS) {
        const float* fog = pixels.fog + at;
        float share = visibility(Fog<float>{fog[0], fog[plane], fog[2 * plane]}, log_z);
        c.x *= share, c.y *= share, c.z *= share, c.w *= share, o.y *= share;
      }
      float g_q =
          sortfree_pair_adjoint<DEPTH>(sums, s, raw, edge, c.x, c.y, c.z, o.y, c.w, o.x);
      add_moments(sums, g_q, dx, dy);
    }
    x += step_x, y += step_y;
    if (x >= s.x1) x -= width, y++;
  }
  return sums;
}

// Adds the pixels of the Gaussians whose first entries are among those of the block: neighbours in
// the image, which read the same pixels from the cache. One warp per Gaussian; then the whole block
// takes those with a large box.
template <bool DEPTH, bool PASS>
MGS_FN void sortfree_gather(const View& view, const Splat* splats, const Lists& lists,
                            const PixelGradients& pixels, float* totals) {
  __shared__ float parts[WARPS][SUMS];
  __shared__ int ids[GATHERED];  // of Gaussians, with FIRST if the box is large
  int warp = warp_of_thread(), lane = lane_of_thread();
  Visits all = *lists.length > lists.room ? Visits{0, lists.n, nullptr}
                                          : Visits{0, (int)*lists.length, lists.ids};
  for (int64 start = (int64)blockIdx.x * GATHERED; start < all.end;
       start += (int64)gridDim.x * GATHERED) {
    int64 e = start + threadIdx.x;
    bool first = (int)threadIdx.x < GATHERED && e < all.end && (!all.ids || all.ids[e] & FIRST);
    int id = first ? gaussian_at(all, (int)e) : 0;
    if (first) {
      const Splat& s = splats[id];
      first = visible(s);
      if ((int64)(s.x1 - s.x0) * (s.y1 - s.y0) > LARGE) id |= FIRST;
    }
    BlockSum found = sum_before(first);  // all threads have read the ids of the previous entries
    if (first) ids[found.before] = id;
    __syncthreads();
    for (int k = warp; k < found.total; k += WARPS) {
      int64 i = ids[k];
      if (i < 0) continue;
      Splat s = splats[i];
      Total total = add_lanes(gather_box<DEPTH, PASS>(view, s, pixels, lane, WARP));
      if (total.component >= 0) totals[i * SUMS + total.component] = total.value;
    }
    for (int k = 0; k < found.total; k++) {
      if (ids[k] >= 0) continue;
      int64 i = ids[k] & ~FIRST;
      Splat s = splats[i];
      Total total = add_lanes(gather_box<DEPTH, PASS>(view, s, pixels, threadIdx.x, THREADS));
      if (total.component >= 0) parts[warp][total.component] = total.value;
      __syncthreads();
      if (threadIdx.x < SUMS) {
        float sum = 0;
        for (int w = 0; w < WARPS; w++) sum += parts[w][threadIdx.x];
        totals[i * SUMS + threadIdx.x] = sum;
      }
      __syncthreads();
    }
  }
}

}  // namespace
