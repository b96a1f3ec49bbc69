// The GPU's loops over core.h, compiled by NVRTC at first use; cuda.py launches them and says in
// which order. One thread per pixel or Gaussian, or one warp per Gaussian; no atomics: whatever
// several threads add up has one place per addend and one order of adding, so that equal inputs
// give equal bits. Never run on a GPU so far: compiled for two of them in tests, and executed there
// thread by thread on a CPU.
#include "core.h"

// `blocks` of them share a multiprocessor: 4 leave 64 registers a thread. Left to itself, ptxas
// spills some kernels to make room for one block more.
#define KERNEL(threads, blocks) extern "C" __global__ void __launch_bounds__(threads, blocks)
#define GIVEN const __grid_constant__  // structs stay in the constant bank

namespace {

constexpr int WARP = 32;
constexpr unsigned ALL = 0xffffffffu;
constexpr int MANY = 256;      // threads of most kernels, and of a tile: one a pixel
constexpr int WALKERS = 128;   // threads of a tile's backward walk: two pixels each
constexpr int WALK_BATCH = 64;  // entries that they take at a time
constexpr int SUMS = 12;       // floats a Gaussian or an entry: 11 sums, padded to a power of 4 bytes
constexpr int64 LARGE = 8192;  // pixels of a box beyond which a whole block takes the Gaussian

struct Inputs {
  const float *means, *quats, *scales, *opacities, *sh, *phi;  // phi is null for sorted blending
};
struct Gradients {
  float *means, *quats, *scales, *opacities, *sh, *phi, *screen;  // the last two may be null
};
// Which Gaussians each tile must visit: entries [starts[tile], starts[tile + 1]).
struct Lists {
  const int64* starts;  // [tiles + 1]
  const int* ids;       // [entries] Gaussians
  const int64* slots;   // [entries] each one's place among its Gaussian's entries
};
struct Picture {
  float* sums;  // planes of h w floats: r, g, b, w, t (sorted: r, g, b, t), then z if depth is asked
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
  float4 falloff[COUNT];  // c of a Row without its dy^2, log2 opacity, weight
  float4 color[COUNT];    // r, g, b, z
  short4 box[COUNT];      // x0, x1, y0, y1
};

// `weighted` multiplies colour and depth by the weight of sort-free blending.
template <int COUNT>
MGS_FN void stage(Batch<COUNT>& batch, int k, const Splat& s, bool weighted) {
  Row line = row_of(s, 1.0f);
  float w = weighted ? s.weight : 1.0f;
  batch.place[k] = make_float4(s.x, s.y, line.a, line.b);
  batch.falloff[k] = make_float4(-0.5f * LOG2_E * s.C, s.log2_opacity, s.weight, 0.0f);
  batch.color[k] = make_float4(w * s.r, w * s.g, w * s.b, w * s.z);
  batch.box[k] = make_short4(s.x0, s.x1, s.y0, s.y1);
}

// Which of the 32 entries from `base` on touch the w x h pixels at (x, y): one bit each.
template <int COUNT>
MGS_FN unsigned touching(const Batch<COUNT>& batch, int base, int count, int x, int y, int w, int h) {
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
  Row line = {place.z, place.w * dy, falloff.x * dy * dy + falloff.y};
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

// ---------------------------------------------------------------- sort-free
template <bool DEPTH>
MGS_FN void sortfree_forward(const View& view, const Splat* splats, const Lists& lists,
                             const Picture& out) {
  __shared__ Batch<MANY> batch;
  Spot spot = spot_of(view);
  float x = spot.x + 0.5f, y = spot.y + 0.5f;
  Pixel p = {0, 0, 0, 0, 0, 1};
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += MANY) {
    int count = end - e < MANY ? (int)(end - e) : MANY;
    __syncthreads();  // until then somebody may still read the previous batch
    if ((int)threadIdx.x < count) stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], true);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      unsigned left = touching(batch, base, count, spot.patch_x, spot.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        float alpha = min_of(alpha_at(place, falloff, x - place.x, y - place.y), ALPHA_MAX);
        p.r += alpha * color.x, p.g += alpha * color.y, p.b += alpha * color.z;
        p.w += alpha * falloff.z;
        p.t -= p.t * alpha;
        if (DEPTH) p.z += alpha * color.w;
      }
    }
  }
  if (!spot.inside) return;
  int64 at = index_of(view, spot), plane = (int64)view.width * view.height;
  const float values[6] = {p.r, p.g, p.b, p.w, p.t, p.z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 6 : 5); k++) out.sums[k * plane + at] = values[k];
  sortfree_resolve(view, p, out.image + 3 * at, out.alpha + at, DEPTH ? out.depth + at : nullptr);
}

// dL/d of every pixel's sums, as (r, g, b, w) and (t, z): what a Gaussian asks of a pixel.
template <bool DEPTH>
MGS_FN void sortfree_pixels(const View& view, const float* sums, const PictureGradients& in,
                            float4* colors, float2* others) {
  int64 at = global_thread(), plane = (int64)view.width * view.height;
  if (at >= plane) return;
  const float* p = sums + at;
  Pixel pixel = {p[0],         p[plane],     p[2 * plane], DEPTH ? p[5 * plane] : 0.0f,
                 p[3 * plane], p[4 * plane]};
  Pixel d = sortfree_pixel_adjoint(view, pixel, in.image + 3 * at, in.alpha[at],
                                   DEPTH ? in.depth[at] : 0.0f);
  colors[at] = make_float4(d.r, d.g, d.b, d.w);
  others[at] = make_float2(d.t, d.z);
}

// Sums over every `step`-th pixel of a Gaussian's box, from the `first` on.
template <bool DEPTH>
MGS_FN Sums<float> gather_box(const View& view, const Splat& s, const float4* colors,
                              const float2* others, int first, int step) {
  Sums<float> sums = {};
  int width = s.x1 - s.x0, x = s.x0 + first % width, y = s.y0 + first / width;
  int step_x = step % width, step_y = step / width;
  while (y < s.y1) {
    float dx = x + 0.5f - s.x, dy = y + 0.5f - s.y;
    float raw = pair_alpha(dx, row_of(s, dy));
    if (raw > 0) {
      int64 at = (int64)y * view.width + x;
      float4 c = colors[at];
      float2 o = others[at];
      sortfree_pair_adjoint<DEPTH>(sums, s, raw, dx, dy, c.x, c.y, c.z, o.y, c.w, o.x);
    }
    x += step_x, y += step_y;
    if (x >= s.x1) x -= width, y++;
  }
  return sums;
}

// One warp per Gaussian, in the order given (by place in the picture, for the caches); those with
// a large box wait for the whole block.
template <bool DEPTH>
MGS_FN void sortfree_gather(const View& view, int n, const Splat* splats, const int64* order,
                            const float4* colors, const float2* others, float* totals) {
  constexpr int WARPS = MANY / WARP;
  __shared__ float parts[WARPS][SUMS];
  __shared__ int large[WARPS];  // the Gaussian, or -1
  int warp = warp_of_thread(), lane = lane_of_thread();
  int64 k = (int64)blockIdx.x * WARPS + warp;
  int64 i = k < n ? order[k] : -1;
  bool seen = i >= 0 && visible(splats[i]);
  if (lane == 0) large[warp] = -1;
  if (seen) {
    Splat s = splats[i];
    if ((int64)(s.x1 - s.x0) * (s.y1 - s.y0) > LARGE) {
      if (lane == 0) large[warp] = (int)i;
    } else {
      Total total = add_lanes(gather_box<DEPTH>(view, s, colors, others, lane, WARP));
      if (total.mine >= 0) totals[i * SUMS + total.mine] = total.value;
    }
  }
  __syncthreads();
  for (int turn = 0; turn < WARPS; turn++) {
    int64 id = large[turn];
    if (id < 0) continue;
    Splat s = splats[id];
    Total total = add_lanes(gather_box<DEPTH>(view, s, colors, others, threadIdx.x, MANY));
    if (total.mine >= 0) parts[warp][total.mine] = total.value;
    __syncthreads();
    if (threadIdx.x < SUMS) {
      float sum = 0;
      for (int w = 0; w < WARPS; w++) sum += parts[w][threadIdx.x];
      totals[id * SUMS + threadIdx.x] = sum;
    }
    __syncthreads();
  }
}

// ---------------------------------------------------------------- sorted
template <bool DEPTH>
MGS_FN void sorted_forward(const View& view, const Splat* splats, const Lists& lists,
                           const Picture& out) {
  __shared__ Batch<MANY> batch;
  Spot spot = spot_of(view);
  float x = spot.x + 0.5f, y = spot.y + 0.5f;
  float r = 0, g = 0, b = 0, z = 0, t = spot.inside ? 1.0f : 0.0f;
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += MANY) {
    int count = end - e < MANY ? (int)(end - e) : MANY;
    // also keeps the previous batch until everybody has read it
    if (!__syncthreads_or(t >= TRANSMITTANCE_MIN)) break;
    if ((int)threadIdx.x < count) stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], false);
    __syncthreads();
    for (int base = 0; base < count; base += WARP) {
      if (!__any_sync(ALL, t >= TRANSMITTANCE_MIN)) break;
      unsigned left = touching(batch, base, count, spot.patch_x, spot.patch_y, 8, 4);
      for (; left; left &= left - 1) {
        int k = base + __ffs(left) - 1;
        float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
        float alpha = min_of(alpha_at(place, falloff, x - place.x, y - place.y), ALPHA_MAX);
        float share = t >= TRANSMITTANCE_MIN ? alpha * t : 0.0f;
        r += share * color.x, g += share * color.y, b += share * color.z;
        if (DEPTH) z += share * color.w;
        t -= share;
      }
    }
  }
  if (!spot.inside) return;
  int64 at = index_of(view, spot), plane = (int64)view.width * view.height;
  const float values[5] = {r, g, b, t, z};
  UNROLL
  for (int k = 0; k < (DEPTH ? 5 : 4); k++) out.sums[k * plane + at] = values[k];
  UNROLL
  for (int k = 0; k < 3; k++) out.image[3 * at + k] = values[k] + t * view.background[k];
  out.alpha[at] = 1 - t;
  if (DEPTH) out.depth[at] = z;
}

// One pixel of the backward walk, which goes front to back like the forward one.
struct Walk {
  float x, y;              // pixel centre
  float r, g, b, z;        // dL/d of what the Gaussians' shares multiply
  float rest;              // what the Gaussians still to come, and the background, add to dL
  float t;                 // light left; 0 outside the picture
};

template <bool DEPTH>
MGS_FN Walk start_walk(const View& view, const Spot& spot, const float* sums,
                       const PictureGradients& in) {
  Walk w = {spot.x + 0.5f, spot.y + 0.5f, 0, 0, 0, 0, 0, 0};
  if (!spot.inside) return w;
  int64 at = index_of(view, spot), plane = (int64)view.width * view.height;
  const float *p = sums + at, *g = in.image + 3 * at;
  float t = p[3 * plane];
  w.t = 1, w.r = g[0], w.g = g[1], w.b = g[2];
  w.rest = -in.alpha[at] * t + w.r * (p[0] + t * view.background[0]) +
           w.g * (p[plane] + t * view.background[1]) + w.b * (p[2 * plane] + t * view.background[2]);
  if (DEPTH) w.z = in.depth[at], w.rest += w.z * p[4 * plane];
  return w;
}

template <bool DEPTH>
MGS_FN void walk_past(Walk& w, float raw, float dx, float dy, const float4& color,
                      Sums<float>& sums) {
  float alpha = min_of(raw, ALPHA_MAX), share = alpha * w.t;
  sums.r += share * w.r, sums.g += share * w.g, sums.b += share * w.b;
  float value = w.r * color.x + w.g * color.y + w.b * color.z;
  if (DEPTH) {
    sums.z += share * w.z;
    value += w.z * color.w;
  }
  w.rest -= share * value;
  w.t -= share;
  // dL/dalpha = T value - rest / (1 - alpha), times alpha
  float g_q = share * value - alpha * w.rest * reciprocal(1.0f - alpha);
  add_moments(sums, raw > ALPHA_MAX ? 0.0f : g_q, dx, dy);
}

// Each warp walks 8 x 8 pixels, two a thread, past the entries of the batch; adds its sums to its
// part of `parts` and tells in `reached` which entries it met. Returns whether light is left.
template <bool DEPTH>
MGS_FN bool walk_batch(const Batch<WALK_BATCH>& batch, int count, const Spot& spot, Walk* walks,
                       float (*parts)[SUMS], unsigned* reached) {
  for (int base = 0; base < count; base += WARP) {
    unsigned left = touching(batch, base, count, spot.patch_x, spot.patch_y, 8, 8), met = 0;
    if (!__any_sync(ALL, walks[0].t >= TRANSMITTANCE_MIN || walks[1].t >= TRANSMITTANCE_MIN)) left = 0;
    for (; left; left &= left - 1) {
      int k = base + __ffs(left) - 1;
      float4 place = batch.place[k], falloff = batch.falloff[k], color = batch.color[k];
      float raw[2], dx = walks[0].x - place.x;
      UNROLL
      for (int j = 0; j < 2; j++) {
        raw[j] = alpha_at(place, falloff, dx, walks[j].y - place.y);
        if (!(walks[j].t >= TRANSMITTANCE_MIN)) raw[j] = 0;
      }
      if (!__any_sync(ALL, raw[0] > 0 || raw[1] > 0)) continue;
      Sums<float> sums = {};
      UNROLL
      for (int j = 0; j < 2; j++)
        walk_past<DEPTH>(walks[j], raw[j], dx, walks[j].y - place.y, color, sums);
      Total total = add_lanes(sums);
      if (total.mine >= 0) parts[k][total.mine] = total.value;
      met |= left & (0 - left);
    }
    if (lane_of_thread() == 0) reached[base / WARP] = met;
  }
  return walks[0].t >= TRANSMITTANCE_MIN || walks[1].t >= TRANSMITTANCE_MIN;
}

// Writes each entry's sums over the tile to the entry's own slot, in the order of the warps, and
// marks the slot; entries that no light reached are left alone.
template <bool DEPTH>
MGS_FN void sorted_backward(const View& view, const Splat* splats, const Lists& lists,
                            const float* sums, const PictureGradients& in, float* slot_sums,
                            unsigned char* slot_reached) {
  constexpr int WARPS = WALKERS / WARP;
  __shared__ Batch<WALK_BATCH> batch;
  __shared__ float parts[WARPS][WALK_BATCH][SUMS];
  __shared__ unsigned reached[WARPS][WALK_BATCH / WARP];
  int warp = warp_of_thread();
  Spot upper = spot_of(view, warp % 2 * 8, warp / 2 * 8);
  Spot lower = spot_of(view, warp % 2 * 8, warp / 2 * 8 + 4);
  Walk walks[2] = {start_walk<DEPTH>(view, upper, sums, in), start_walk<DEPTH>(view, lower, sums, in)};
  bool open = true;
  int64 end = lists.starts[blockIdx.x + 1];
  for (int64 e = lists.starts[blockIdx.x]; e < end; e += WALK_BATCH) {
    int count = end - e < WALK_BATCH ? (int)(end - e) : WALK_BATCH;
    if (!__syncthreads_or(open)) break;
    if ((int)threadIdx.x < count) stage(batch, threadIdx.x, splats[lists.ids[e + threadIdx.x]], false);
    __syncthreads();
    open = walk_batch<DEPTH>(batch, count, upper, walks, parts[warp], reached[warp]);
    __syncthreads();
    for (int item = threadIdx.x; item < count * SUMS; item += WALKERS) {
      int k = item / SUMS, component = item % SUMS;
      float total = 0;
      bool any = false;
      for (int w = 0; w < WARPS; w++)
        if (reached[w][k / WARP] >> k % WARP & 1) total += parts[w][k][component], any = true;
      if (!any) continue;
      int64 slot = lists.slots[e + k];
      slot_sums[slot * SUMS + component] = total;
      if (component == 0) slot_reached[slot] = 1;
    }
  }
}

}  // namespace

// ---------------------------------------------------------------- the kernels
// One thread per Gaussian. `counts` (tiles touched) and `homes` (tile of the box's centre, the
// number of tiles where unseen) may be null.
KERNEL(MANY, 4) mgs_project(GIVEN View view, int n, GIVEN Inputs in, Splat* splats, float* radii,
                         int* counts, int* homes) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = {};
  bool seen = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i, in.opacities[i],
                      in.sh + 3 * view.sh_size * i, in.phi ? in.phi[i] : 0.0f, s);
  radii[i] = seen ? radius_of(s) : 0.0f;
  if (splats) splats[i] = s;
  int across = tiles_across(view), touched = 0;
  if (counts) {
    if (seen) for_tiles(s, across, [&](int) { touched++; });
    counts[i] = touched;
  }
  if (homes)
    homes[i] = seen ? (s.y0 + s.y1 - 1) / 2 / TILE * across + (s.x0 + s.x1 - 1) / 2 / TILE
                    : tile_count(view);
}

// One thread per Gaussian, in the order given or, where it is null, by index: writes its entries'
// tiles and itself to its slots, which end at ends[k] and begin where its predecessor's end. The
// compiler may round for_tiles differently here than where tiles were counted, and so disagree on
// a tile that the ellipse just grazes: no such entry leaves the slots, and a slot left over goes
// to the tile after the last, which nobody draws.
KERNEL(MANY, 4) mgs_fill(GIVEN View view, int n, const Splat* splats, const int64* order,
                      const int64* ends, int* tiles, int* ids) {
  int64 k = global_thread();
  if (k >= n) return;
  int64 i = order ? order[k] : k, slot = k ? ends[k - 1] : 0, end = ends[k];
  if (slot == end) return;
  Splat s = splats[i];
  for_tiles(s, tiles_across(view), [&](int tile) {
    if (slot == end) return;
    tiles[slot] = tile;
    ids[slot++] = (int)i;
  });
  for (; slot < end; slot++) tiles[slot] = tile_count(view), ids[slot] = (int)i;
}

// One warp per Gaussian, in the order of its slots: adds up the slots that were reached.
KERNEL(MANY, 4) mgs_sorted_gather(int n, const int64* order, const int64* ends, const float* slot_sums,
                               const unsigned char* slot_reached, float* totals) {
  int64 k = (int64)blockIdx.x * (MANY / WARP) + warp_of_thread();
  if (k >= n) return;
  int64 first = k ? ends[k - 1] : 0, end = ends[k];
  Sums<float> sums = {};
#pragma unroll 1  // few have more than 32 slots, all gain from registers left for more warps
  for (int64 slot = first + lane_of_thread(); slot < end; slot += WARP) {
    if (!slot_reached[slot]) continue;
    Sums<float> more = load_sums(slot_sums + slot * SUMS);
    sums.r += more.r, sums.g += more.g, sums.b += more.b, sums.z += more.z, sums.w += more.w;
    sums.q += more.q, sums.qx += more.qx, sums.qy += more.qy;
    sums.qxx += more.qxx, sums.qxy += more.qxy, sums.qyy += more.qyy;
  }
  Total total = add_lanes(sums);
  if (total.mine >= 0) totals[order[k] * SUMS + total.mine] = total.value;
}

// One thread per Gaussian: from its finished sums to the gradients of the inputs.
KERNEL(MANY, 3) mgs_finish(GIVEN View view, int n, GIVEN Inputs in, const Splat* splats,
                        const float* totals, GIVEN Gradients out, int sortfree) {
  int64 i = global_thread();
  if (i >= n) return;
  Splat s = splats[i];
  float g_phi = 0;
  if (!visible(s)) {
    for (int k = 0; k < 3; k++) out.means[3 * i + k] = out.scales[3 * i + k] = 0;
    for (int k = 0; k < 4; k++) out.quats[4 * i + k] = 0;
    for (int k = 0; k < 3 * view.sh_size; k++) out.sh[3 * view.sh_size * i + k] = 0;
    out.opacities[i] = 0;
    if (out.phi) out.phi[i] = 0;
    if (out.screen) out.screen[2 * i] = out.screen[2 * i + 1] = 0;
    return;
  }
  SplatGrad d = splat_grad(load_sums(totals + i * SUMS), s, sortfree);
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                  in.sh + 3 * view.sh_size * i, in.phi ? in.phi[i] : 0.0f, s, d, out.means + 3 * i,
                  out.quats + 4 * i, out.scales + 3 * i, out.opacities + i,
                  out.sh + 3 * view.sh_size * i, &g_phi);
  if (out.phi) out.phi[i] = g_phi;
  if (out.screen) out.screen[2 * i] = d.x, out.screen[2 * i + 1] = d.y;
}

// One block per tile, one thread per pixel.
KERNEL(MANY, 4) mgs_sortfree_forward(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                  GIVEN Picture out) {
  sortfree_forward<false>(view, splats, lists, out);
}
KERNEL(MANY, 4) mgs_sortfree_forward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                        GIVEN Picture out) {
  sortfree_forward<true>(view, splats, lists, out);
}
KERNEL(MANY, 4) mgs_sorted_forward(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                GIVEN Picture out) {
  sorted_forward<false>(view, splats, lists, out);
}
KERNEL(MANY, 4) mgs_sorted_forward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                      GIVEN Picture out) {
  sorted_forward<true>(view, splats, lists, out);
}

// One thread per pixel.
KERNEL(MANY, 4) mgs_sortfree_pixels(GIVEN View view, const float* sums, GIVEN PictureGradients in,
                                 float4* colors, float2* others) {
  sortfree_pixels<false>(view, sums, in, colors, others);
}
KERNEL(MANY, 4) mgs_sortfree_pixels_depth(GIVEN View view, const float* sums,
                                       GIVEN PictureGradients in, float4* colors, float2* others) {
  sortfree_pixels<true>(view, sums, in, colors, others);
}

// One warp per Gaussian.
KERNEL(MANY, 4) mgs_sortfree_gather(GIVEN View view, int n, const Splat* splats, const int64* order,
                                 const float4* colors, const float2* others, float* totals) {
  sortfree_gather<false>(view, n, splats, order, colors, others, totals);
}
KERNEL(MANY, 4) mgs_sortfree_gather_depth(GIVEN View view, int n, const Splat* splats,
                                       const int64* order, const float4* colors,
                                       const float2* others, float* totals) {
  sortfree_gather<true>(view, n, splats, order, colors, others, totals);
}

// One block per tile, two pixels per thread.
KERNEL(WALKERS, 8) mgs_sorted_backward(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                    const float* sums, GIVEN PictureGradients in, float* slot_sums,
                                    unsigned char* slot_reached) {
  sorted_backward<false>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
KERNEL(WALKERS, 8) mgs_sorted_backward_depth(GIVEN View view, const Splat* splats, GIVEN Lists lists,
                                          const float* sums, GIVEN PictureGradients in,
                                          float* slot_sums, unsigned char* slot_reached) {
  sorted_backward<true>(view, splats, lists, sums, in, slot_sums, slot_reached);
}
