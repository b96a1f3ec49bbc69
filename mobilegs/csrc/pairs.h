// The arithmetic of one Gaussian at one pixel, shared by the CPU and CUDA kernels: the tiles that a
// Gaussian touches, alpha, and the adjoint of one (pixel, Gaussian) pair; then the colour of a
// pixel. Templates over the lane type V of lanes.h. The reference is render/project.py and
// sortfree.py.
#pragma once
#include "core.h"

// ---------------------------------------------------------------- tiles
// a b + c, rounded in one way wherever it is compiled: a compiler may round the plain expression
// once or twice, and decides anew in every function.
MGS_FN float muladd(float a, float b, float c) {
#if defined(__CUDACC_RTC__) || defined(__CUDACC__)
  return __fmaf_rn(a, b, c);
#elif defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return __builtin_fmaf(a, b, c);
#else
  return a * b + c;
#endif
}

// Columns [left, right], in pixels of the image, that the ellipse alpha >= alpha_min covers on the
// rows with centres in [y_first, y_last]. Tiles are counted in one CUDA kernel and listed in another:
// no sum of a product is left to the compiler, so that both find the same ones.
MGS_FN void row_span(const Splat& s, float y_first, float y_last, float& left, float& right) {
  float inverse_a = 1 / s.A, det = s.det, square_a = s.reach * s.A;
  float top = sqrtf(square_a / det);                   // half height of the ellipse
  float half = sqrtf(s.reach * s.C / det);             // half width, reached at ...
  float at = -s.B / s.C * half;                        // ... this dy on the right side
  float dy0 = max_of(y_first - s.y, -top), dy1 = min_of(y_last - s.y, top);
  float root0 = sqrtf(max_of(0.0f, muladd(-(det * dy0), dy0, square_a)));
  float root1 = sqrtf(max_of(0.0f, muladd(-(det * dy1), dy1, square_a)));
  bool widest = at >= dy0 && at <= dy1, narrowest = -at >= dy0 && -at <= dy1;
  right = widest ? half + s.x
                 : muladd(max_of(muladd(-s.B, dy0, root0), muladd(-s.B, dy1, root1)), inverse_a, s.x);
  left = narrowest
             ? s.x - half
             : muladd(min_of(muladd(-s.B, dy0, -root0), muladd(-s.B, dy1, -root1)), inverse_a, s.x);
}

// The tile of the box's centre of a visible splat; `grid` is its level's.
MGS_FN int center_tile(const Splat& s, const Grid& grid) {
  return grid.first_tile + (s.y0 + s.y1 - 1) / 2 / TILE * grid.across + (s.x0 + s.x1 - 1) / 2 / TILE;
}

// Calls visit(tile, count) for every row of tiles that the ellipse of a visible splat may touch: the
// first one there and their number. `grid` is its level's.
template <class F>
MGS_FN void for_tile_rows(const Splat& s, const Grid& grid, F visit) {
  for (int ty = s.y0 / TILE; ty <= (s.y1 - 1) / TILE; ty++) {
    float left, right;
    int y_first = s.y0 > ty * TILE ? s.y0 : ty * TILE;
    int y_last = s.y1 - 1 < ty * TILE + TILE - 1 ? s.y1 - 1 : ty * TILE + TILE - 1;
    row_span(s, y_first + 0.5f, y_last + 0.5f, left, right);
    float first = max_of((float)s.x0, ceilf(left - 0.51f));
    float last = min_of((float)(s.x1 - 1), floorf(right - 0.49f));
    if (!(first <= last)) continue;
    int tx = (int)first / TILE;
    visit(grid.first_tile + ty * grid.across + tx, (int)last / TILE - tx + 1);
  }
}

// Calls visit(tile) for every one of these tiles.
template <class F>
MGS_FN void for_tiles(const Splat& s, const Grid& grid, F visit) {
  for_tile_rows(s, grid, [&](int tile, int count) {
    for (int end = tile + count; tile < end; tile++) visit(tile);
  });
}

// ---------------------------------------------------------------- one pair
// Coefficients of alpha along a row of pixels. alpha = o exp(-q / 2) (3DGS, Eq. 4) is written as
// 2^(dx (dx a + b) + c) and counts where the exponent is at least `least`.
// Same formula: pair_alphas in render/project.py, the fragment shaders splat.wgsl and splat.glsl.
template <class V>
struct Row {
  float a;
  V b, c;
  float least;
};

// log2 of the compensated alpha_min.
MGS_FN float least_of(const Splat& s) { return s.log2_opacity - 0.5f * LOG2_E * s.reach; }

// `along` and `across` are elements of the conic, in the direction of the row and of `d`.
template <class V>
MGS_FN Row<V> line_of(const Splat& s, float along, float across, V d) {
  return {-0.5f * LOG2_E * along, -LOG2_E * s.B * d,
          -0.5f * LOG2_E * across * d * d + s.log2_opacity, least_of(s)};
}
MGS_FN Row<float> row_of(const Splat& s, float dy) { return line_of(s, s.A, s.C, dy); }
// The same along columns of pixels, one per lane: dx and dy change places.
template <class V>
MGS_FN Row<V> columns_of(const Splat& s, V dx) {
  return line_of(s, s.C, s.A, dx);
}

// The constant that a soft edge subtracts from alpha; 0 for a hard edge.
MGS_FN float edge_of(const View& view, const Splat& s) {
  return view.soft_edge ? exp2f(least_of(s)) : 0.0f;
}

// Alpha before the edge is subtracted and before its clamp to ALPHA_MAX; 0 below alpha_min.
template <class V, class D>
MGS_FN V pair_alpha(V dx, const Row<D>& row) {
  V exponent = dx * (dx * row.a + row.b) + row.c;
  return select(exponent < row.least, splat_value(exponent, 0.0f), exp2_of(exponent));
}

// Alpha from what pair_alpha returns.
template <class V>
MGS_FN V finish_alpha(V raw, float edge) {
  return min_of(max_of(raw - edge, splat_value(raw, 0.0f)), splat_value(raw, ALPHA_MAX));
}

// Sums over the pixels of one Gaussian, from which its gradients follow.
template <class V>
struct Sums {
  V r, g, b, z, w;              // dL/d colour, depth and weight
  V q, qx, qy, qxx, qxy, qyy;   // raw alpha dL/dalpha, and its moments in dx and dy
  V c;                          // alpha dL/dalpha, which differs at a soft edge
};

template <class V>
MGS_FN void add_moments(Sums<V>& sums, V gq, V dx, float dy) {
  V gx = gq * dx, gy = gq * dy;
  sums.q += gq;
  sums.qx += gx;
  sums.qy += gy;
  sums.qxx += gx * dx;
  sums.qxy += gx * dy;
  sums.qyy += gy * dy;
}

// Adjoint of one sort-free pair; `raw` is what pair_alpha returns. g_r, g_g, g_b, g_z and g_w are
// dL/d of the pixel's sums, g_t is T dL/dT. Returns raw dL/dalpha, whose moments are not added.
template <bool DEPTH, class V>
MGS_FN V sortfree_pair_adjoint(Sums<V>& sums, const Splat& s, V raw, float edge, V g_r, V g_g,
                               V g_b, V g_z, V g_w, V g_t) {
  V alpha = finish_alpha(raw, edge);
  sums.r += alpha * g_r;
  sums.g += alpha * g_g;
  sums.b += alpha * g_b;
  sums.w += alpha * g_w;
  V inner = g_r * s.r + g_g * s.g + g_b * s.b + g_w;
  if (DEPTH) {
    sums.z += alpha * g_z;
    inner += g_z * s.z;
  }
  V g_alpha = inner * s.weight - g_t * reciprocal(1.0f - alpha);
  g_alpha = select(raw > ALPHA_MAX + edge, splat_value(raw, 0.0f), g_alpha);
  sums.c += g_alpha * alpha;
  return g_alpha * raw;
}

// Returns the gradient of the splat from its finished sums.
template <class V>
MGS_FN SplatGrad<V> splat_grad(const Sums<V>& sums, const Projected<V>& s, bool sortfree) {
  SplatGrad<V> d;
  V share = sortfree ? s.weight : of<V>(1);
  d.r = share * sums.r, d.g = share * sums.g, d.b = share * sums.b, d.z = share * sums.z;
  d.weight = sortfree ? s.r * sums.r + s.g * sums.g + s.b * sums.b + s.z * sums.z + sums.w
                      : of<V>(0);
  V inverse_side = 1.0f / side_of(s.level);
  d.log_opacity = sums.q;
  d.log_compensation = sortfree ? sums.c : sums.q;
  d.x = (s.A * sums.qx + s.B * sums.qy) * inverse_side;
  d.y = (s.B * sums.qx + s.C * sums.qy) * inverse_side;
  d.A = -0.5f * sums.qxx, d.B = -sums.qxy, d.C = -0.5f * sums.qyy;
  return d;
}

// A pixel of sort-free blending after all Gaussians: sums of c a w, z a w and a w, and T.
template <class V>
struct Pixel {
  V r, g, b, z, w, t;
};

// dL/d of the sums of one pixel, T included.
template <class V>
MGS_FN Pixel<V> sortfree_pixel_adjoint(const View& view, const Pixel<V>& p, const V* g_image,
                                       V g_alpha, V g_depth) {
  const V zero = of<V>(0);
  auto touched = p.w > WEIGHT_MIN;
  V inverse = 1.0f / p.w, coverage = 1.0f - p.t, mean_z = p.z * inverse;
  V total = 1.0f / (view.background_weight + p.w);
  V g_s = g_depth * mean_z, g_w = -g_depth * mean_z * coverage * inverse;
  const V sums[3] = {p.r, p.g, p.b};
  V found[3];
  for (int k = 0; k < 3; k++) {
    if (view.weighting == SORT_FREE_GS) {
      V value = (view.background_weight * view.background[k] + sums[k]) * total;
      found[k] = g_image[k] * total;
      g_w -= g_image[k] * value * total;
    } else {
      V mean = sums[k] * inverse;
      found[k] = g_image[k] * coverage * inverse;
      g_w -= g_image[k] * mean * coverage * inverse;
      g_s += g_image[k] * (mean - view.background[k]);
    }
  }
  return {select(touched, found[0], zero),
          select(touched, found[1], zero),
          select(touched, found[2], zero),
          select(touched, g_depth * coverage * inverse, zero),
          select(touched, g_w, zero),
          -g_alpha - select(touched, g_s, zero)};
}

// The colour of a pixel (paper Eq. 2): C = (1 - T) sum(c a w) / sum(a w) + T bg, or Eq. 1:
// C = (w_bg bg + sum(c a w)) / (w_bg + sum(a w)). The background if no Gaussian touches it.
// Same formula: render_sortfree in render/sortfree.py, resolve.wgsl and resolve.glsl.
template <class V>
MGS_FN void sortfree_resolve(const View& view, const Pixel<V>& p, V* image, V* alpha, V* depth) {
  auto touched = p.w > WEIGHT_MIN;
  *alpha = 1.0f - p.t;
  V inverse = select(touched, 1.0f / p.w, of<V>(0)), total = 1.0f / (view.background_weight + p.w);
  if (depth) *depth = (1.0f - p.t) * p.z * inverse;
  const V sums[3] = {p.r, p.g, p.b};
  for (int k = 0; k < 3; k++) {
    float back = view.background[k];
    V color = view.weighting == SORT_FREE_GS ? (view.background_weight * back + sums[k]) * total
                                             : (1.0f - p.t) * sums[k] * inverse + p.t * back;
    image[k] = select(touched, color, of<V>(back));
  }
}
