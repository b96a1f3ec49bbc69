// Order-independent blending on the CPU (render/sortfree.py, paper Eq. 2): sums of c a w, a w and
// the product T of 1 - a per pixel. w is weight_of in core.h, the colour sortfree_resolve in
// pairs.h. In the forward pass a thread owns a tile, in the backward pass a Gaussian.
#pragma once
#include "cpu_common.h"

namespace {

// Channels of a pixel's sums: r, g, b, w, T, then z for the depth image, then for TWO_PASS the
// depth up to which Gaussians count.
template <bool DEPTH, bool SURFACES>
constexpr int channels = 5 + DEPTH + SURFACES;

// First pass of TWO_PASS over a tile: finds the nearest surface of every pixel, where T becomes 0.
template <int C>
void find_surfaces(const Bins& bins, int tile, int left, int top, const Splat* splats,
                   float* sums) {
  for (int row = 0; row < TILE; row++)
    std::fill_n(sums + (row * C + C - 1) * TILE, TILE, NO_SURFACE);
  const vfloat lanes = iota(), zero = {};
  for (int64 e = bins.start[tile]; e < bins.start[tile + 1]; e++) {
    const Splat& s = splats[bins.ids[e]];
    if (s.opacity < SURFACE_ALPHA) continue;
    int from = std::max(s.y0 - top, 0), to = std::min(s.y1 - top, TILE);
    vfloat own_limit = splat_value(zero, limit_of(s));
    for (int row = from; row < to; row++) {
      Row line = row_of(s, top + row + 0.5f - s.y);
      float *t = sums + (row * C + 4) * TILE, *limit = sums + (row * C + C - 1) * TILE;
      for (int l = 0; l < TILE; l += LANES) {
        vint none = pair_alpha(lanes + (left + l + 0.5f - s.x), line) < SURFACE_ALPHA;
        store(t + l, select(none, load(t + l), zero));
        store(limit + l, select(none, load(limit + l), min_of(load(limit + l), own_limit)));
      }
    }
  }
}

template <bool DEPTH, bool SURFACES>
void sortfree_tile(const Bins& bins, int tile, int left, int top, const Splat* splats, float* sums) {
  constexpr int C = channels<DEPTH, SURFACES>;
  for (int row = 0; row < TILE; row++)
    for (int c = 0; c < C; c++)
      std::fill_n(sums + (row * C + c) * TILE, TILE, c == 4 ? 1.0f : 0.0f);
  if (SURFACES) find_surfaces<C>(bins, tile, left, top, splats, sums);
  const vfloat lanes = iota();
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
        vfloat alpha = pair_alpha(lanes + (x + l), line);
        if (SURFACES) alpha = select(load(p + (C - 1) * TILE) < s.z, vfloat{}, alpha);
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

template <bool DEPTH, bool SURFACES>
void sortfree_forward(const View& view, int n, const Splat* splats, float* sums, float* image,
                      float* alpha, float* depth) {
  constexpr int C = channels<DEPTH, SURFACES>;
  Bins bins = bin(view, n, splats, nullptr);
  Tiles tiles(view);
#pragma omp parallel for schedule(dynamic, 4)
  for (int tile = 0; tile < tiles.count; tile++) {
    FlushDenormals flush;
    alignas(64) float tile_sums[TILE * C * TILE];
    int left = tile % tiles.across * TILE, top = tile / tiles.across * TILE;
    sortfree_tile<DEPTH, SURFACES>(bins, tile, left, top, splats, tile_sums);
    int wide = std::min(TILE, view.width - left);
    for (int row = 0; row < TILE && top + row < view.height; row++) {
      const float* p = tile_sums + row * C * TILE;
      int64 at = (int64)(top + row) * view.width + left;
      for (int c = 0; c < C; c++)
        std::memcpy(sums + ((int64)(top + row) * C + c) * view.width + left, p + c * TILE,
                    sizeof(float) * wide);
      for (int l = 0; l < wide; l++) {
        const float* q = p + l;
        Pixel pixel = {q[0], q[TILE], q[2 * TILE], DEPTH ? q[5 * TILE] : 0.0f, q[3 * TILE],
                       q[4 * TILE]};
        sortfree_resolve(view, pixel, image + 3 * (at + l), alpha + at + l,
                         DEPTH ? depth + at + l : nullptr);
      }
    }
  }
}

// dL/d of every pixel's sums, and its depth limit: channel planes within each row, padded so that a
// vector may start at any pixel.
template <bool DEPTH, bool SURFACES>
Buffer<float> pixel_gradients(const View& view, const float* sums, const float* g_image,
                              const float* g_alpha, const float* g_depth, int stride) {
  constexpr int C = channels<DEPTH, SURFACES>;
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
      if (SURFACES) out[(C - 1) * stride + x] = p[(C - 1) * w + x];
    }
    for (int c = 0; c < C; c++)
      std::fill_n(out + c * stride + view.width, stride - view.width, 0.0f);
  }
  return grads;
}

// Indices of the Gaussians by the tile of their box's centre, invisible ones last: neighbours in
// the image then read the same pixels from the cache.
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

template <bool DEPTH, bool SURFACES>
MGS_FN Sums<float> sortfree_gather(const Splat& s, const float* grads, int stride) {
  constexpr int C = channels<DEPTH, SURFACES>;
  const vfloat lanes = iota();
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
      vfloat dx = lanes + (x + 0.5f - s.x);
      const float* p = g + x;
      vfloat alpha = pair_alpha(dx, line);
      if (SURFACES) alpha = select(load(p + (C - 1) * stride) < s.z, vfloat{}, alpha);
      vfloat g_z = DEPTH ? load(p + 5 * stride) : vfloat{};
      sortfree_pair_adjoint<DEPTH>(sums, s, alpha, dx, dy, load(p), load(p + stride),
                                   load(p + 2 * stride), g_z, load(p + 3 * stride),
                                   load(p + 4 * stride));
    }
  }
  return reduce(sums);
}

template <bool DEPTH, bool SURFACES>
void sortfree_backward(const View& view, int n, const Inputs& in, const Splat* splats,
                       const float* sums, const float* g_image, const float* g_alpha,
                       const float* g_depth, const Gradients& out) {
  int stride = view.width + LANES;
  Buffer<float> grads =
      pixel_gradients<DEPTH, SURFACES>(view, sums, g_image, g_alpha, g_depth, stride);
  std::vector<int> order = screen_order(view, n, splats);
  Buffer<Sums<float>> totals(n);
#pragma omp parallel
  {
    FlushDenormals flush;
#pragma omp for schedule(dynamic, 256)
    for (int k = 0; k < n; k++) {
      const Splat& s = splats[order[k]];
      if (k + 4 < n) __builtin_prefetch(&splats[order[k + 4]]);
      if (visible(s)) totals[order[k]] = sortfree_gather<DEPTH, SURFACES>(s, grads.get(), stride);
    }
    // by index again: inputs and gradients are then read and written in order
#pragma omp for schedule(static)
    for (int i = 0; i < n; i++) {
      if (visible(splats[i]))
        write_gradients(view, i, in, splats[i], splat_grad(totals[i], splats[i], true), out);
      else
        write_zero_gradients(view, i, out);
    }
  }
}

}  // namespace
