// Shared by the CPU kernels: memory, tile lists, depth order, projection, input gradients.
#pragma once
#include "pairs.h"
#include "parallel.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <vector>

namespace {

// Flushes denormals to 0 during its lifetime: dense overlap makes many, at half the speed.
struct [[maybe_unused]] FlushDenormals {
#if defined(__x86_64__)
  unsigned before = _mm_getcsr();
  FlushDenormals() { _mm_setcsr(before | 0x8040); }
  ~FlushDenormals() { _mm_setcsr(before); }
#endif
};

// Uninitialised memory that frees itself.
template <class T>
struct Buffer {
  static constexpr std::align_val_t LINE{64};
  std::unique_ptr<T[], void (*)(void*)> memory{nullptr,
                                               [](void* p) { ::operator delete(p, LINE); }};
  explicit Buffer(size_t count = 0) {
    size_t bytes = (count * sizeof(T) + 63) / 64 * 64;
    memory.reset(static_cast<T*>(::operator new(std::max<size_t>(bytes, 64), LINE)));
  }
  T* get() const { return memory.get(); }
  T& operator[](size_t i) const { return memory[i]; }
};

// The tiles of all levels.
struct Tiles {
  int levels, across, count;  // across: of level 0
  Grid grids[LEVELS];
  explicit Tiles(const View& v) : levels(level_count(v)) {
    for (int l = 0; l < levels; l++) grids[l] = grid_of(v, l);
    across = grids[0].across;
    count = grids[levels - 1].first_tile + grids[levels - 1].tiles;
  }
  const Grid& grid_of_tile(int tile) const {
    int level = levels - 1;
    while (tile < grids[level].first_tile) level--;
    return grids[level];
  }
};

// The Gaussians that each tile visits, in the given order.
struct Bins {
  std::vector<int64> start;  // [tiles + 1]
  Buffer<int> ids;           // Gaussian of each entry
};

// The splat of an entry below `end`. That of a later one is fetched from memory: lists jump about.
MGS_FN const Splat& splat_of(const Bins& bins, int64 entry, int64 end, const Splat* splats) {
  __builtin_prefetch(&splats[bins.ids[std::min(entry + 6, end - 1)]]);
  return splats[bins.ids[entry]];
}

bool visible(const Splat& s) { return s.x1 > s.x0; }

// Neighbouring tiles in a row that one Gaussian touches.
struct TileRun {
  int id, tile, count;
};

// `order` lists the Gaussians to bin; null: all, by index. Threads take contiguous shares and write
// behind one another, which keeps the order.
Bins bin(const View& view, int n, const Splat* splats, const std::vector<int>* order) {
  Tiles tiles(view);
  Bins bins;
  int threads = most_threads();
  int64 listed = order ? (int64)order->size() : n;
  std::vector<int64> cursor((size_t)threads * tiles.count, 0);
  std::vector<std::vector<TileRun>> runs(threads);
  parallel_for(threads, 1, [&](int64 t, int64) {
    int64* counts = &cursor[(size_t)t * tiles.count];
    std::vector<TileRun> found;
    int64 from = listed * t / threads, to = listed * (t + 1) / threads;
    found.reserve(2 * (to - from));
    for (int64 i = from; i < to; i++) {
      int id = order ? (*order)[i] : (int)i;
      const Splat& s = splats[id];
      if (!visible(s)) continue;
      for_tile_rows(s, tiles.grids[s.level], [&](int tile, int count) {
        found.push_back({id, tile, count});
        for (int k = 0; k < count; k++) counts[tile + k]++;
      });
    }
    runs[t] = std::move(found);
  });
  int64 total = 0;
  bins.start.resize(tiles.count + 1);
  for (int tile = 0; tile < tiles.count; tile++) {
    bins.start[tile] = total;
    for (int t = 0; t < threads; t++) {
      int64 found = cursor[(size_t)t * tiles.count + tile];
      cursor[(size_t)t * tiles.count + tile] = total;
      total += found;
    }
  }
  bins.start[tiles.count] = total;
  bins.ids = Buffer<int>(total);
  parallel_for(threads, 1, [&](int64 t, int64) {
    int64* next_entry = &cursor[(size_t)t * tiles.count];
    for (const TileRun& run : runs[t])
      for (int k = 0; k < run.count; k++) bins.ids[next_entry[run.tile + k]++] = run.id;
  });
  return bins;
}

// Start of each Gaussian's slots, one per row of tiles that it touches; the last element is their
// number. One thread takes a row of tiles, so no two threads add to one slot.
std::vector<int> row_slots(int n, const Splat* splats) {
  std::vector<int> first(n + 1, 0);
  for (int i = 0; i < n; i++) {
    const Splat& s = splats[i];
    first[i + 1] = first[i] + (visible(s) ? (s.y1 - 1) / TILE - s.y0 / TILE + 1 : 0);
  }
  return first;
}

// Visible Gaussians by depth, equal depths by index: a radix sort over the bits of positive floats.
std::vector<int> depth_order(int n, const Splat* splats) {
  std::vector<int> order, next;
  std::vector<uint32_t> keys, next_keys;
  order.reserve(n), keys.reserve(n);
  for (int i = 0; i < n; i++) {
    if (!visible(splats[i])) continue;
    uint32_t bits;
    std::memcpy(&bits, &splats[i].z, 4);
    order.push_back(i), keys.push_back(bits);
  }
  next.resize(order.size()), next_keys.resize(order.size());
  for (int shift = 0; shift < 32; shift += 11) {
    int64 place[2049] = {0};
    for (uint32_t key : keys) place[((key >> shift) & 2047) + 1]++;
    for (int b = 0; b < 2048; b++) place[b + 1] += place[b];
    for (size_t i = 0; i < order.size(); i++) {
      int64 to = place[(keys[i] >> shift) & 2047]++;
      next[to] = order[i], next_keys[to] = keys[i];
    }
    order.swap(next), keys.swap(next_keys);
  }
  return order;
}

// Sorted blending has opacities, sort-free blending lobes; the other is null.
struct Inputs {
  const float *means, *quats, *scales, *opacities, *sh, *lobes, *more;
};
struct Gradients {
  float *means, *quats, *scales, *opacities, *sh, *lobes, *more, *screen;  // `more` is added to
};

// Lanes from `many` on become zeros. The rows lie `stride` floats apart, or side by side.
void turn(const float* rows, int width, int many, float* numbers, int64 stride = 0) {
  if (stride == 0) stride = width;
  if (many < LANES) std::fill_n(numbers, width * LANES, 0.0f);
  rows_to_lanes([=](int i) { return rows + i * stride; }, width, many, numbers, LANES);
}
// Rows that are not kept become zeros.
void turn_back(const float* numbers, int width, const bool* kept, int many, float* rows) {
  lanes_to_rows(numbers, LANES, width, many, [=](int i) { return rows + i * width; });
  for (int i = 0; i < many; i++)
    if (!kept[i]) std::fill_n(rows + i * width, width, 0.0f);
}

// The same, added to the rows that are kept.
void add_back(const float* numbers, int width, const bool* kept, int many, float* rows,
              int64 stride) {
  float found[LANES][45];
  lanes_to_rows(numbers, LANES, width, many, [&](int i) { return found[i]; });
  for (int i = 0; i < many; i++)
    if (kept[i])
      for (int k = 0; k < width; k++) rows[i * stride + k] += found[i][k];
}

// The numbers of LANES Gaussians, inputs or their gradients. Harmonics of `more` follow those of `sh`.
struct alignas(64) LaneRows {
  float means[3 * LANES], quats[4 * LANES], scales[3 * LANES], opacities[LANES];
  float sh[48 * LANES], lobes[32 * LANES];
};

void read_rows(const View& view, const Inputs& in, int64 from, int many, LaneRows& rows) {
  int colors = sh_floats(view), lobes = 2 * view.lobe_size;
  turn(in.means + 3 * from, 3, many, rows.means);
  turn(in.quats + 4 * from, 4, many, rows.quats);
  turn(in.scales + 3 * from, 3, many, rows.scales);
  turn(in.sh + colors * from, colors, many, rows.sh);
  if (in.more)
    turn(in.more + view.more_width * from, more_floats(view), many, rows.sh + 3 * LANES,
         view.more_width);
  if (in.opacities) turn(in.opacities + from, 1, many, rows.opacities);
  if (in.lobes) turn(in.lobes + lobes * from, lobes, many, rows.lobes);
}

void project_all(const View& view, int n, const Inputs& in, Splat* splats, float* radii) {
  parallel_parts((n + LANES - 1) / LANES, [&](int64 first, int64 end) {
    LaneRows rows;
    for (int64 from = first * LANES; from < std::min<int64>(n, end * LANES); from += LANES) {
      int many = (int)std::min<int64>(LANES, n - from);
      read_rows(view, in, from, many, rows);
      Projected<vfloat> p;
      vint shown = project(view, rows.means, rows.quats, rows.scales, rows.opacities, rows.sh,
                           rows.sh, rows.lobes, p);
      vfloat radius = select(shown, radius_of(p), vfloat{});
      // as the last fields of a Splat
      auto integers = [](vfloat v) { return __builtin_convertvector(v, vint); };
      vint last[] = {integers(p.x0) | integers(p.x1) << 16, integers(p.y0) | integers(p.y1) << 16,
                     integers(p.level)};
      std::memcpy(&p.x0, last, sizeof(last));
      lanes_to_rows((const float*)&p, LANES, sizeof(Splat) / sizeof(float), many,
                    [=](int i) { return (float*)(splats + from + i); });
      std::memcpy(radii + from, &radius, sizeof(float) * many);
    }
  });
}

// Writes the gradients of all inputs, from the sums over pixels of visible Gaussians: total_of(i).
// Those of the others are zeros.
template <class Total>
void write_gradients(const View& view, int n, const Inputs& in, const Splat* splats, bool sortfree,
                     Total total_of, const Gradients& out) {
  parallel_parts((n + LANES - 1) / LANES, [&](int64 first, int64 end) {
    FlushDenormals flush;
    LaneRows rows, found = {};
    int colors = sh_floats(view), lobes = 2 * view.lobe_size;
    for (int64 from = first * LANES; from < std::min<int64>(n, end * LANES); from += LANES) {
      int many = (int)std::min<int64>(LANES, n - from);
      Projected<vfloat> p = {};
      Sums<vfloat> sums = {};
      Sums<float> totals[LANES];
      bool kept[LANES] = {}, any = false;
      for (int i = 0; i < many; i++) {
        kept[i] = visible(splats[from + i]), any |= kept[i];
        totals[i] = kept[i] ? total_of(from + i) : Sums<float>{};
      }
      SplatGrad<vfloat> d = {};
      if (any) {
        read_rows(view, in, from, many, rows);
        rows_to_lanes([&](int i) { return &totals[i].r; }, sizeof(totals[0]) / sizeof(float), many,
                      (float*)&sums, LANES);
        // the box is not read
        vfloat words[sizeof(Splat) / sizeof(float)] = {};
        rows_to_lanes([=](int i) { return (const float*)(splats + from + i); },
                      sizeof(Splat) / sizeof(float), many, (float*)words, LANES);
        std::memcpy(&p, words, sizeof(words));
        p.level = __builtin_convertvector((vint)words[15], vfloat);
        d = splat_grad(sums, p, sortfree);
        project_adjoint(view, rows.means, rows.quats, rows.scales, rows.opacities, rows.sh,
                        rows.lobes, p, d, found.means, found.quats, found.scales,
                        out.opacities ? found.opacities : nullptr, found.sh, found.sh, found.lobes);
      }
      turn_back(found.means, 3, kept, many, out.means + 3 * from);
      turn_back(found.quats, 4, kept, many, out.quats + 4 * from);
      turn_back(found.scales, 3, kept, many, out.scales + 3 * from);
      turn_back(found.sh, colors, kept, many, out.sh + colors * from);
      if (out.more && any)
        add_back(found.sh + 3 * LANES, more_floats(view), kept, many,
                 out.more + view.more_width * from, view.more_width);
      if (out.opacities) turn_back(found.opacities, 1, kept, many, out.opacities + from);
      if (out.lobes) turn_back(found.lobes, lobes, kept, many, out.lobes + lobes * from);
      if (out.screen) turn_back((const float*)&d.x, 2, kept, many, out.screen + 2 * from);
    }
  });
}

// The pixels of a tile lie in patches, a vector each: PATCH wide, PATCH_ROWS high. Most Gaussians
// touch few of them. The numbers of a patch lie together, C vectors; `patch_row` is the first of the
// four numbers of channel 0 in a patch's row, the next channel's are LANES further.
constexpr int PATCH = 4, PATCH_ROWS = LANES / PATCH, PATCHES_ACROSS = TILE / PATCH;
constexpr int PATCHES = TILE * TILE / LANES;
using Patches = uint64_t;  // a bit for each
constexpr Patches ALL_PATCHES = PATCHES == 64 ? ~Patches(0) : (Patches(1) << PATCHES % 64) - 1;

template <int C, class Number>
MGS_FN Number* patch_row(Number* numbers, int row, int patch_x) {
  return numbers + (row / PATCH_ROWS * PATCHES_ACROSS + patch_x) * C * LANES +
         row % PATCH_ROWS * PATCH;
}

// The pixels of a patch, from its first one.
MGS_FN vfloat patch_x() {
  vfloat v;
  for (int i = 0; i < LANES; i++) v[i] = (float)(i % PATCH);
  return v;
}
MGS_FN vfloat patch_y() {
  vfloat v;
  for (int i = 0; i < LANES; i++) v[i] = (float)(i / PATCH);
  return v;
}

// The patches of the tile at (left, top) that a splat's box touches: [x0, x1) x [y0, y1).
struct PatchBox {
  int x0, x1, y0, y1;
  PatchBox(const Splat& s, int left, int top)
      : x0(std::max(s.x0 - left, 0) / PATCH),
        x1((std::min(s.x1 - left, TILE) + PATCH - 1) / PATCH),
        y0(std::max(s.y0 - top, 0) / PATCH_ROWS),
        y1((std::min(s.y1 - top, TILE) + PATCH_ROWS - 1) / PATCH_ROWS) {}
};

// Sets a tile's channels, one vector of each after the other in every patch.
template <int C>
MGS_FN void clear_patches(float* numbers, int ones) {
  for (int k = 0; k < PATCHES * C; k++)
    store(numbers + k * LANES, splat_value(vfloat{}, k % C == ones ? 1.0f : 0.0f));
}

// Adds the moments of columns of pixels, but for qyy: `q` and `qy` are sums along them.
MGS_FN void add_columns(Sums<vfloat>& sums, vfloat q, vfloat qy, vfloat dx) {
  sums.q += q;
  sums.qx += q * dx;
  sums.qy += qy;
  sums.qxx += q * dx * dx;
  sums.qxy += qy * dx;
}

MGS_FN Sums<float> reduce(const Sums<vfloat>& v) {
  static_assert(sizeof(Sums<float>) == 12 * sizeof(float));
  alignas(64) union {
    float numbers[16];
    Sums<float> sums;
  } u;
  store_sums(u.numbers, &v.r);
  return u.sums;
}

void add(Sums<float>& total, const Sums<float>& part) {
  float* to = &total.r;
  const float* from = &part.r;
  for (size_t k = 0; k < sizeof(part) / sizeof(float); k++) to[k] += from[k];
}

}  // namespace
