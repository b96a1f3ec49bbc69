// Contributions on the CPU (render/contributions.py): each Gaussian's shares of an image, and the
// largest share of each pixel. A thread owns a row of tiles, as in the sorted backward pass.
#pragma once
#include "cpu_common.h"

namespace {

// Sum of a Gaussian's shares (alpha T) in one row of tiles, and number of pixels that it touches.
struct ShareSum {
  float weight;
  int touched;
};

// The pixels of a tile, row by row: transmittance, largest share so far, and the Gaussian with it.
struct TilePixels {
  alignas(64) float transmittance[TILE * TILE], best[TILE * TILE];
  alignas(64) int32_t winner[TILE * TILE];
};

// One entry of a tile's list: adds to `sum` and returns the rows that are not finished.
MGS_FN int accumulate_entry(const Splat& s, int id, int left, int top, int right, int alive,
                            TilePixels& tile, ShareSum& sum) {
  const vfloat lanes = iota(), none = {};
  vfloat weight = {}, touched = {};
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    Row<float> line = row_of(s, top + row + 0.5f - s.y);
    bool open = false;
    for (int l = 0; l < TILE; l += LANES) {
      int at = row * TILE + l;
      vfloat alpha = pair_alpha(lanes + (x + l), line), t = load(tile.transmittance + at);
      vfloat best = load(tile.best + at);
      alpha = min_of(alpha, splat_value(alpha, ALPHA_MAX));
      alpha = select(lanes < (float)(right - left - l), alpha, none);  // columns of the image
      vfloat share = select(t >= TRANSMITTANCE_MIN, alpha * t, none);
      weight += share;
      touched += select(share > 0, none + 1.0f, none);
      store(tile.winner + at, share > best ? id - (vint){} : load(tile.winner + at));
      store(tile.best + at, max_of(share, best));
      t -= share;
      store(tile.transmittance + at, t);
      open |= any_at_least(t, TRANSMITTANCE_MIN);
    }
    if (!open) alive &= ~(1 << row);
  }
  sum.weight += sum_of(weight);
  sum.touched += (int)sum_of(touched);
  return alive;
}

void measure_contributions(const View& view, int n, const Bins& bins, const Splat* splats,
                           float* weights, int32_t* touched, int32_t* winner, float* alpha) {
  Tiles tiles(view);
  int rows = (view.height + TILE - 1) / TILE;
  std::vector<int> first = row_slots(n, splats);
  std::vector<ShareSum> sums(first[n], ShareSum{0, 0});
  parallel_for(rows, 1, [&](int64 row, int64) {
    FlushDenormals flush;
    TilePixels pixels;
    int top = row * TILE, bottom = std::min(top + TILE, view.height);
    for (int tile = row * tiles.across; tile < (row + 1) * tiles.across; tile++) {
      int left = tile % tiles.across * TILE, right = std::min(left + TILE, view.width);
      std::fill_n(pixels.transmittance, TILE * TILE, 1.0f);
      std::fill_n(pixels.best, TILE * TILE, 0.0f);
      std::fill_n(pixels.winner, TILE * TILE, -1);
      int alive = (1 << (bottom - top)) - 1;
      for (int64 e = bins.start[tile]; e < bins.start[tile + 1] && alive; e++) {
        int id = bins.ids[e];
        const Splat& s = splats[id];
        int slot = first[id] + row - s.y0 / TILE;
        alive = accumulate_entry(s, id, left, top, right, alive, pixels, sums[slot]);
      }
      for (int y = top; y < bottom; y++) {
        int64 to = (int64)y * view.width + left;
        const int at = (y - top) * TILE;
        std::copy_n(pixels.winner + at, right - left, winner + to);
        for (int l = 0; l < right - left; l++) alpha[to + l] = 1 - pixels.transmittance[at + l];
      }
    }
  });
  parallel_parts(n, [&](int64 from, int64 to) {
    FlushDenormals flush;
    for (int64 i = from; i < to; i++) {
      ShareSum total = {0, 0};
      for (int slot = first[i]; slot < first[i + 1]; slot++)
        total.weight += sums[slot].weight, total.touched += sums[slot].touched;
      weights[i] = total.weight, touched[i] = total.touched;
    }
  });
}

}  // namespace
