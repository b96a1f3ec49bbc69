// Sorted blending on the CPU (render/sorted.py): C = sum(c a T) + T_end bg, T = prod(1 - a) over
// the Gaussians in front (3DGS, Eq. 3). In the forward pass a thread owns a tile, in the backward
// pass a row of tiles.
#pragma once
#include "cpu_common.h"

namespace {

// Channels of a pixel: r, g, b, t and, with depth, z.
template <bool DEPTH>
constexpr int sorted_channels = DEPTH ? 5 : 4;

// One entry of a tile's list, forward. Returns the patches that are not finished (T >= 1e-4).
template <bool DEPTH>
MGS_FN Patches sorted_entry(const Splat& s, int left, int top, Patches alive, float* sums) {
  constexpr int C = sorted_channels<DEPTH>;
  PatchBox box(s, left, top);
  for (int x = box.x0; x < box.x1; x++) {
    Row<vfloat> columns = columns_of(s, patch_x() + (left + PATCH * x + 0.5f - s.x));
    for (int y = box.y0; y < box.y1; y++) {
      int patch = y * PATCHES_ACROSS + x;
      if (!(alive >> patch & 1)) continue;
      float* p = sums + patch * C * LANES;
      vfloat dy = patch_y() + (top + PATCH_ROWS * y + 0.5f - s.y);
      vfloat alpha = pair_alpha(dy, columns), t = load(p + 3 * LANES);
      alpha = min_of(alpha, splat_value(alpha, ALPHA_MAX));
      vfloat share = select(t >= TRANSMITTANCE_MIN, alpha * t, splat_value(t, 0.0f));
      store(p, load(p) + share * s.r);
      store(p + LANES, load(p + LANES) + share * s.g);
      store(p + 2 * LANES, load(p + 2 * LANES) + share * s.b);
      if (DEPTH) store(p + 4 * LANES, load(p + 4 * LANES) + share * s.z);
      t -= share;
      store(p + 3 * LANES, t);
      if (!any_at_least(t, TRANSMITTANCE_MIN)) alive &= ~(Patches(1) << patch);
    }
  }
  return alive;
}

template <bool DEPTH>
void sorted_forward(const View& view, const Bins& bins, const Splat* splats, float* sums,
                    float* image, float* alpha, float* depth) {
  constexpr int C = sorted_channels<DEPTH>;
  Tiles tiles(view);
  auto draw = [&](int tile) {
    float* tile_sums = sums + (int64)tile * TILE * C * TILE;
    int left = tile % tiles.across * TILE, top = tile / tiles.across * TILE;
    clear_patches<C>(tile_sums, 3);
    Patches alive = ALL_PATCHES;
    for (int64 e = bins.start[tile], end = bins.start[tile + 1]; e < end && alive; e++) {
      const Splat& s = splat_of(bins, e, end, splats);
      alive = sorted_entry<DEPTH>(s, left, top, alive, tile_sums);
    }
    for (int row = 0; row < TILE && top + row < view.height; row++)
      for (int x = 0; x < TILE && left + x < view.width; x++) {
        const float* p = patch_row<C>(tile_sums, row, x / PATCH) + x % PATCH;
        int64 at = (int64)(top + row) * view.width + left + x;
        float t = p[3 * LANES];
        for (int k = 0; k < 3; k++) image[3 * at + k] = p[k * LANES] + t * view.background[k];
        alpha[at] = 1 - t;
        if (DEPTH) depth[at] = p[(C - 1) * LANES];
      }
  };
  parallel_for(tiles.count, 4, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 tile = from; tile < to; tile++) draw(tile);
  });
}

// Per-pixel state of the backward pass, which goes front to back: dL/d image (3), the part of the
// loss gradient due to the Gaussians behind and the background (1), T (1), dL/d depth (1).
constexpr int WALK = 6;

template <bool DEPTH>
void start_walk(const View& view, const float* sums, int left, int top, const float* g_image,
                const float* g_alpha, const float* g_depth, float* walk) {
  constexpr int C = sorted_channels<DEPTH>;
  clear_patches<WALK>(walk, 4);
  for (int row = 0; row < TILE && top + row < view.height; row++)
    for (int x = 0; x < TILE && left + x < view.width; x++) {
      const float* p = patch_row<C>(sums, row, x / PATCH) + x % PATCH;
      float* w = patch_row<WALK>(walk, row, x / PATCH) + x % PATCH;
      int64 at = (int64)(top + row) * view.width + left + x;
      float t = p[3 * LANES], rest = -g_alpha[at] * t;
      for (int k = 0; k < 3; k++) {
        float g = g_image[3 * at + k];
        w[k * LANES] = g;
        rest += g * (p[k * LANES] + t * view.background[k]);
      }
      if (DEPTH) {
        w[5 * LANES] = g_depth[at];
        rest += g_depth[at] * p[(C - 1) * LANES];
      }
      w[3 * LANES] = rest;
    }
}

// One entry, backward. Adds to `sums` and returns the patches that are not finished.
template <bool DEPTH>
MGS_FN Patches sorted_entry_adjoint(const Splat& s, int left, int top, Patches alive, float* walk,
                                    Sums<vfloat>& sums) {
  PatchBox box(s, left, top);
  for (int x = box.x0; x < box.x1; x++) {
    vfloat dx = patch_x() + (left + PATCH * x + 0.5f - s.x), q = {}, qy = {};
    Row<vfloat> columns = columns_of(s, dx);
    for (int y = box.y0; y < box.y1; y++) {
      int patch = y * PATCHES_ACROSS + x;
      if (!(alive >> patch & 1)) continue;
      vfloat dy = patch_y() + (top + PATCH_ROWS * y + 0.5f - s.y);
      float* p = walk + patch * WALK * LANES;
      vfloat raw = pair_alpha(dy, columns), t = load(p + 4 * LANES);
      raw = select(t >= TRANSMITTANCE_MIN, raw, splat_value(raw, 0.0f));
      vfloat alpha = min_of(raw, splat_value(raw, ALPHA_MAX)), share = alpha * t;
      vfloat g_r = load(p), g_g = load(p + LANES), g_b = load(p + 2 * LANES);
      sums.r += share * g_r;
      sums.g += share * g_g;
      sums.b += share * g_b;
      vfloat value = g_r * s.r + g_g * s.g + g_b * s.b;
      if (DEPTH) {
        vfloat g_z = load(p + 5 * LANES);
        sums.z += share * g_z;
        value += g_z * s.z;
      }
      vfloat rest = load(p + 3 * LANES) - share * value;
      t -= share;
      store(p + 3 * LANES, rest);
      store(p + 4 * LANES, t);
      if (!any_at_least(t, TRANSMITTANCE_MIN)) alive &= ~(Patches(1) << patch);
      // dL/dalpha = T value - rest / (1 - alpha), times alpha
      vfloat g_q = share * value - alpha * rest * reciprocal(1.0f - alpha);
      g_q = select(raw > ALPHA_MAX, splat_value(raw, 0.0f), g_q);
      vfloat g_y = g_q * dy;
      q += g_q;
      qy += g_y;
      sums.qyy += g_y * dy;
    }
    add_columns(sums, q, qy, dx);
  }
  return alive;
}

template <bool DEPTH>
void sorted_backward(const View& view, int n, const Inputs& in, const Splat* splats,
                     const Bins& bins, const float* sums, const float* g_image,
                     const float* g_alpha, const float* g_depth, const Gradients& out) {
  constexpr int C = sorted_channels<DEPTH>;
  Tiles tiles(view);
  int rows = (view.height + TILE - 1) / TILE;
  // Each (Gaussian, row of tiles) has its own slot. One thread walks a row of tiles from left to
  // right, and a Gaussian adds its slots downwards: the order of all sums is fixed.
  std::vector<int> first = row_slots(n, splats);
  Buffer<Sums<float>> partial(first[n]);
  std::vector<unsigned char> reached(first[n], 0);
  parallel_for(rows, 1, [&](int64 row, int64) {
    FlushDenormals flush;
    alignas(64) float walk[TILE * WALK * TILE];
    for (int tile = row * tiles.across; tile < (row + 1) * tiles.across; tile++) {
      int left = tile % tiles.across * TILE, top = row * TILE;
      start_walk<DEPTH>(view, sums + (int64)tile * TILE * C * TILE, left, top, g_image, g_alpha,
                        g_depth, walk);
      Patches alive = ALL_PATCHES;
      int64 end = bins.start[tile + 1];
      for (int64 e = bins.start[tile]; e < end && alive; e++) {
        int id = bins.ids[e];
        const Splat& s = splat_of(bins, e, end, splats);
        Sums<vfloat> entry = {};
        alive = sorted_entry_adjoint<DEPTH>(s, left, top, alive, walk, entry);
        Sums<float> found = reduce(entry);
        int slot = first[id] + row - s.y0 / TILE;
        if (reached[slot]) add(partial[slot], found);
        else partial[slot] = found, reached[slot] = 1;
      }
    }
  });
  auto total_of = [&](int64 i) {
    Sums<float> total = {};
    for (int slot = first[i]; slot < first[i + 1]; slot++)
      if (reached[slot]) add(total, partial[slot]);
    return total;
  };
  write_gradients(view, n, in, splats, false, total_of, out);
}

}  // namespace
