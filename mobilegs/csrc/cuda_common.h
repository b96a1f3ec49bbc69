// What the GPU's two renderers share: arguments, adding up over a warp, tiles and their batches.
#pragma once
#include "pairs.h"

namespace {

constexpr int WARP = 32;
constexpr unsigned ALL = 0xffffffffu;
constexpr int MANY = 256;       // threads of most kernels, and of a tile: one a pixel
constexpr int WALKERS = 128;    // threads of a tile's backward walk: two pixels each
constexpr int WALK_BATCH = 64;  // entries that they take at a time
constexpr int SUMS = 12;        // floats a Gaussian or an entry: 11 sums, in three float4
constexpr int64 LARGE = 8192;   // pixels of a box beyond which a whole block takes the Gaussian

// Sorted blending is given opacities, order-independent blending lobes; the other is null.
struct Inputs {
  const float *means, *quats, *scales, *opacities, *sh, *lobes;
};
struct Gradients {
  float *means, *quats, *scales, *opacities, *sh, *lobes, *screen;  // screen may be null, too
};
// Which Gaussians each tile must visit: entries [starts[tile], starts[tile + 1]).
struct Lists {
  const int64* starts;  // [tiles + 1]
  const int* ids;       // [entries] Gaussians
  const int64* slots;   // [entries] each one's place among its Gaussian's entries
};
// `sums` are planes of h w floats: r, g, b, w, t (sorted: r, g, b, t), then z where depth is asked,
// then the limits where there are two passes.
struct Picture {
  float* sums;
  float *image, *alpha, *depth;
};
struct PictureGradients {
  const float *image, *alpha, *depth;
};

MGS_FN int64 global_thread() { return (int64)blockIdx.x * blockDim.x + threadIdx.x; }
MGS_FN int lane_of_thread() { return threadIdx.x % WARP; }
MGS_FN int warp_of_thread() { return threadIdx.x / WARP; }
MGS_FN bool visible(const Splat& s) { return s.x1 > s.x0; }
MGS_FN int tiles_across(const View& v) { return (v.width + TILE - 1) / TILE; }
MGS_FN int tile_count(const View& v) { return tiles_across(v) * ((v.height + TILE - 1) / TILE); }

// ---------------------------------------------------------------- adding up
// The eleven sums of every lane of a warp, added over the lanes: lane l ends with the total of
// component `mine`, or with nothing to say (-1). Halving the components with the lanes takes 13
// shuffles where adding each by itself takes 55.
struct Total {
  float value;
  int mine;
};

template <int HALF>
MGS_FN void fold(float* v, int offset) {
  bool high = threadIdx.x & offset;
  UNROLL
  for (int k = 0; k < HALF; k++) {
    float keep = high ? v[k + HALF] : v[k], give = high ? v[k] : v[k + HALF];
    v[k] = keep + __shfl_xor_sync(ALL, give, offset);
  }
}

MGS_FN Total add_lanes(const Sums<float>& s) {
  float v[SUMS] = {s.r, s.g, s.b, s.z, s.w, s.q, s.qx, s.qy, s.qxx, s.qxy, s.qyy, 0.0f};
  fold<6>(v, 16);
  fold<3>(v, 8);
  fold<2>(v, 4);  // the last of the four is nobody's
  fold<1>(v, 2);
  int lane = lane_of_thread();
  int third = (lane & 4 ? 2 : 0) + (lane & 2 ? 1 : 0);
  int component = (lane & 16 ? 6 : 0) + (lane & 8 ? 3 : 0) + third;
  bool speaks = third < 3 && !(lane & 1);
  return {v[0] + __shfl_xor_sync(ALL, v[0], 1), speaks ? component : -1};
}

MGS_FN Sums<float> load_sums(const float* p) {
  const float4* q = (const float4*)p;
  float4 a = q[0], b = q[1], c = q[2];
  return {a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z};
}

// ---------------------------------------------------------------- tiles
// The entries that a block reads together, in shared memory.
template <int COUNT>
struct Batch {
  float4 place[COUNT];    // x, y, and a and b of a Row, the latter without its dy
  float4 falloff[COUNT];  // c of a Row without its dy^2, log2 opacity, weight, least of a Row
  float4 color[COUNT];    // r, g, b, z
  short4 box[COUNT];      // x0, x1, y0, y1
};

// `weighted` multiplies colour and depth by the weight of sort-free blending.
template <int COUNT>
MGS_FN void stage(Batch<COUNT>& batch, int k, const Splat& s, bool weighted) {
  Row line = row_of(s, 1.0f);
  float w = weighted ? s.weight : 1.0f;
  batch.place[k] = make_float4(s.x, s.y, line.a, line.b);
  batch.falloff[k] = make_float4(-0.5f * LOG2_E * s.C, s.log2_opacity, s.weight, line.least);
  batch.color[k] = make_float4(w * s.r, w * s.g, w * s.b, w * s.z);
  batch.box[k] = make_short4(s.x0, s.x1, s.y0, s.y1);
}

// Which of the 32 entries from `base` on touch the w x h pixels at (x, y): one bit each.
template <int COUNT>
MGS_FN unsigned touching(const Batch<COUNT>& batch, int base, int count, int x, int y, int w,
                         int h) {
  int k = base + lane_of_thread();
  bool touches = false;
  if (k < count) {
    short4 box = batch.box[k];
    touches = box.x < x + w && box.y > x && box.z < y + h && box.w > y;
  }
  return __ballot_sync(ALL, touches);
}

// Alpha of one entry at (x, y), before its ceiling.
MGS_FN float alpha_at(const float4& place, const float4& falloff, float dx, float dy) {
  Row line = {place.z, place.w * dy, falloff.x * dy * dy + falloff.y, falloff.w};
  return pair_alpha(dx, line);
}

// A tile's thread and its pixel; a warp holds 8 x 4 of them, so that it skips what misses those.
struct Spot {
  int patch_x, patch_y, x, y;
  bool inside;
};

MGS_FN Spot spot_of(const View& view, int patch_x, int patch_y) {
  int across = tiles_across(view), lane = lane_of_thread();
  Spot spot;
  spot.patch_x = blockIdx.x % across * TILE + patch_x;
  spot.patch_y = blockIdx.x / across * TILE + patch_y;
  spot.x = spot.patch_x + lane % 8, spot.y = spot.patch_y + lane / 8;
  spot.inside = spot.x < view.width && spot.y < view.height;
  return spot;
}

MGS_FN Spot spot_of(const View& view) {
  int warp = warp_of_thread();
  return spot_of(view, warp % 2 * 8, warp / 2 * 4);
}

MGS_FN int64 index_of(const View& view, const Spot& spot) {
  return (int64)spot.y * view.width + spot.x;
}

}  // namespace
