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

bool visible(const Splat& s) { return s.x1 > s.x0; }

// `order` lists the Gaussians to bin; null: all, by index. Threads take contiguous shares and write
// behind one another, which keeps the order.
Bins bin(const View& view, int n, const Splat* splats, const std::vector<int>* order) {
  Tiles tiles(view);
  Bins bins;
  int threads = most_threads();
  int64 listed = order ? (int64)order->size() : n;
  std::vector<int64> cursor((size_t)threads * tiles.count, 0);
  bins.start.assign(tiles.count + 1, 0);
  auto for_entries = [&](auto use) {
    parallel_for(threads, 1, [&](int64 t, int64) {
      int64* next_entry = &cursor[(size_t)t * tiles.count];
      for (int64 i = listed * t / threads; i < listed * (t + 1) / threads; i++) {
        int id = order ? (*order)[i] : (int)i;
        if (!visible(splats[id])) continue;
        const Splat& s = splats[id];
        for_tiles(s, tiles.grids[s.level], [&](int tile) { use(next_entry[tile], id); });
      }
    });
  };
  for_entries([](int64& count, int) { count++; });
  int64 total = 0;
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
  int* ids = bins.ids.get();
  for_entries([ids](int64& entry, int id) { ids[entry++] = id; });
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
  const float *means, *quats, *scales, *opacities, *sh, *lobes;
};
struct Gradients {
  float *means, *quats, *scales, *opacities, *sh, *lobes, *screen;
};

void project_all(const View& view, int n, const Inputs& in, Splat* splats, float* radii) {
  parallel_parts(n, [&](int64 from, int64 to) {
    for (int64 i = from; i < to; i++) {
      bool shown = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                           in.opacities ? in.opacities[i] : 0.0f, in.sh + sh_floats(view) * i,
                           in.lobes + 2 * view.lobe_size * i, splats[i]);
      radii[i] = shown ? radius_of(splats[i]) : 0.0f;
    }
  });
}

// Writes the gradients of all inputs of a visible Gaussian, from that of its splat.
void write_gradients(const View& view, int64 i, const Inputs& in, const Splat& s,
                     const SplatGrad& d, const Gradients& out) {
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                  in.opacities ? in.opacities[i] : 0.0f, in.sh + sh_floats(view) * i,
                  in.lobes + 2 * view.lobe_size * i, s, d, out.means + 3 * i, out.quats + 4 * i,
                  out.scales + 3 * i, out.opacities ? out.opacities + i : nullptr, out.sh + sh_floats(view) * i,
                  out.lobes + 2 * view.lobe_size * i);
  if (out.screen) out.screen[2 * i] = d.x, out.screen[2 * i + 1] = d.y;
}

// The same for a Gaussian that is not visible: zeros.
void write_zero_gradients(const View& view, int64 i, const Gradients& out) {
  auto zero = [](float* p, int count) { std::memset(p, 0, sizeof(float) * count); };
  zero(out.means + 3 * i, 3), zero(out.quats + 4 * i, 4), zero(out.scales + 3 * i, 3);
  zero(out.sh + sh_floats(view) * i, sh_floats(view));
  if (out.opacities) out.opacities[i] = 0;
  if (out.lobes) zero(out.lobes + 2 * view.lobe_size * i, 2 * view.lobe_size);
  if (out.screen) out.screen[2 * i] = out.screen[2 * i + 1] = 0;
}

MGS_FN Sums<float> reduce(const Sums<vfloat>& v) {
  return {sum_of(v.r),  sum_of(v.g),  sum_of(v.b),   sum_of(v.z),   sum_of(v.w),  sum_of(v.q),
          sum_of(v.qx), sum_of(v.qy), sum_of(v.qxx), sum_of(v.qxy), sum_of(v.qyy), sum_of(v.c)};
}

void add(Sums<float>& total, const Sums<float>& part) {
  float* to = &total.r;
  const float* from = &part.r;
  for (size_t k = 0; k < sizeof(part) / sizeof(float); k++) to[k] += from[k];
}

}  // namespace
