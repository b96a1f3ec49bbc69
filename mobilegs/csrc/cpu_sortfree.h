// Order-independent blending on the CPU (render/sortfree.py, paper Eq. 2): sums of c a w, a w and
// the product T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in
// pairs.h. In the forward pass a thread owns a tile, in the backward pass a Gaussian. With levels
// (render/levels.py), the tiles are those of all targets; each target is then enlarged and added to
// the next finer one.
#pragma once
#include "cpu_common.h"

namespace {

// Channels of a pixel's sums: r, g, b, w, T, then z for the depth image, then for TWO_PASS the
// depth up to which Gaussians count.
template <bool DEPTH, bool SURFACES>
constexpr int channels = 5 + DEPTH + SURFACES;

// Planes of a row of `sums`: the channels; with levels, then T of this level's own Gaussians.
template <bool DEPTH, bool SURFACES>
int planes(const Tiles& tiles) {
  return channels<DEPTH, SURFACES> + (tiles.levels > 1);
}

// First pass of TWO_PASS over a tile: finds the nearest surface of every pixel, where T becomes 0.
template <int C>
void find_surfaces(const View& view, const Bins& bins, int tile, int left, int top,
                   const Splat* splats, float* sums) {
  for (int row = 0; row < TILE; row++)
    std::fill_n(sums + (row * C + C - 1) * TILE, TILE, NO_SURFACE);
  const vfloat lanes = iota(), zero = {};
  for (int64 e = bins.start[tile]; e < bins.start[tile + 1]; e++) {
    const Splat& s = splats[bins.ids[e]];
    if (s.log2_opacity < -1) continue;  // SURFACE_ALPHA is 1/2
    float edge = edge_of(view, s);
    int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
    vfloat own_limit = splat_value(zero, limit_of(s));
    for (int row = from; row < to; row++) {
      Row line = row_of(s, top + row + 0.5f - s.y);
      float *t = sums + (row * C + 4) * TILE, *limit = sums + (row * C + C - 1) * TILE;
      for (int l = 0; l < TILE; l += LANES) {
        vfloat raw = pair_alpha(lanes + (left + l + 0.5f - s.x), line);
        vint none = finish_alpha(raw, edge) < SURFACE_ALPHA;
        store(t + l, select(none, load(t + l), zero));
        store(limit + l, select(none, load(limit + l), min_of(load(limit + l), own_limit)));
      }
    }
  }
}

template <bool DEPTH, bool SURFACES>
void sortfree_tile(const View& view, const Bins& bins, int tile, int left, int top,
                   const Splat* splats, float* sums) {
  constexpr int C = channels<DEPTH, SURFACES>;
  for (int row = 0; row < TILE; row++)
    for (int c = 0; c < C; c++)
      std::fill_n(sums + (row * C + c) * TILE, TILE, c == 4 ? 1.0f : 0.0f);
  if (SURFACES) find_surfaces<C>(view, bins, tile, left, top, splats, sums);
  const vfloat lanes = iota();
  for (int64 e = bins.start[tile]; e < bins.start[tile + 1]; e++) {
    const Splat& s = splats[bins.ids[e]];
    int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
    float x = left + 0.5f - s.x, edge = edge_of(view, s);
    float r = s.weight * s.r, g = s.weight * s.g, b = s.weight * s.b, w = s.weight;
    float z = s.weight * s.z;
    for (int row = from; row < to; row++) {
      Row line = row_of(s, top + row + 0.5f - s.y);
      float* p = sums + row * C * TILE;
      for (int l = 0; l < TILE; l += LANES, p += LANES) {
        vfloat alpha = pair_alpha(lanes + (x + l), line);
        if (SURFACES) alpha = select(load(p + (C - 1) * TILE) < s.z, vfloat{}, alpha);
        alpha = finish_alpha(alpha, edge);
        store(p, load(p) + alpha * r);
        store(p + TILE, load(p + TILE) + alpha * g);
        store(p + 2 * TILE, load(p + 2 * TILE) + alpha * b);
        store(p + 3 * TILE, load(p + 3 * TILE) + alpha * w);
        vfloat t = load(p + 4 * TILE);
        store(p + 4 * TILE, t - t * alpha);
        if (DEPTH) store(p + 5 * TILE, load(p + 5 * TILE) + alpha * z);
      }
    }
  }
}

template <bool DEPTH>
MGS_FN Pixel pixel_at(const float* row, int width, int x) {
  const float* p = row + x;
  return {p[0], p[width], p[2 * width], DEPTH ? p[5 * width] : 0.0f, p[3 * width], p[4 * width]};
}

// Adds a row of the next coarser target to row y of a target, both enlarged sums (render/levels.py,
// `enlarge`). Keeps T of the row's own Gaussians in the last plane. `blend` has room for a row.
template <int C>
void add_enlarged(const Grid& fine, const Grid& coarse, bool to_image, int y, const float* from,
                  float* row, float* blend) {
  int at = to_image ? y : y - 1, nearest = (at >> 1) + 1, neighbour = nearest + 2 * (at & 1) - 1;
  int64 line = (int64)(C + 1) * coarse.width;
  const float *near_row = from + nearest * line, *other_row = from + neighbour * line;
  for (int c = 0; c < C; c++) {
    const float *p = near_row + c * coarse.width, *q = other_row + c * coarse.width;
    for (int x = 0; x < coarse.width; x++) blend[x] = 0.75f * p[x] + 0.25f * q[x];
    float* out = row + c * fine.width;
    if (c == 4) std::memcpy(row + C * fine.width, out, sizeof(float) * fine.width);
    auto put = [&](int x, float value) { out[x] = c == 4 ? out[x] * value : out[x] + value; };
    // the image's first pixel lies in the left half of a coarse one, a target's in the right half
    int first = to_image ? 0 : 1, pairs = (fine.width - first) / 2;
    if (!to_image) put(0, 0.75f * blend[0] + 0.25f * blend[1]);
    const float* b = blend;
    for (int m = 0; m < pairs; m++) {
      put(first + 2 * m, 0.25f * b[m] + 0.75f * b[m + 1]);
      put(first + 2 * m + 1, 0.75f * b[m + 1] + 0.25f * b[m + 2]);
    }
    if (first + 2 * pairs < fine.width)
      put(first + 2 * pairs, 0.25f * b[pairs] + 0.75f * b[pairs + 1]);
  }
}

template <bool DEPTH>
void resolve_row(const View& view, const float* row, int y, int left, int right, float* image,
                 float* alpha, float* depth) {
  for (int x = left; x < right; x++) {
    int64 at = (int64)y * view.width + x;
    sortfree_resolve(view, pixel_at<DEPTH>(row, view.width, x), image + 3 * at, alpha + at,
                     DEPTH ? depth + at : nullptr);
  }
}

template <bool DEPTH, bool SURFACES>
void sortfree_forward(const View& view, int n, const Splat* splats, float* sums, float* image,
                      float* alpha, float* depth) {
  constexpr int C = channels<DEPTH, SURFACES>;
  Bins bins = bin(view, n, splats, nullptr);
  Tiles tiles(view);
  int stored = planes<DEPTH, SURFACES>(tiles);
  auto draw = [&](int tile) {
    alignas(64) float tile_sums[TILE * C * TILE];
    const Grid& grid = tiles.grid_of_tile(tile);
    int place = tile - grid.first_tile;
    int left = place % grid.across * TILE, top = place / grid.across * TILE;
    sortfree_tile<DEPTH, SURFACES>(view, bins, tile, left, top, splats, tile_sums);
    int wide = std::min(TILE, grid.width - left);
    for (int row = 0; row < TILE && top + row < grid.height; row++) {
      float* line = sums + (grid.first_pixel + (int64)(top + row) * grid.width) * stored;
      for (int c = 0; c < C; c++)
        std::memcpy(line + c * grid.width + left, tile_sums + (row * C + c) * TILE,
                    sizeof(float) * wide);
      if (tiles.levels == 1)
        resolve_row<DEPTH>(view, line, top + row, left, left + wide, image, alpha, depth);
    }
  };
  parallel_for(tiles.count, 4, [&](int64 first, int64 end) {
    FlushDenormals flush;
    for (int64 tile = first; tile < end; tile++) draw(tile);
  });
  for (int l = tiles.levels - 2; l >= 0; l--) {
    const Grid &fine = tiles.grids[l], &coarse = tiles.grids[l + 1];
    const float* from = sums + coarse.first_pixel * stored;
    parallel_parts(fine.height, [&](int64 first, int64 end) {
      FlushDenormals flush;
      std::vector<float> blend(coarse.width);
      for (int64 y = first; y < end; y++) {
        float* row = sums + (fine.first_pixel + (int64)y * fine.width) * stored;
        add_enlarged<C>(fine, coarse, l == 0, y, from, row, blend.data());
        if (l == 0) resolve_row<DEPTH>(view, row, y, 0, view.width, image, alpha, depth);
      }
    });
  }
}

// dL/d of the sums of every pixel of all levels: channel planes within each row, padded so that a
// vector may start at any pixel. The plane of T holds T dL/dT, the last one of SURFACES the limits.
struct PixelGradients {
  Buffer<float> values;
  int64 first[LEVELS];
  int stride[LEVELS];
  float* row(int level, int y, int channels) const {
    return values.get() + first[level] + (int64)y * channels * stride[level];
  }
};

constexpr int PAD = 8;  // floats on each side of a row

// dL/d of a coarse row: the transpose of add_enlarged. `sum` has room for a row of the finer target
// and PAD floats on each side.
template <int C>
void reduce_gradients(const Grid& fine, const Grid& coarse, int level, int y,
                      const PixelGradients& grads, const float* sums, float* sum) {
  bool to_image = level == 0;
  int before = to_image ? 3 : 2;  // the four finer rows or columns begin at 2 y - before
  float* to = grads.row(level + 1, y, C);
  float* middle = sum + PAD;
  for (int c = 0; c < C; c++) {
    std::fill_n(sum, fine.width + 2 * PAD, 0.0f);
    for (int k = 0; k < 4; k++) {
      int from = 2 * y - before + k;
      if (from < 0 || from >= fine.height) continue;
      float share = k == 0 || k == 3 ? 0.25f : 0.75f;
      const float* g = grads.row(level, from, C) + c * grads.stride[level];
      const float* own = sums + ((int64)from * (C + 1) + C) * fine.width;  // T of its Gaussians
      if (c == 4)
        for (int x = 0; x < fine.width; x++) middle[x] += share * g[x] * own[x];
      else
        for (int x = 0; x < fine.width; x++) middle[x] += share * g[x];
    }
    float* out = to + c * grads.stride[level + 1];
    const float* p = middle - before;
    for (int x = 0; x < coarse.width; x++, p += 2)
      out[x] = 0.25f * (p[0] + p[3]) + 0.75f * (p[1] + p[2]);
    std::fill_n(out + coarse.width, grads.stride[level + 1] - coarse.width, 0.0f);
  }
}

template <bool DEPTH, bool SURFACES>
PixelGradients pixel_gradients(const View& view, const Tiles& tiles, const float* sums,
                               const float* g_image, const float* g_alpha, const float* g_depth) {
  constexpr int C = channels<DEPTH, SURFACES>;
  int stored = planes<DEPTH, SURFACES>(tiles);
  bool leveled = tiles.levels > 1;
  PixelGradients grads;
  int64 size = 0;
  for (int l = 0; l < tiles.levels; l++) {
    grads.first[l] = size, grads.stride[l] = tiles.grids[l].width + LANES;
    size += (int64)tiles.grids[l].height * C * grads.stride[l];
  }
  grads.values = Buffer<float>(size);
  auto start_row = [&](int64 y) {
    const float* p = sums + (int64)y * stored * view.width;
    float* out = grads.row(0, y, C);
    int stride = grads.stride[0];
    for (int x = 0; x < view.width; x++) {
      int64 at = (int64)y * view.width + x;
      Pixel pixel = pixel_at<DEPTH>(p, view.width, x);
      Pixel d = sortfree_pixel_adjoint(view, pixel, g_image + 3 * at, g_alpha[at],
                                       DEPTH ? g_depth[at] : 0.0f);
      out[x] = d.r, out[stride + x] = d.g, out[2 * stride + x] = d.b, out[3 * stride + x] = d.w;
      out[4 * stride + x] = leveled ? d.t : d.t * pixel.t;
      if (DEPTH) out[5 * stride + x] = d.z;
      if (SURFACES) out[(C - 1) * stride + x] = p[(C - 1) * view.width + x];
    }
    for (int c = 0; c < C; c++)
      std::fill_n(out + c * stride + view.width, stride - view.width, 0.0f);
  };
  parallel_parts(view.height, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 y = from; y < to; y++) start_row(y);
  });
  for (int l = 0; leveled && l < tiles.levels; l++) {
    const Grid& fine = tiles.grids[l];
    const float* own = sums + fine.first_pixel * stored;
    if (l + 1 < tiles.levels)
      parallel_parts(tiles.grids[l + 1].height, [&](int64 from, int64 to) {
        FlushDenormals flush;
        std::vector<float> sum(fine.width + 2 * PAD);
        for (int64 y = from; y < to; y++)
          reduce_gradients<C>(fine, tiles.grids[l + 1], l, y, grads, own, sum.data());
      });
    parallel_parts(fine.height, [&](int64 from, int64 to) {
      FlushDenormals flush;
      for (int64 y = from; y < to; y++) {
        float* g = grads.row(l, y, C) + 4 * grads.stride[l];
        const float* t = own + (y * stored + 4) * fine.width;
        for (int x = 0; x < fine.width; x++) g[x] *= t[x];
      }
    });
  }
  return grads;
}

// Indices of the Gaussians by the tile of their box's centre, invisible ones last: neighbours in
// the image then read the same pixels from the cache.
std::vector<int> screen_order(const View& view, int n, const Splat* splats) {
  Tiles tiles(view);
  std::vector<int> place(tiles.count + 2, 0), order(n);
  auto tile_of = [&](const Splat& s) {
    return visible(s) ? center_tile(s, tiles.grids[s.level]) : tiles.count;
  };
  for (int i = 0; i < n; i++) place[tile_of(splats[i]) + 1]++;
  for (int t = 0; t <= tiles.count; t++) place[t + 1] += place[t];
  for (int i = 0; i < n; i++) order[place[tile_of(splats[i])]++] = i;
  return order;
}

template <bool DEPTH, bool SURFACES>
MGS_FN Sums<float> sortfree_gather(const View& view, const Splat& s,
                                   const PixelGradients& grads) {
  constexpr int C = channels<DEPTH, SURFACES>;
  const vfloat lanes = iota();
  Sums<vfloat> sums = {};
  float inverse_a = 1 / s.A, edge = edge_of(view, s);
  int stride = grads.stride[s.level];
  for (int y = s.y0; y < s.y1; y++) {
    float dy = y + 0.5f - s.y;
    float inside = s.reach * s.A - s.det * dy * dy;  // of the ellipse's quadratic in dx
    if (inside < 0) continue;
    float root = sqrtf(inside) * inverse_a, middle = s.x - s.B * inverse_a * dy;
    int from = std::max((int)s.x0, (int)(middle - root - 0.51f));
    int to = std::min((int)s.x1, (int)(middle + root - 0.49f) + 2);
    Row line = row_of(s, dy);
    const float* g = grads.row(s.level, y, C);
    for (int x = from; x < to; x += LANES) {
      vfloat dx = lanes + (x + 0.5f - s.x);
      const float* p = g + x;
      vfloat alpha = pair_alpha(dx, line);
      if (SURFACES) alpha = select(load(p + (C - 1) * stride) < s.z, vfloat{}, alpha);
      vfloat g_z = DEPTH ? load(p + 5 * stride) : vfloat{};
      sortfree_pair_adjoint<DEPTH>(sums, s, alpha, edge, dx, dy, load(p), load(p + stride),
                                   load(p + 2 * stride), g_z, load(p + 3 * stride),
                                   load(p + 4 * stride));
    }
  }
  return reduce(sums);
}

template <bool DEPTH, bool SURFACES>
void sortfree_backward(const View& view, int n, const Inputs& in, const Splat* splats,
                       const float* sums, const float* g_image, const float* g_alpha,
                       const float* g_depth, const Gradients& out) {
  Tiles tiles(view);
  PixelGradients grads =
      pixel_gradients<DEPTH, SURFACES>(view, tiles, sums, g_image, g_alpha, g_depth);
  std::vector<int> order = screen_order(view, n, splats);
  Buffer<Sums<float>> totals(n);
  parallel_for(n, 256, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 k = from; k < to; k++) {
      const Splat& s = splats[order[k]];
      if (k + 4 < n) __builtin_prefetch(&splats[order[k + 4]]);
      if (visible(s)) totals[order[k]] = sortfree_gather<DEPTH, SURFACES>(view, s, grads);
    }
  });
  // by index again: inputs and gradients are then read and written in order
  parallel_parts(n, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 i = from; i < to; i++) {
      if (visible(splats[i]))
        write_gradients(view, i, in, splats[i], splat_grad(totals[i], splats[i], true), out);
      else
        write_zero_gradients(view, i, out);
    }
  });
}

}  // namespace
