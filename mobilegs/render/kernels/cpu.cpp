// The CPU's loops over core.h: OpenMP over tiles, pixels and Gaussians, a plain C interface for
// ctypes. No atomics and no shared sums, so results do not depend on the number of threads.
#include "core.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>
#if defined(_OPENMP)
#include <omp.h>
#else
static int omp_get_max_threads() { return 1; }
static int omp_get_thread_num() { return 0; }
#endif

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

// Flushes denormals while it lives: transmittances under dense overlap are full of them (2x).
struct FlushDenormals {
#if defined(__x86_64__)
  unsigned before = _mm_getcsr();
  FlushDenormals() { _mm_setcsr(before | 0x8040); }
  ~FlushDenormals() { _mm_setcsr(before); }
#endif
};

// Uninitialised memory that frees itself.
template <class T>
struct Buffer {
  std::unique_ptr<T[], void (*)(void*)> memory{nullptr, std::free};
  explicit Buffer(size_t count = 0) {
    size_t bytes = (count * sizeof(T) + 63) / 64 * 64;
    memory.reset(static_cast<T*>(std::aligned_alloc(64, std::max<size_t>(bytes, 64))));
  }
  T* get() const { return memory.get(); }
  T& operator[](size_t i) const { return memory[i]; }
};

struct Tiles {
  int across, count;
  explicit Tiles(const View& v)
      : across((v.width + TILE - 1) / TILE), count(across * ((v.height + TILE - 1) / TILE)) {}
};

// Which Gaussians each tile must visit, in the order in which they were given.
struct Bins {
  std::vector<int64> start;  // [tiles + 1]
  Buffer<int> ids;           // Gaussian of each entry
};

bool visible(const Splat& s) { return s.x1 > s.x0; }

// `order` lists the Gaussians to bin, front first, or is null for all, by index. Threads take
// contiguous shares and write behind one another, so entries keep the order.
Bins bin(const View& view, int n, const Splat* splats, const std::vector<int>* order) {
  Tiles tiles(view);
  Bins bins;
  int threads = omp_get_max_threads();
  int64 many = order ? (int64)order->size() : n;
  std::vector<int64> cursor((size_t)threads * tiles.count, 0);
  bins.start.assign(tiles.count + 1, 0);
#pragma omp parallel num_threads(threads)
  {
    int t = omp_get_thread_num();
    int64 from = many * t / threads, to = many * (t + 1) / threads;
    int64* mine = &cursor[(size_t)t * tiles.count];
    for (int64 i = from; i < to; i++) {
      int id = order ? (*order)[i] : (int)i;
      if (!visible(splats[id])) continue;
      for_tiles(splats[id], tiles.across, [&](int tile) { mine[tile]++; });
    }
#pragma omp barrier
#pragma omp single
    {
      int64 total = 0;
      for (int tile = 0; tile < tiles.count; tile++) {
        bins.start[tile] = total;
        for (int u = 0; u < threads; u++) {
          int64 found = cursor[(size_t)u * tiles.count + tile];
          cursor[(size_t)u * tiles.count + tile] = total;
          total += found;
        }
      }
      bins.start[tiles.count] = total;
      bins.ids = Buffer<int>(total);
    }
    for (int64 i = from; i < to; i++) {
      int id = order ? (*order)[i] : (int)i;
      if (!visible(splats[id])) continue;
      for_tiles(splats[id], tiles.across, [&](int tile) { bins.ids[mine[tile]++] = id; });
    }
  }
  return bins;
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

struct Inputs {
  const float *means, *quats, *scales, *opacities, *sh, *phi;
};
struct Gradients {
  float *means, *quats, *scales, *opacities, *sh, *phi, *screen;
};

void project_all(const View& view, int n, const Inputs& in, Splat* splats, float* radii) {
#pragma omp parallel for schedule(static)
  for (int64 i = 0; i < n; i++) {
    bool seen = project(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                        in.opacities[i], in.sh + 3 * view.sh_size * i, in.phi ? in.phi[i] : 0.0f,
                        splats[i]);
    radii[i] = seen ? radius_of(splats[i]) : 0.0f;
  }
}

void finish(const View& view, int64 i, const Inputs& in, const Splat& s, const SplatGrad& d,
            const Gradients& out) {
  float unused;
  project_adjoint(view, in.means + 3 * i, in.quats + 4 * i, in.scales + 3 * i,
                  in.sh + 3 * view.sh_size * i, in.phi ? in.phi[i] : 0.0f, s, d, out.means + 3 * i,
                  out.quats + 4 * i, out.scales + 3 * i, out.opacities + i,
                  out.sh + 3 * view.sh_size * i, out.phi ? out.phi + i : &unused);
  if (out.screen) out.screen[2 * i] = d.x, out.screen[2 * i + 1] = d.y;
}

void finish_unseen(const View& view, int64 i, const Gradients& out) {
  auto zero = [](float* p, int count) { std::memset(p, 0, sizeof(float) * count); };
  zero(out.means + 3 * i, 3), zero(out.quats + 4 * i, 4), zero(out.scales + 3 * i, 3);
  zero(out.opacities + i, 1), zero(out.sh + 3 * view.sh_size * i, 3 * view.sh_size);
  if (out.phi) out.phi[i] = 0;
  if (out.screen) out.screen[2 * i] = out.screen[2 * i + 1] = 0;
}

MGS_FN Sums<float> reduce(const Sums<vfloat>& v) {
  return {sum_of(v.r),  sum_of(v.g),  sum_of(v.b),   sum_of(v.z),   sum_of(v.w),  sum_of(v.q),
          sum_of(v.qx), sum_of(v.qy), sum_of(v.qxx), sum_of(v.qxy), sum_of(v.qyy)};
}

void add(Sums<float>& total, const Sums<float>& part) {
  float* to = &total.r;
  const float* from = &part.r;
  for (size_t k = 0; k < sizeof(part) / sizeof(float); k++) to[k] += from[k];
}

// ---------------------------------------------------------------- sort-free
// Channels of a pixel's sums: r, g, b, w, t, and z behind them when depth is asked for.
template <bool DEPTH>
constexpr int channels = DEPTH ? 6 : 5;

template <bool DEPTH>
void sortfree_tile(const Bins& bins, int tile, int left, int top, const Splat* splats, float* sums) {
  constexpr int C = channels<DEPTH>;
  for (int row = 0; row < TILE; row++)
    for (int c = 0; c < C; c++)
      std::fill_n(sums + (row * C + c) * TILE, TILE, c == 4 ? 1.0f : 0.0f);
  const vfloat steps = iota();
  for (int64 e = bins.start[tile]; e < bins.start[tile + 1]; e++) {
    const Splat& s = splats[bins.ids[e]];
    int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
    float x = left + 0.5f - s.x;
    float r = s.weight * s.r, g = s.weight * s.g, b = s.weight * s.b, w = s.weight;
    float z = s.weight * s.z;
    for (int row = from; row < to; row++) {
      Row line = row_of(s, top + row + 0.5f - s.y);
      float* p = sums + row * C * TILE;
      for (int l = 0; l < TILE; l += LANES, p += LANES) {
        vfloat alpha = pair_alpha(steps + (x + l), line);
        alpha = min_of(alpha, splat_value(alpha, ALPHA_MAX));
        store(p, load(p) + alpha * r);
        store(p + TILE, load(p + TILE) + alpha * g);
        store(p + 2 * TILE, load(p + 2 * TILE) + alpha * b);
        store(p + 3 * TILE, load(p + 3 * TILE) + alpha * w);
        vfloat t = load(p + 4 * TILE);
        store(p + 4 * TILE, t - t * alpha);
        if (DEPTH) store(p + 5 * TILE, load(p + 5 * TILE) + alpha * z);
      }
    }
  }
}

template <bool DEPTH>
void sortfree_forward(const View& view, int n, const Splat* splats, float* sums, float* image,
                      float* alpha, float* depth) {
  constexpr int C = channels<DEPTH>;
  Bins bins = bin(view, n, splats, nullptr);
  Tiles tiles(view);
#pragma omp parallel for schedule(dynamic, 4)
  for (int tile = 0; tile < tiles.count; tile++) {
    FlushDenormals flush;
    alignas(64) float mine[TILE * C * TILE];
    int left = tile % tiles.across * TILE, top = tile / tiles.across * TILE;
    sortfree_tile<DEPTH>(bins, tile, left, top, splats, mine);
    int wide = std::min(TILE, view.width - left);
    for (int row = 0; row < TILE && top + row < view.height; row++) {
      const float* p = mine + row * C * TILE;
      int64 at = (int64)(top + row) * view.width + left;
      for (int c = 0; c < C; c++)
        std::memcpy(sums + ((int64)(top + row) * C + c) * view.width + left, p + c * TILE,
                    sizeof(float) * wide);
      for (int l = 0; l < wide; l++) {
        const float* q = p + l;
        Pixel pixel = {q[0], q[TILE], q[2 * TILE], DEPTH ? q[(C - 1) * TILE] : 0.0f, q[3 * TILE],
                       q[4 * TILE]};
        sortfree_resolve(view, pixel, image + 3 * (at + l), alpha + at + l,
                         DEPTH ? depth + at + l : nullptr);
      }
    }
  }
}

// dL/d of every pixel's sums, channel planes within each row, padded so that a vector may start
// at any pixel.
template <bool DEPTH>
Buffer<float> pixel_gradients(const View& view, const float* sums, const float* g_image,
                              const float* g_alpha, const float* g_depth, int stride) {
  constexpr int C = channels<DEPTH>;
  Buffer<float> grads((size_t)view.height * C * stride);
#pragma omp parallel for schedule(static)
  for (int y = 0; y < view.height; y++) {
    FlushDenormals flush;
    const float* p = sums + (int64)y * C * view.width;
    float* out = grads.get() + (int64)y * C * stride;
    for (int x = 0; x < view.width; x++) {
      int64 at = (int64)y * view.width + x, w = view.width;
      Pixel pixel = {p[x], p[w + x], p[2 * w + x], DEPTH ? p[5 * w + x] : 0.0f, p[3 * w + x],
                     p[4 * w + x]};
      Pixel d = sortfree_pixel_adjoint(view, pixel, g_image + 3 * at, g_alpha[at],
                                       DEPTH ? g_depth[at] : 0.0f);
      out[x] = d.r, out[stride + x] = d.g, out[2 * stride + x] = d.b, out[3 * stride + x] = d.w;
      out[4 * stride + x] = d.t;
      if (DEPTH) out[5 * stride + x] = d.z;
    }
    for (int c = 0; c < C; c++)
      std::fill_n(out + c * stride + view.width, stride - view.width, 0.0f);
  }
  return grads;
}

// Indices of the Gaussians by the tile of their box's centre, unseen ones last: neighbours in
// the picture then read the same pixels from the cache.
std::vector<int> screen_order(const View& view, int n, const Splat* splats) {
  Tiles tiles(view);
  std::vector<int> place(tiles.count + 2, 0), order(n);
  auto tile_of = [&](const Splat& s) {
    return visible(s) ? (s.y0 + s.y1 - 1) / 2 / TILE * tiles.across + (s.x0 + s.x1 - 1) / 2 / TILE
                      : tiles.count;
  };
  for (int i = 0; i < n; i++) place[tile_of(splats[i]) + 1]++;
  for (int t = 0; t <= tiles.count; t++) place[t + 1] += place[t];
  for (int i = 0; i < n; i++) order[place[tile_of(splats[i])]++] = i;
  return order;
}

template <bool DEPTH>
MGS_FN Sums<float> sortfree_gather(const Splat& s, const float* grads, int stride) {
  constexpr int C = channels<DEPTH>;
  const vfloat steps = iota();
  Sums<vfloat> sums = {};
  float inverse_a = 1 / s.A;
  for (int y = s.y0; y < s.y1; y++) {
    float dy = y + 0.5f - s.y;
    float inside = s.reach * s.A - s.det * dy * dy;  // of the ellipse's quadratic in dx
    if (inside < 0) continue;
    float root = sqrtf(inside) * inverse_a, middle = s.x - s.B * inverse_a * dy;
    int from = std::max((int)s.x0, (int)(middle - root - 0.51f));
    int to = std::min((int)s.x1, (int)(middle + root - 0.49f) + 2);
    Row line = row_of(s, dy);
    const float* g = grads + (int64)y * C * stride;
    for (int x = from; x < to; x += LANES) {
      vfloat dx = steps + (x + 0.5f - s.x);
      const float* p = g + x;
      vfloat g_z = DEPTH ? load(p + 5 * stride) : vfloat{};
      sortfree_pair_adjoint<DEPTH>(sums, s, pair_alpha(dx, line), dx, dy, load(p), load(p + stride),
                                   load(p + 2 * stride), g_z, load(p + 3 * stride),
                                   load(p + 4 * stride));
    }
  }
  return reduce(sums);
}

template <bool DEPTH>
void sortfree_backward(const View& view, int n, const Inputs& in, const Splat* splats,
                       const float* sums, const float* g_image, const float* g_alpha,
                       const float* g_depth, const Gradients& out) {
  int stride = view.width + LANES;
  Buffer<float> grads = pixel_gradients<DEPTH>(view, sums, g_image, g_alpha, g_depth, stride);
  std::vector<int> order = screen_order(view, n, splats);
  Buffer<Sums<float>> totals(n);
#pragma omp parallel
  {
    FlushDenormals flush;
#pragma omp for schedule(dynamic, 256)
    for (int k = 0; k < n; k++) {
      const Splat& s = splats[order[k]];
      if (k + 4 < n) __builtin_prefetch(&splats[order[k + 4]]);
      if (visible(s)) totals[order[k]] = sortfree_gather<DEPTH>(s, grads.get(), stride);
    }
    // by index again: the inputs and their gradients are then read and written in one sweep
#pragma omp for schedule(static)
    for (int i = 0; i < n; i++) {
      if (visible(splats[i]))
        finish(view, i, in, splats[i], splat_grad(totals[i], splats[i], true), out);
      else
        finish_unseen(view, i, out);
    }
  }
}

// ---------------------------------------------------------------- sorted
// Channels of a pixel: r, g, b, t and, with depth, z.
template <bool DEPTH>
constexpr int sorted_channels = DEPTH ? 5 : 4;

// One entry of a tile's list, forward: returns the rows on which light is left.
template <bool DEPTH>
MGS_FN int sorted_entry(const Splat& s, int left, int top, int alive, float* sums) {
  constexpr int C = sorted_channels<DEPTH>;
  const vfloat steps = iota();
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    Row line = row_of(s, top + row + 0.5f - s.y);
    float* p = sums + row * C * TILE;
    bool open = false;
    for (int l = 0; l < TILE; l += LANES, p += LANES) {
      vfloat alpha = pair_alpha(steps + (x + l), line), t = load(p + 3 * TILE);
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
#pragma omp parallel for schedule(dynamic, 4)
  for (int tile = 0; tile < tiles.count; tile++) {
    FlushDenormals flush;
    float* mine = sums + (int64)tile * TILE * C * TILE;
    int left = tile % tiles.across * TILE, top = tile / tiles.across * TILE;
    for (int row = 0; row < TILE; row++)
      for (int c = 0; c < C; c++)
        std::fill_n(mine + (row * C + c) * TILE, TILE, c == 3 ? 1.0f : 0.0f);
    int alive = (1 << TILE) - 1;
    for (int64 e = bins.start[tile]; e < bins.start[tile + 1] && alive; e++)
      alive = sorted_entry<DEPTH>(splats[bins.ids[e]], left, top, alive, mine);
    for (int row = 0; row < TILE && top + row < view.height; row++) {
      const float* p = mine + row * C * TILE;
      int64 at = (int64)(top + row) * view.width + left;
      for (int l = 0; l < TILE && left + l < view.width; l++) {
        float t = p[3 * TILE + l];
        for (int k = 0; k < 3; k++)
          image[3 * (at + l) + k] = p[k * TILE + l] + t * view.background[k];
        alpha[at + l] = 1 - t;
        if (DEPTH) depth[at + l] = p[(C - 1) * TILE + l];
      }
    }
  }
}

// Per-pixel state of the backward walk: dL/d image (3), what the Gaussians still to come and the
// background add to dL (1), light left (1), dL/d depth (1).
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

// One entry, backward: adds to `sums` and returns the rows on which light is left.
template <bool DEPTH>
MGS_FN int sorted_entry_adjoint(const Splat& s, int left, int top, int alive, float* walk,
                                Sums<vfloat>& sums) {
  const vfloat steps = iota();
  int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
  float x = left + 0.5f - s.x;
  for (int row = from; row < to; row++) {
    if (!(alive >> row & 1)) continue;
    float dy = top + row + 0.5f - s.y;
    Row line = row_of(s, dy);
    float* p = walk + row * WALK * TILE;
    bool open = false;
    for (int l = 0; l < TILE; l += LANES, p += LANES) {
      vfloat dx = steps + (x + l), raw = pair_alpha(dx, line), t = load(p + 4 * TILE);
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
  // Each (Gaussian, row of tiles) has a slot of its own. One thread walks a row of tiles from left
  // to right, so a slot's sums are added in one order; a Gaussian then adds its slots downwards.
  std::vector<int> first(n + 1, 0);
  for (int i = 0; i < n; i++) {
    const Splat& s = splats[i];
    first[i + 1] = first[i] + (visible(s) ? (s.y1 - 1) / TILE - s.y0 / TILE + 1 : 0);
  }
  Buffer<Sums<float>> partial(first[n]);
  std::vector<unsigned char> reached(first[n], 0);
#pragma omp parallel
  {
    FlushDenormals flush;
#pragma omp for schedule(dynamic, 1)
    for (int row = 0; row < rows; row++) {
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
          Sums<vfloat> mine = {};
          alive = sorted_entry_adjoint<DEPTH>(s, left, top, alive, walk, mine);
          Sums<float> found = reduce(mine);
          int slot = first[id] + row - s.y0 / TILE;
          if (reached[slot]) add(partial[slot], found);
          else partial[slot] = found, reached[slot] = 1;
        }
      }
    }
#pragma omp for schedule(dynamic, 1024)
    for (int i = 0; i < n; i++) {
      if (!visible(splats[i])) {
        finish_unseen(view, i, out);
        continue;
      }
      Sums<float> total = {};
      for (int slot = first[i]; slot < first[i + 1]; slot++)
        if (reached[slot]) add(total, partial[slot]);
      finish(view, i, in, splats[i], splat_grad(total, splats[i], false), out);
    }
  }
}

}  // namespace

// ---------------------------------------------------------------- the C interface
EXPORT int mgs_lanes() { return LANES; }
EXPORT int mgs_view_bytes() { return sizeof(View); }
EXPORT int mgs_splat_bytes() { return sizeof(Splat); }

EXPORT void mgs_project(const View* view, int n, const Inputs* in, Splat* splats, float* radii) {
  project_all(*view, n, *in, splats, radii);
}

EXPORT void mgs_sortfree_forward(const View* view, int n, const Inputs* in, Splat* splats,
                                 float* radii, float* sums, float* image, float* alpha,
                                 float* depth) {
  project_all(*view, n, *in, splats, radii);
  (depth ? sortfree_forward<true> : sortfree_forward<false>)(*view, n, splats, sums, image, alpha,
                                                             depth);
}

EXPORT void mgs_sortfree_backward(const View* view, int n, const Inputs* in, const Splat* splats,
                                  const float* sums, const float* g_image, const float* g_alpha,
                                  const float* g_depth, const Gradients* out) {
  (g_depth ? sortfree_backward<true> : sortfree_backward<false>)(*view, n, *in, splats, sums,
                                                                 g_image, g_alpha, g_depth, *out);
}

// Returns the tile lists, which the backward pass needs and mgs_bins_free frees.
EXPORT void* mgs_sorted_forward(const View* view, int n, const Inputs* in, Splat* splats,
                                float* radii, float* sums, float* image, float* alpha,
                                float* depth) {
  project_all(*view, n, *in, splats, radii);
  std::vector<int> order = depth_order(n, splats);
  Bins* bins = new Bins(bin(*view, n, splats, &order));
  (depth ? sorted_forward<true> : sorted_forward<false>)(*view, *bins, splats, sums, image, alpha,
                                                         depth);
  return bins;
}

EXPORT void mgs_sorted_backward(const View* view, int n, const Inputs* in, const Splat* splats,
                                const void* bins, const float* sums, const float* g_image,
                                const float* g_alpha, const float* g_depth, const Gradients* out) {
  (g_depth ? sorted_backward<true> : sorted_backward<false>)(
      *view, n, *in, splats, *(const Bins*)bins, sums, g_image, g_alpha, g_depth, *out);
}

EXPORT void mgs_bins_free(void* bins) { delete (Bins*)bins; }
