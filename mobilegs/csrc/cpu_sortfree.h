// Order-independent blending on the CPU (render/sortfree.py, paper Eq. 2): sums of c a w, a w and
// the product T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in
// pairs.h. In the forward pass a thread owns a tile, in the backward pass a Gaussian. With levels
// (render/levels.py), the tiles are those of all targets; each target is then enlarged and added to
// the next finer one.
#pragma once
#include "cpu_common.h"
#include "depth_pass.h"

namespace {

// Channels of a pixel's sums: r, g, b, w, T, then z for the depth image.
template <bool DEPTH>
constexpr int channels = 5 + DEPTH;
constexpr int FOG = 3;  // numbers of a pixel's Fog, for DEPTH_PASS

// Planes of a row of `sums`: the channels, with PASS the fog; with levels, first T of this level's
// own Gaussians.
template <bool DEPTH, bool PASS>
int planes(const Tiles& tiles) {
  return channels<DEPTH> + (tiles.levels > 1) + FOG * PASS;
}

// Calls work(patch, alpha) for the patches of the tile at (left, top) that a splat's box touches.
template <class Work>
MGS_FN void for_patches(const Splat& s, int left, int top, Work work) {
  PatchBox box(s, left, top);
  for (int x = box.x0; x < box.x1; x++) {
    Row<vfloat> columns = columns_of(s, patch_x() + (left + PATCH * x + 0.5f - s.x));
    for (int y = box.y0; y < box.y1; y++)
      work(y * PATCHES_ACROSS + x,
           pair_alpha(patch_y() + (top + PATCH_ROWS * y + 0.5f - s.y), columns));
  }
}

// The picture of the depth pass: the sums of a, a ln z and a (ln z)^2, a plane each.
Buffer<float> depth_moments(const View& view, int n, const Splat* splats) {
  View pass = depth_view(view);
  Buffer<Splat> coarse(n);
  parallel_parts(n, [&](int64 from, int64 to) {
    for (int64 i = from; i < to; i++) {
      coarse.get()[i] = splats[i];
      if (visible(splats[i])) coarse.get()[i] = depth_splat(pass, splats[i]);
    }
  });
  Bins bins = bin(pass, n, coarse.get(), nullptr);
  Grid grid = grid_of(pass, 0);
  Buffer<float> moments((int64)grid.width * grid.height * FOG);
  parallel_for(grid.tiles, 4, [&](int64 first, int64 last) {
    FlushDenormals flush;
    for (int64 tile = first; tile < last; tile++) {
      alignas(64) float sums[TILE * FOG * TILE];
      int left = tile % grid.across * TILE, top = tile / grid.across * TILE;
      clear_patches<FOG>(sums, -1);
      for (int64 e = bins.start[tile], end = bins.start[tile + 1]; e < end; e++) {
        const Splat& s = splat_of(bins, e, end, coarse.get());
        float edge = edge_of(view, s), u = s.r, uu = u * u;
        for_patches(s, left, top, [&](int patch, vfloat raw) {
          float* p = sums + patch * FOG * LANES;
          vfloat alpha = finish_alpha(raw, edge);
          store(p, load(p) + alpha);
          store(p + LANES, load(p + LANES) + alpha * u);
          store(p + 2 * LANES, load(p + 2 * LANES) + alpha * uu);
        });
      }
      int wide = std::min(TILE, grid.width - left);
      for (int row = 0; row < TILE && top + row < grid.height; row++)
        for (int x = 0; x < wide; x += PATCH)
          for (int c = 0; c < FOG; c++)
            std::copy_n(patch_row<FOG>(sums, row, x / PATCH) + c * LANES, std::min(PATCH, wide - x),
                        moments.get() + ((int64)c * grid.height + top + row) * grid.width + left + x);
    }
  });
  return moments;
}

MGS_FN Fog<vfloat> fog_at(const float* p, int64 plane) {
  return {load(p), load(p + plane), load(p + 2 * plane)};
}

template <bool DEPTH, bool PASS>
void sortfree_tile(const View& view, const Bins& bins, int tile, int left, int top,
                   const Splat* splats, const float* fogs, float* sums) {
  constexpr int C = channels<DEPTH>;
  clear_patches<C>(sums, 4);
  for (int64 e = bins.start[tile], end = bins.start[tile + 1]; e < end; e++) {
    const Splat& s = splat_of(bins, e, end, splats);
    float edge = edge_of(view, s), w = s.weight;
    float r = w * s.r, g = w * s.g, b = w * s.b, z = w * s.z, log_z = PASS ? log_depth(s) : 0;
    for_patches(s, left, top, [&](int patch, vfloat alpha) {
      float* p = sums + patch * C * LANES;
      alpha = finish_alpha(alpha, edge);
      vfloat t = load(p + 4 * LANES);
      store(p + 4 * LANES, t - t * alpha);
      if (PASS) alpha *= visibility(fog_at(fogs + patch * FOG * LANES, LANES), log_z);
      store(p, load(p) + alpha * r);
      store(p + LANES, load(p + LANES) + alpha * g);
      store(p + 2 * LANES, load(p + 2 * LANES) + alpha * b);
      store(p + 3 * LANES, load(p + 3 * LANES) + alpha * w);
      if (DEPTH) store(p + 5 * LANES, load(p + 5 * LANES) + alpha * z);
    });
  }
}

template <bool DEPTH, class V>
MGS_FN Pixel<V> pixel_at(const float* p, int width) {
  auto at = [=](int channel) { return load_as(p + channel * width, V{}); };
  return {at(0), at(1), at(2), DEPTH ? at(5) : V{}, at(3), at(4)};
}

// Calls work(V, x) for the pixels [left, right): for LANES of them as long as there are so many.
template <class Work>
MGS_FN void for_pixels(int left, int right, Work work) {
  for (; left + LANES <= right; left += LANES) work(vfloat{}, left);
  for (; left < right; left++) work(0.0f, left);
}

// Adds a row of the next coarser target to row y of a target, both enlarged sums (render/levels.py,
// `enlarge`). Keeps T of the row's own Gaussians in the last plane. `blend` has room for a row.
template <int C, int PLANES>
void add_enlarged(const Grid& fine, const Grid& coarse, bool to_image, int y, const float* from,
                  float* row, float* blend) {
  int at = to_image ? y : y - 1, nearest = (at >> 1) + 1, neighbour = nearest + 2 * (at & 1) - 1;
  int64 line = (int64)(PLANES + 1) * coarse.width;
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
  for_pixels(left, right, [&](auto zero, int x) {
    using V = decltype(zero);
    int64 at = (int64)y * view.width + x;
    V color[3], coverage, z;
    sortfree_resolve(view, pixel_at<DEPTH, V>(row + x, view.width), color, &coverage,
                     DEPTH ? &z : nullptr);
    int lanes = lanes_of(zero);
    lanes_to_rows((const float*)color, lanes, 3, lanes,
                  [=](int i) { return image + 3 * (at + i); });
    store(alpha + at, coverage);
    if (DEPTH) store(depth + at, z);
  });
}

template <bool DEPTH, bool PASS>
void sortfree_forward(const View& view, int n, const Splat* splats, float* sums, float* image,
                      float* alpha, float* depth) {
  constexpr int C = channels<DEPTH>;
  Bins bins = bin(view, n, splats, nullptr);
  Tiles tiles(view);
  int stored = planes<DEPTH, PASS>(tiles);
  Buffer<float> moments;
  if (PASS) moments = depth_moments(view, n, splats);
  Grid picture = grid_of(view, PASS_LEVEL);
  auto draw = [&](int tile) {
    alignas(64) float tile_sums[TILE * C * TILE], fogs[PASS ? TILE * FOG * TILE : 1];
    const Grid& grid = tiles.grid_of_tile(tile);
    int place = tile - grid.first_tile;
    int left = place % grid.across * TILE, top = place / grid.across * TILE;
    int wide = std::min(TILE, grid.width - left), level = level_of_tile(view, tile);
    for (int row = 0; PASS && row < TILE; row++) {
      float* line = sums + (grid.first_pixel + (int64)(top + row) * grid.width) * stored + left;
      for (int x = 0; x < TILE; x++) {
        Fog<float> fog = fog_of_pixel(picture, moments.get(), level, left + x, top + row);
        const float numbers[FOG] = {fog.density, fog.first, fog.slope};
        for (int c = 0; c < FOG; c++) {
          patch_row<FOG>(fogs, row, x / PATCH)[c * LANES + x % PATCH] = numbers[c];
          if (x < wide && top + row < grid.height)
            line[(stored - FOG + c) * grid.width + x] = numbers[c];
        }
      }
    }
    sortfree_tile<DEPTH, PASS>(view, bins, tile, left, top, splats, fogs, tile_sums);
    for (int row = 0; row < TILE && top + row < grid.height; row++) {
      float* line = sums + (grid.first_pixel + (int64)(top + row) * grid.width) * stored;
      for (int x = 0; x < wide; x += PATCH) {
        const float* p = patch_row<C>(tile_sums, row, x / PATCH);
        float* to = line + left + x;
        for (int c = 0; c < C; c++)
          std::copy_n(p + c * LANES, std::min(PATCH, wide - x), to + c * grid.width);
      }
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
        add_enlarged<C, C + FOG * PASS>(fine, coarse, l == 0, y, from, row, blend.data());
        if (l == 0) resolve_row<DEPTH>(view, row, y, 0, view.width, image, alpha, depth);
      }
    });
  }
}

// dL/d of the sums of every pixel of all levels: channel planes within each row, padded so that a
// vector may start at any pixel, and rows of zeros below. The plane of T holds T dL/dT; with PASS the
// fog follows.
struct PixelGradients {
  Buffer<float> values;
  int64 first[LEVELS];
  int stride[LEVELS];
  float* row(int level, int y, int channels) const {
    return values.get() + first[level] + (int64)y * channels * stride[level];
  }
};

constexpr int SPARE_ROWS = LANES / 4 - 1;  // a vector holds at most that many below a box
constexpr int PAD = 8;                     // floats on each side of a row

// dL/d of a coarse row: the transpose of add_enlarged. `sum` has room for a row of the finer target
// and PAD floats on each side.
template <int C, int PLANES>
void reduce_gradients(const Grid& fine, const Grid& coarse, int level, int y,
                      const PixelGradients& grads, const float* sums, float* sum) {
  bool to_image = level == 0;
  int before = to_image ? 3 : 2;  // the four finer rows or columns begin at 2 y - before
  float* to = grads.row(level + 1, y, PLANES);
  float* middle = sum + PAD;
  for (int c = 0; c < C; c++) {
    std::fill_n(sum, fine.width + 2 * PAD, 0.0f);
    for (int k = 0; k < 4; k++) {
      int from = 2 * y - before + k;
      if (from < 0 || from >= fine.height) continue;
      float share = k == 0 || k == 3 ? 0.25f : 0.75f;
      const float* g = grads.row(level, from, PLANES) + c * grads.stride[level];
      const float* own = sums + ((int64)from * (PLANES + 1) + C) * fine.width;  // T of its Gaussians
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

template <bool DEPTH, bool PASS>
PixelGradients pixel_gradients(const View& view, const Tiles& tiles, const float* sums,
                               const float* g_image, const float* g_alpha, const float* g_depth) {
  constexpr int C = channels<DEPTH>, PLANES = C + FOG * PASS;
  int stored = planes<DEPTH, PASS>(tiles);
  bool leveled = tiles.levels > 1;
  PixelGradients grads;
  int64 size = 0;
  for (int l = 0; l < tiles.levels; l++) {
    grads.first[l] = size, grads.stride[l] = tiles.grids[l].width + LANES;
    size += (int64)(tiles.grids[l].height + SPARE_ROWS) * PLANES * grads.stride[l];
  }
  grads.values = Buffer<float>(size);
  for (int l = 0; l < tiles.levels; l++)
    std::fill_n(grads.row(l, tiles.grids[l].height, PLANES), SPARE_ROWS * PLANES * grads.stride[l],
                0.0f);
  auto start_row = [&](int64 y) {
    const float* p = sums + (int64)y * stored * view.width;
    float* out = grads.row(0, y, PLANES);
    int stride = grads.stride[0];
    for_pixels(0, view.width, [&](auto zero, int x) {
      using V = decltype(zero);
      int64 at = (int64)y * view.width + x;
      int lanes = lanes_of(zero);
      V g_color[3];
      rows_to_lanes([=](int i) { return g_image + 3 * (at + i); }, 3, lanes, (float*)g_color, lanes);
      Pixel<V> pixel = pixel_at<DEPTH, V>(p + x, view.width);
      Pixel<V> d = sortfree_pixel_adjoint(view, pixel, g_color, load_as(g_alpha + at, zero),
                                          DEPTH ? load_as(g_depth + at, zero) : zero);
      float* to = out + x;
      store(to, d.r), store(to + stride, d.g), store(to + 2 * stride, d.b);
      store(to + 3 * stride, d.w), store(to + 4 * stride, leveled ? d.t : d.t * pixel.t);
      if (DEPTH) store(to + 5 * stride, d.z);
    });
    for (int c = 0; c < C; c++)
      std::fill_n(out + c * stride + view.width, stride - view.width, 0.0f);
  };
  parallel_parts(view.height, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 y = from; y < to; y++) start_row(y);
  });
  for (int l = 0; PASS && l < tiles.levels; l++) {
    const Grid& grid = tiles.grids[l];
    parallel_parts(grid.height, [&](int64 from, int64 to) {
      for (int64 y = from; y < to; y++) {
        const float* p = sums + (grid.first_pixel + y * grid.width) * stored;
        float* out = grads.row(l, y, PLANES);
        for (int c = 0; c < FOG; c++) {
          float* end = std::copy_n(p + (stored - FOG + c) * grid.width, grid.width,
                                   out + (C + c) * grads.stride[l]);
          std::fill_n(end, grads.stride[l] - grid.width, 0.0f);
        }
      }
    });
  }
  for (int l = 0; leveled && l < tiles.levels; l++) {
    const Grid& fine = tiles.grids[l];
    const float* own = sums + fine.first_pixel * stored;
    if (l + 1 < tiles.levels)
      parallel_parts(tiles.grids[l + 1].height, [&](int64 from, int64 to) {
        FlushDenormals flush;
        std::vector<float> sum(fine.width + 2 * PAD);
        for (int64 y = from; y < to; y++)
          reduce_gradients<C, PLANES>(fine, tiles.grids[l + 1], l, y, grads, own, sum.data());
      });
    parallel_parts(fine.height, [&](int64 from, int64 to) {
      FlushDenormals flush;
      for (int64 y = from; y < to; y++) {
        float* g = grads.row(l, y, PLANES) + 4 * grads.stride[l];
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

// Adds what rows [from, to) of a box give, in columns of pixels from `x` on. A vector holds ROWS
// rows of LANES / ROWS columns.
template <bool DEPTH, bool PASS, int ROWS>
MGS_FN void gather_columns(Sums<vfloat>& sums, const Splat& s, float edge,
                           const PixelGradients& grads, int x, int from, int to) {
  constexpr int C = channels<DEPTH>, PLANES = C + FOG * PASS, WIDE = LANES / ROWS;
  int stride = grads.stride[s.level];
  int64 step = (int64)PLANES * stride;
  float log_z = PASS ? log_depth(s) : 0;
  vfloat row = {}, dx = {};
  for (int i = 0; i < LANES; i++) row[i] = i / WIDE, dx[i] = i % WIDE;
  dx += x + 0.5f - s.x;
  Row<vfloat> column = columns_of(s, dx);
  vfloat q = {}, qy = {};
  const float* p = grads.row(s.level, from, PLANES) + x;
  for (int y = from; y < to; y += ROWS, p += ROWS * step) {
    vfloat dy = row + (y + 0.5f - s.y);
    vfloat raw = pair_alpha(dy, column);
    if (ROWS > 1) raw = select(row < (float)(to - y), raw, vfloat{});
    auto plane = [&](int c) { return load_rows<ROWS>(p + c * stride, step); };
    vfloat g[6] = {plane(0), plane(1), plane(2), plane(3), plane(4), DEPTH ? plane(5) : vfloat{}};
    if (PASS) {
      vfloat share = visibility(Fog<vfloat>{plane(C), plane(C + 1), plane(C + 2)}, log_z);
      for (int c : {0, 1, 2, 3, 5}) g[c] *= share;
    }
    vfloat g_q = sortfree_pair_adjoint<DEPTH>(sums, s, raw, edge, g[0], g[1], g[2], g[5], g[3], g[4]);
    vfloat g_y = g_q * dy;
    q += g_q;
    qy += g_y;
    sums.qyy += g_y * dy;
  }
  add_columns(sums, q, qy, dx);
}

template <bool DEPTH, bool PASS>
MGS_FN Sums<float> sortfree_gather(const View& view, const Splat& s,
                                   const PixelGradients& grads) {
  Sums<vfloat> sums = {};
  float edge = edge_of(view, s);
  int width = s.x1 - s.x0;
  if (LANES >= 16 && width <= LANES / 4) {
    gather_columns<DEPTH, PASS, LANES / 4>(sums, s, edge, grads, s.x0, s.y0, s.y1);
  } else if (LANES >= 8 && width <= LANES / 2) {
    gather_columns<DEPTH, PASS, 2>(sums, s, edge, grads, s.x0, s.y0, s.y1);
  } else if (width <= LANES) {
    gather_columns<DEPTH, PASS, 1>(sums, s, edge, grads, s.x0, s.y0, s.y1);
  } else {
    Splat turned = s;  // its rows are columns
    std::swap(turned.x, turned.y), std::swap(turned.A, turned.C);
    for (int x = s.x0; x < s.x1; x += LANES) {
      float top, bottom;
      row_span(turned, x + 0.5f, std::min(x + LANES, (int)s.x1) - 0.5f, top, bottom);
      int from = std::max((int)s.y0, (int)(top - 0.51f));
      int to = std::min((int)s.y1, (int)(bottom - 0.49f) + 2);
      gather_columns<DEPTH, PASS, 1>(sums, s, edge, grads, x, from, to);
    }
  }
  return reduce(sums);
}

template <bool DEPTH, bool PASS>
void sortfree_backward(const View& view, int n, const Inputs& in, const Splat* splats,
                       const float* sums, const float* g_image, const float* g_alpha,
                       const float* g_depth, const Gradients& out) {
  Tiles tiles(view);
  PixelGradients grads =
      pixel_gradients<DEPTH, PASS>(view, tiles, sums, g_image, g_alpha, g_depth);
  std::vector<int> order = screen_order(view, n, splats);
  Buffer<Sums<float>> totals(n);
  parallel_for(n, 256, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 k = from; k < to; k++) {
      const Splat& s = splats[order[k]];
      if (k + 4 < n) __builtin_prefetch(&splats[order[k + 4]]);
      if (visible(s)) totals[order[k]] = sortfree_gather<DEPTH, PASS>(view, s, grads);
    }
  });
  // by index again: inputs and gradients are then read and written in order
  write_gradients(view, n, in, splats, true, [&](int64 i) { return totals[i]; }, out);
}

}  // namespace
