// Shared by the CUDA kernels: arguments, sums over a warp, tiles and their batches.
#pragma once
#include "pairs.h"

// `blocks` share a multiprocessor: 4 blocks leave 64 registers per thread. Without this bound,
// ptxas spills registers of some kernels to fit one more block.
#define KERNEL(threads, blocks) extern "C" __global__ void __launch_bounds__(threads, blocks)
#define PARAM const __grid_constant__  // structs stay in the constant bank

namespace {

constexpr int WARP = 32;
constexpr unsigned ALL = 0xffffffffu;
constexpr int THREADS = 256;       // threads of most kernels and of a tile, one per pixel
constexpr int WARPS = THREADS / WARP;
constexpr int WALK_THREADS = 128;    // threads of a tile's sorted backward pass, two pixels each
constexpr int WALK_BATCH = 64;  // entries that they load at a time
constexpr int SUMS = 12;        // floats per Gaussian or entry, in three float4
constexpr int64 LARGE = 8192;   // pixels of a box above which a block takes the Gaussian

// Sorted blending has opacities, sort-free blending lobes; the other is null.
struct Inputs {
  const float *means, *quats, *scales, *opacities, *sh, *lobes, *more;
};
struct Gradients {
  // `more` is added to; it and screen may be null
  float *means, *quats, *scales, *opacities, *sh, *lobes, *more, *screen;
};
// The numbers of Gaussian `i`, as project reads them; those of `sh` where there are no more.
template <class T>
MGS_FN T* more_of(const View& view, T* sh, T* more, int64 i) {
  return more ? more + view.more_width * i - 3 : sh + sh_floats(view) * i;
}
// The Gaussians that each tile visits (cuda_lists.h): entries [starts[tile], starts[tile + 1]). If the
// entries have no room, every tile visits all Gaussians. cuda.py mirrors the fields.
struct Lists {
  const int* starts;    // [tiles + 1]
  const int* ids;       // [room] Gaussians, with FIRST in the first entry of each
  const int* slots;     // [room] slot of the entry, by Gaussian; sorted blending only
  const int* order;     // [n] Gaussians front first; null: by index
  const int64* length;  // number of entries
  int room, n;
};
constexpr int FIRST = (int)0x80000000u;
// `sums` are planes of one float per pixel of all levels: r, g, b, w, T (sorted: r, g, b, T), then z
// for the depth image; with levels, then T of each level's own Gaussians; last the fog of DEPTH_PASS.
struct Outputs {
  float* sums;
  float *image, *alpha, *depth;
};
struct OutputGradients {
  const float *image, *alpha, *depth;
};

MGS_FN int64 global_thread() { return (int64)blockIdx.x * blockDim.x + threadIdx.x; }
MGS_FN int lane_of_thread() { return threadIdx.x % WARP; }
MGS_FN int warp_of_thread() { return threadIdx.x / WARP; }
MGS_FN bool visible(const Splat& s) { return s.x1 > s.x0; }
MGS_FN int tile_count(const View& v) {
  Grid last = grid_of(v, level_count(v) - 1);
  return last.first_tile + last.tiles;
}

// ---------------------------------------------------------------- sums over a block or a warp
// Sums of a number of each thread of a block: of the threads before this one, and of all.
struct BlockSum {
  int before, total;
};

// All threads of the block call it.
MGS_FN BlockSum sum_before(int number) {
  __shared__ int warps[WARPS];
  int sum = number, lane = lane_of_thread();
  for (int offset = 1; offset < WARP; offset *= 2) {
    int more = __shfl_up_sync(ALL, sum, offset);
    if (lane >= offset) sum += more;
  }
  __syncthreads();  // all threads have read the sums of an earlier call
  if (lane == WARP - 1) warps[warp_of_thread()] = sum;
  __syncthreads();
  BlockSum found = {sum - number, 0};
  for (int w = 0; w < WARPS; w++) {
    if (w == warp_of_thread()) found.before += found.total;
    found.total += warps[w];
  }
  return found;
}

template <class T>
MGS_FN T sum_of_lanes(T value) {
  for (int offset = WARP / 2; offset; offset /= 2) value += __shfl_xor_sync(ALL, value, offset);
  return value;
}

// Adds the twelve sums of all lanes of a warp: each lane gets the total of one `component`, or none
// (-1). Halving the components with the lanes takes 13 shuffles; one component after the other, 60.
struct Total {
  float value;
  int component;
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
  float v[SUMS] = {s.r, s.g, s.b, s.z, s.w, s.q, s.qx, s.qy, s.qxx, s.qxy, s.qyy, s.c};
  fold<6>(v, 16);
  fold<3>(v, 8);
  fold<2>(v, 4);  // the last of the four is unused
  fold<1>(v, 2);
  int lane = lane_of_thread();
  int third = (lane & 4 ? 2 : 0) + (lane & 2 ? 1 : 0);
  int component = (lane & 16 ? 6 : 0) + (lane & 8 ? 3 : 0) + third;
  bool has_total = third < 3 && !(lane & 1);
  return {v[0] + __shfl_xor_sync(ALL, v[0], 1), has_total ? component : -1};
}

MGS_FN Sums<float> load_sums(const float* p) {
  const float4* q = (const float4*)p;
  float4 a = q[0], b = q[1], c = q[2];
  return {a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w};
}

// ---------------------------------------------------------------- tiles
// Number of entries if they have room, else 0.
MGS_FN int64 listed(int64 length, int room) { return length <= room ? length : 0; }

// The Gaussians that a tile visits.
struct Visits {
  int first, end;
  const int* ids;  // null: the numbers themselves
};

MGS_FN Visits visits_of(const Lists& lists, int tile) {
  if (*lists.length > lists.room) return {0, lists.n, lists.order};
  return {lists.starts[tile], lists.starts[tile + 1], lists.ids};
}
MGS_FN int gaussian_at(const Visits& visits, int e) {
  return visits.ids ? visits.ids[e] & ~FIRST : e;
}

// Entries of a tile's list in shared memory.
template <int COUNT>
struct Batch {
  float4 place[COUNT];    // x, y, and a and b of a Row, the latter without its dy
  float4 falloff[COUNT];  // c of a Row without its dy^2, log2 opacity, weight, least of a Row
  float4 color[COUNT];    // r, g, b, z
  short4 box[COUNT];      // x0, x1, y0, y1
  float edge[COUNT];      // of sort-free blending: what a soft edge subtracts
};

// Writes one entry; `weighted` multiplies colour and depth by w, for sort-free blending.
template <int COUNT>
MGS_FN void stage(const View& view, Batch<COUNT>& batch, int k, const Splat& s, bool weighted) {
  Row<float> line = row_of(s, 1.0f);
  float w = weighted ? s.weight : 1.0f;
  batch.place[k] = make_float4(s.x, s.y, line.a, line.b);
  batch.falloff[k] = make_float4(-0.5f * LOG2_E * s.C, s.log2_opacity, s.weight, line.least);
  batch.color[k] = make_float4(w * s.r, w * s.g, w * s.b, w * s.z);
  batch.box[k] = make_short4(s.x0, s.x1, s.y0, s.y1);
  if (view.lobe_size) batch.edge[k] = edge_of(view, s);
}

// Stages entries from `e` on, at most COUNT, and returns their number. A Gaussian of another level
// than `level` gets an empty box.
template <int COUNT>
MGS_FN int stage_from(const View& view, Batch<COUNT>& batch, const Visits& visits, int e,
                      const Splat* splats, int level, bool weighted) {
  int left = visits.end - e, count = left < COUNT ? left : COUNT, k = threadIdx.x;
  if (k >= count) return count;
  const Splat& s = splats[gaussian_at(visits, e + k)];
  stage(view, batch, k, s, weighted);
  if (s.level != level) batch.box[k] = make_short4(0, 0, 0, 0);
  return count;
}

// One bit for each of the 32 entries from `base` on: 1 if it touches the w x h pixels at (x, y).
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

// Alpha of one entry at (dx, dy) from its mean, as pair_alpha returns it.
MGS_FN float alpha_at(const float4& place, const float4& falloff, float dx, float dy) {
  Row<float> line = {place.z, place.w * dy, falloff.x * dy * dy + falloff.y, falloff.w};
  return pair_alpha(dx, line);
}

MGS_FN Splat pack(const Projected<float>& p) {
  return {p.x, p.y, p.A, p.B, p.C, p.log2_opacity, p.weight, p.r, p.g, p.b, p.z, p.reach, p.det,
          (short)p.x0, (short)p.x1, (short)p.y0, (short)p.y1, (int)p.level};
}

MGS_FN Projected<float> unpack(const Splat& s) {
  return {s.x, s.y, s.A, s.B, s.C, s.log2_opacity, s.weight, s.r, s.g, s.b, s.z, s.reach, s.det,
          (float)s.x0, (float)s.x1, (float)s.y0, (float)s.y1, (float)s.level};
}

// The pixel of a thread. A warp has 8 x 4 pixels, and skips the Gaussians that miss them.
struct ThreadPixel {
  int level, patch_x, patch_y, x, y;
  bool inside;
  int64 at;  // among the pixels of all levels
};

MGS_FN ThreadPixel thread_pixel(const View& view, int patch_x, int patch_y) {
  ThreadPixel here;
  here.level = level_of_tile(view, blockIdx.x);
  Grid grid = grid_of(view, here.level);
  int tile = blockIdx.x - grid.first_tile, lane = lane_of_thread();
  here.patch_x = tile % grid.across * TILE + patch_x;
  here.patch_y = tile / grid.across * TILE + patch_y;
  here.x = here.patch_x + lane % 8, here.y = here.patch_y + lane / 8;
  here.inside = here.x < grid.width && here.y < grid.height;
  here.at = grid.first_pixel + (int64)here.y * grid.width + here.x;
  return here;
}

MGS_FN ThreadPixel thread_pixel(const View& view) {
  int warp = warp_of_thread();
  return thread_pixel(view, warp % 2 * 8, warp / 2 * 4);
}

}  // namespace
