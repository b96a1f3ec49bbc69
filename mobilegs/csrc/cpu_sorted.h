// Sorted blending on the CPU (render/sorted.py): C = sum(c a T) + T_end bg, T = prod(1 - a) over
// the Gaussians in front (3DGS, Eq. 3). In the forward pass a thread owns a tile, in the backward
// pass a row of tiles.
#pragma once
#include "cpu_common.h"

namespace {

// Channels of a pixel: r, g, b, t and, with depth, z.
template <bool DEPTH>
constexpr int sorted_channels = DEPTH ? 5 : 4;

// One entry of a tile's list, forward. Returns the rows that are not finished (T >= 1e-4).
template <bool DEPTH>
MGS_FN int sorted_entry(const Splat& s, int left, int top, int alive, float* sums) {
  constexpr int C = sorted_channels<DEPTH>;
  const vfloat lanes = iota();
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    Row line = row_of(s, top + row + 0.5f - s.y);
    float* p = sums + row * C * TILE;
    bool open = false;
    for (int l = 0; l < TILE; l += LANES, p += LANES) {
      vfloat alpha = pair_alpha(lanes + (x + l), line), t = load(p + 3 * TILE);
      alpha = min_of(alpha, splat_value(alpha, ALPHA_MAX));
      vfloat share = select(t >= TRANSMITTANCE_MIN, alpha * t, splat_value(t, 0.0f));
      store(p, load(p) + share * s.r);
      store(p + TILE, load(p + TILE) + share * s.g);
      store(p + 2 * TILE, load(p + 2 * TILE) + share * s.b);
      if (DEPTH) store(p + 4 * TILE, load(p + 4 * TILE) + share * s.z);
      t -= share;
      store(p + 3 * TILE, t);
      open |= any_at_least(t, TRANSMITTANCE_MIN);
    }
    if (!open) alive &= ~(1 << row);
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
    for (int row = 0; row < TILE; row++)
      for (int c = 0; c < C; c++)
        std::fill_n(tile_sums + (row * C + c) * TILE, TILE, c == 3 ? 1.0f : 0.0f);
    int alive = (1 << TILE) - 1;
    for (int64 e = bins.start[tile]; e < bins.start[tile + 1] && alive; e++)
      alive = sorted_entry<DEPTH>(splats[bins.ids[e]], left, top, alive, tile_sums);
    for (int row = 0; row < TILE && top + row < view.height; row++) {
      const float* p = tile_sums + row * C * TILE;
      int64 at = (int64)(top + row) * view.width + left;
      for (int l = 0; l < TILE && left + l < view.width; l++) {
        float t = p[3 * TILE + l];
        for (int k = 0; k < 3; k++)
          image[3 * (at + l) + k] = p[k * TILE + l] + t * view.background[k];
        alpha[at + l] = 1 - t;
        if (DEPTH) depth[at + l] = p[(C - 1) * TILE + l];
      }
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
  std::fill_n(walk, TILE * WALK * TILE, 0.0f);
  for (int row = 0; row < TILE; row++) {
    const float* p = sums + row * C * TILE;
    float* w = walk + row * WALK * TILE;
    for (int l = 0; l < TILE; l++) {
      w[4 * TILE + l] = 1;
      if (top + row >= view.height || left + l >= view.width) continue;
      int64 at = (int64)(top + row) * view.width + left + l;
      float t = p[3 * TILE + l], rest = -g_alpha[at] * t;
      for (int k = 0; k < 3; k++) {
        float g = g_image[3 * at + k];
        w[k * TILE + l] = g;
        rest += g * (p[k * TILE + l] + t * view.background[k]);
      }
      if (DEPTH) {
        w[5 * TILE + l] = g_depth[at];
        rest += g_depth[at] * p[(C - 1) * TILE + l];
      }
      w[3 * TILE + l] = rest;
    }
  }
}

// One entry, backward. Adds to `sums` and returns the rows that are not finished.
template <bool DEPTH>
MGS_FN int sorted_entry_adjoint(const Splat& s, int left, int top, int alive, float* walk,
                                Sums<vfloat>& sums) {
  const vfloat lanes = iota();
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    float dy = top + row + 0.5f - s.y;
    Row line = row_of(s, dy);
    float* p = walk + row * WALK * TILE;
    bool open = false;
    for (int l = 0; l < TILE; l += LANES, p += LANES) {
      vfloat dx = lanes + (x + l), raw = pair_alpha(dx, line), t = load(p + 4 * TILE);
      raw = select(t >= TRANSMITTANCE_MIN, raw, splat_value(raw, 0.0f));
      vfloat alpha = min_of(raw, splat_value(raw, ALPHA_MAX)), share = alpha * t;
      vfloat g_r = load(p), g_g = load(p + TILE), g_b = load(p + 2 * TILE);
      sums.r += share * g_r;
      sums.g += share * g_g;
      sums.b += share * g_b;
      vfloat value = g_r * s.r + g_g * s.g + g_b * s.b;
      if (DEPTH) {
        vfloat g_z = load(p + 5 * TILE);
        sums.z += share * g_z;
        value += g_z * s.z;
      }
      vfloat rest = load(p + 3 * TILE) - share * value;
      t -= share;
      store(p + 3 * TILE, rest);
      store(p + 4 * TILE, t);
      open |= any_at_least(t, TRANSMITTANCE_MIN);
      // dL/dalpha = T value - rest / (1 - alpha), times alpha
      vfloat g_q = share * value - alpha * rest * reciprocal(1.0f - alpha);
      add_moments(sums, select(raw > ALPHA_MAX, splat_value(raw, 0.0f), g_q), dx, dy);
    }
    if (!open) alive &= ~(1 << row);
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
      int alive = (1 << TILE) - 1;
      int64 end = bins.start[tile + 1];
      for (int64 e = bins.start[tile]; e < end && alive; e++) {
        int id = bins.ids[e];
        const Splat& s = splats[id];
        Sums<vfloat> entry = {};
        alive = sorted_entry_adjoint<DEPTH>(s, left, top, alive, walk, entry);
        Sums<float> found = reduce(entry);
        int slot = first[id] + row - s.y0 / TILE;
        if (reached[slot]) add(partial[slot], found);
        else partial[slot] = found, reached[slot] = 1;
      }
    }
  });
  parallel_for(n, 1024, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 i = from; i < to; i++) {
      if (!visible(splats[i])) {
        write_zero_gradients(view, i, out);
        continue;
      }
      Sums<float> total = {};
      for (int slot = first[i]; slot < first[i + 1]; slot++)
        if (reached[slot]) add(total, partial[slot]);
      write_gradients(view, i, in, splats[i], splat_grad(total, splats[i], false), out);
    }
  });
}

}  // namespace
