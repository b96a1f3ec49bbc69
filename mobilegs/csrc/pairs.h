// The arithmetic of one Gaussian at one pixel, shared by the CPU and CUDA kernels: the tiles that a
// Gaussian touches, alpha, and the adjoint of one (pixel, Gaussian) pair; then the colour of a
// pixel. Templates over the lane type V of lanes.h. The reference is render/project.py and
// sortfree.py.
#pragma once
#include "core.h"

// ---------------------------------------------------------------- tiles
// Columns [left, right], in pixels of the image, that the ellipse alpha >= alpha_min covers on the
// rows with centres in [y_first, y_last].
MGS_FN void row_span(const Splat& s, float y_first, float y_last, float& left, float& right) {
  float inverse_a = 1 / s.A, det = s.det;
  float top = sqrtf(s.reach * s.A / det);              // half height of the ellipse
  float half = sqrtf(s.reach * s.C / det);             // half width, reached at ...
  float at = -s.B / s.C * half;                        // ... this dy on the right side
  float dy0 = max_of(y_first - s.y, -top), dy1 = min_of(y_last - s.y, top);
  float root0 = sqrtf(max_of(0.0f, s.reach * s.A - det * dy0 * dy0));
  float root1 = sqrtf(max_of(0.0f, s.reach * s.A - det * dy1 * dy1));
  right = at >= dy0 && at <= dy1
              ? half
              : max_of((-s.B * dy0 + root0) * inverse_a, (-s.B * dy1 + root1) * inverse_a);
  left = -at >= dy0 && -at <= dy1
             ? -half
             : min_of((-s.B * dy0 - root0) * inverse_a, (-s.B * dy1 - root1) * inverse_a);
  left += s.x;
  right += s.x;
}

// The tile of the box's centre of a visible splat; `grid` is its level's.
MGS_FN int center_tile(const Splat& s, const Grid& grid) {
  return grid.first_tile + (s.y0 + s.y1 - 1) / 2 / TILE * grid.across + (s.x0 + s.x1 - 1) / 2 / TILE;
}

// Calls visit(tile) for every tile that the ellipse of a visible splat may touch. `grid` is its
// level's.
template <class F>
MGS_FN void for_tiles(const Splat& s, const Grid& grid, F visit) {
  for (int ty = s.y0 / TILE; ty <= (s.y1 - 1) / TILE; ty++) {
    float left, right;
    int y_first = s.y0 > ty * TILE ? s.y0 : ty * TILE;
    int y_last = s.y1 - 1 < ty * TILE + TILE - 1 ? s.y1 - 1 : ty * TILE + TILE - 1;
    row_span(s, y_first + 0.5f, y_last + 0.5f, left, right);
    float first = max_of((float)s.x0, ceilf(left - 0.51f));
    float last = min_of((float)(s.x1 - 1), floorf(right - 0.49f));
    if (!(first <= last)) continue;
    for (int tx = (int)first / TILE; tx <= (int)last / TILE; tx++)
      visit(grid.first_tile + ty * grid.across + tx);
  }
}

// ---------------------------------------------------------------- one pair
// Coefficients of alpha along a row of pixels. alpha = o exp(-q / 2) (3DGS, Eq. 4) is written as
// 2^(dx (dx a + b) + c) and counts where the exponent is at least `least`.
// Same formula: pair_alphas in render/project.py, the fragment shaders splat.wgsl and splat.glsl.
struct Row {
  float a, b, c, least;
};

// log2 of the compensated alpha_min.
MGS_FN float least_of(const Splat& s) { return s.log2_opacity - 0.5f * LOG2_E * s.reach; }

MGS_FN Row row_of(const Splat& s, float dy) {
  Row row;
  row.a = -0.5f * LOG2_E * s.A;
  row.b = -LOG2_E * s.B * dy;
  row.c = -0.5f * LOG2_E * s.C * dy * dy + s.log2_opacity;
  row.least = least_of(s);
  return row;
}

// The constant that a soft edge subtracts from alpha; 0 for a hard edge.
MGS_FN float edge_of(const View& view, const Splat& s) {
  return view.soft_edge ? exp2f(least_of(s)) : 0.0f;
}

// Alpha before the edge is subtracted and before its clamp to ALPHA_MAX; 0 below alpha_min.
template <class V>
MGS_FN V pair_alpha(V dx, const Row& row) {
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
// dL/d of the pixel's sums, g_t is T dL/dT.
template <bool DEPTH, class V>
MGS_FN void sortfree_pair_adjoint(Sums<V>& sums, const Splat& s, V raw, float edge, V dx, float dy,
                                  V g_r, V g_g, V g_b, V g_z, V g_w, V g_t) {
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
  add_moments(sums, g_alpha * raw, dx, dy);
}

// Returns the gradient of the splat from its finished sums.
MGS_FN SplatGrad splat_grad(const Sums<float>& sums, const Splat& s, bool sortfree) {
  SplatGrad d;
  float share = sortfree ? s.weight : 1.0f;
  d.r = share * sums.r, d.g = share * sums.g, d.b = share * sums.b, d.z = share * sums.z;
  d.weight =
      sortfree ? s.r * sums.r + s.g * sums.g + s.b * sums.b + s.z * sums.z + sums.w : 0.0f;
  float inverse_side = 1.0f / (1 << s.level);
  d.log_opacity = sums.q;
  d.log_compensation = sortfree ? sums.c : sums.q;
  d.x = (s.A * sums.qx + s.B * sums.qy) * inverse_side;
  d.y = (s.B * sums.qx + s.C * sums.qy) * inverse_side;
  d.A = -0.5f * sums.qxx, d.B = -sums.qxy, d.C = -0.5f * sums.qyy;
  return d;
}

// A pixel of sort-free blending after all Gaussians: sums of c a w, z a w and a w, and T.
struct Pixel {
  float r, g, b, z, w, t;
};

// dL/d of the sums of one pixel, T included.
MGS_FN Pixel sortfree_pixel_adjoint(const View& view, const Pixel& p, const float* g_image,
                                    float g_alpha, float g_depth) {
  Pixel d = {0, 0, 0, 0, 0, 0};
  float g_s = g_alpha;
  if (p.w > WEIGHT_MIN) {
    float inverse = 1 / p.w, coverage = 1 - p.t;
    float mean_z = p.z * inverse;
    d.z = g_depth * coverage * inverse;
    d.w = -g_depth * mean_z * coverage * inverse;
    g_s += g_depth * mean_z;
    const float num[3] = {p.r, p.g, p.b};
    float* out[3] = {&d.r, &d.g, &d.b};
    for (int k = 0; k < 3; k++) {
      if (view.weighting == SORT_FREE_GS) {
        float total = 1 / (view.background_weight + p.w);
        float value = (view.background_weight * view.background[k] + num[k]) * total;
        *out[k] = g_image[k] * total;
        d.w -= g_image[k] * value * total;
      } else {
        float mean = num[k] * inverse;
        *out[k] = g_image[k] * coverage * inverse;
        d.w -= g_image[k] * mean * coverage * inverse;
        g_s += g_image[k] * (mean - view.background[k]);
      }
    }
  }
  d.t = -g_s;
  return d;
}

// The colour of a pixel (paper Eq. 2): C = (1 - T) sum(c a w) / sum(a w) + T bg, or Eq. 1:
// C = (w_bg bg + sum(c a w)) / (w_bg + sum(a w)). The background if no Gaussian touches it.
// Same formula: render_sortfree in render/sortfree.py, resolve.wgsl and resolve.glsl.
MGS_FN void sortfree_resolve(const View& view, const Pixel& p, float* image, float* alpha,
                             float* depth) {
  *alpha = 1 - p.t;
  bool touched = p.w > WEIGHT_MIN;
  float inverse = touched ? 1 / p.w : 0.0f;
  if (depth) *depth = (1 - p.t) * p.z * inverse;
  const float num[3] = {p.r, p.g, p.b};
  for (int k = 0; k < 3; k++) {
    float back = view.background[k];
    if (!touched)
      image[k] = back;
    else if (view.weighting == SORT_FREE_GS)
      image[k] = (view.background_weight * back + num[k]) / (view.background_weight + p.w);
    else
      image[k] = (1 - p.t) * num[k] * inverse + p.t * back;
  }
}
