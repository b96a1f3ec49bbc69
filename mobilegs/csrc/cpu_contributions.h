// Sorted blending's statistics on the CPU: what each Gaussian gives to a picture, and who gives a
// pixel most. A thread owns a row of tiles, as in the backward walk.
#pragma once
#include "cpu_common.h"

namespace {

// A Gaussian's shares of the pixels of one row of tiles.
struct Given {
  float weight;
  int touched;
};

// The pixels of a tile, row by row: light left, the largest share so far, and whose it is.
struct Bidding {
  alignas(64) float light[TILE * TILE], best[TILE * TILE];
  alignas(64) int32_t winner[TILE * TILE];
};

// One entry of a tile's list: adds to `given` and returns the rows on which light is left.
MGS_FN int bid(const Splat& s, int id, int left, int top, int right, int alive, Bidding& tile,
               Given& given) {
  const vfloat steps = iota(), none = {};
  vfloat weight = {}, touched = {};
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    Row line = row_of(s, top + row + 0.5f - s.y);
    bool open = false;
    for (int l = 0; l < TILE; l += LANES) {
      int at = row * TILE + l;
      vfloat alpha = pair_alpha(steps + (x + l), line), t = load(tile.light + at);
      vfloat best = load(tile.best + at);
      alpha = min_of(alpha, splat_value(alpha, ALPHA_MAX));
      alpha = select(steps < (float)(right - left - l), alpha, none);  // columns of the picture
      vfloat share = select(t >= TRANSMITTANCE_MIN, alpha * t, none);
      weight += share;
      touched += select(share > 0, none + 1.0f, none);
      store(tile.winner + at, share > best ? id - (vint){} : load(tile.winner + at));
      store(tile.best + at, max_of(share, best));
      t -= share;
      store(tile.light + at, t);
      open |= any_at_least(t, TRANSMITTANCE_MIN);
    }
    if (!open) alive &= ~(1 << row);
  }
  given.weight += sum_of(weight);
  given.touched += (int)sum_of(touched);
  return alive;
}

void measure_contributions(const View& view, int n, const Bins& bins, const Splat* splats,
                           float* weights, int32_t* touched, int32_t* winner, float* alpha) {
  Tiles tiles(view);
  int rows = (view.height + TILE - 1) / TILE;
  std::vector<int> first = row_places(n, splats);
  std::vector<Given> given(first[n], Given{0, 0});
#pragma omp parallel
  {
    FlushDenormals flush;
#pragma omp for schedule(dynamic, 1)
    for (int row = 0; row < rows; row++) {
      Bidding pixels;
      int top = row * TILE, bottom = std::min(top + TILE, view.height);
      for (int tile = row * tiles.across; tile < (row + 1) * tiles.across; tile++) {
        int left = tile % tiles.across * TILE, right = std::min(left + TILE, view.width);
        std::fill_n(pixels.light, TILE * TILE, 1.0f);
        std::fill_n(pixels.best, TILE * TILE, 0.0f);
        std::fill_n(pixels.winner, TILE * TILE, -1);
        int alive = (1 << (bottom - top)) - 1;
        for (int64 e = bins.start[tile]; e < bins.start[tile + 1] && alive; e++) {
          int id = bins.ids[e];
          const Splat& s = splats[id];
          alive = bid(s, id, left, top, right, alive, pixels, given[first[id] + row - s.y0 / TILE]);
        }
        for (int y = top; y < bottom; y++) {
          int64 to = (int64)y * view.width + left;
          const int at = (y - top) * TILE;
          std::copy_n(pixels.winner + at, right - left, winner + to);
          for (int l = 0; l < right - left; l++) alpha[to + l] = 1 - pixels.light[at + l];
        }
      }
    }
#pragma omp for schedule(static)
    for (int i = 0; i < n; i++) {
      Given total = {0, 0};
      for (int place = first[i]; place < first[i + 1]; place++)
        total.weight += given[place].weight, total.touched += given[place].touched;
      weights[i] = total.weight, touched[i] = total.touched;
    }
  }
}

}  // namespace
