// The arithmetic of both renderers, shared by the CPU and CUDA kernels: weights, spherical
// harmonics, lobes, projection, and their adjoints, for one Gaussian or, with the lane type V of
// lanes.h, one per lane. pairs.h has the arithmetic of one Gaussian at one pixel. The reference is
// mobilegs/render: project.py, sorted.py, sortfree.py, lobes.py, levels.py; tests compare every
// output and gradient with it.
#pragma once
#include "lanes.h"

#define TILE 16
#define ALPHA_MAX 0.99f
#define TRANSMITTANCE_MIN 1e-4f
#define WEIGHT_MIN 1e-12f
#define LEVELS 4
#define WEIGHT_UNIT 10.0f
#define LOG2_E 1.4426950408889634f

enum WeightingKind { MOBILE_GS = 0, NO_DEPTH = 1, NO_SCALE = 2, SORT_FREE_GS = 3, DEPTH_PASS = 4 };

// The camera, background and weighting of one image; render/kernels/kernel_view.py mirrors the
// fields.
struct View {
  float rotation[9], translation[3], position[3];  // world to camera; camera centre
  float focal[2], center[2];                       // pixels
  float limits[4];                                 // range of x/z and y/z in the Jacobian
  float near_plane, far_plane;
  float background[3];
  float exponent_max, sigma, background_weight;  // of the weighting
  float alpha_min;                               // alphas below are dropped
  float blur;                                    // px^2 added to both variances
  float level_sigma;                             // of render/levels.py; 0: one level
  int width, height;
  int weighting;
  int detached;   // 1: no gradient through w to depth and scale
  int sh_size;    // coefficients per colour: 1, 4, 9 or 16; 0: colours in their place
  int lobe_size;  // coefficients of opacity and phi, likewise; 0: sorted blending, with opacities
  int antialiased;  // 1: the opacity is compensated for the blur
  int soft_edge;    // 1: alpha_min is subtracted from alpha
  int raw;          // 1: scales are their logarithms, opacities their logits
  int more_width;   // floats of a row of `more`, which has the harmonics but the first; 0: `sh` has all
};

// The target of a level (render/levels.py); its tiles and pixels are numbered after those of finer
// levels.
struct Grid {
  int width, height, across, tiles;  // across: tiles in a row
  int first_tile;
  int64 first_pixel;
};

MGS_FN int level_count(const View& v) { return v.level_sigma > 0 ? LEVELS : 1; }

MGS_FN Grid grid_of(const View& v, int level) {
  Grid g = {v.width, v.height, 0, 0, 0, 0};
  for (int l = 0;; l++) {
    g.across = (g.width + TILE - 1) / TILE;
    g.tiles = g.across * ((g.height + TILE - 1) / TILE);
    if (l == level) return g;
    g.first_tile += g.tiles;
    g.first_pixel += (int64)g.width * g.height;
    int shorter = l == 0 ? 0 : 1;
    g.width = (g.width - shorter) / 2 + 2, g.height = (g.height - shorter) / 2 + 2;
  }
}

// The level of a tile, by the tile's number.
MGS_FN int level_of_tile(const View& v, int tile) {
  int level = 0;
  while (level + 1 < level_count(v) && tile >= grid_of(v, level + 1).first_tile) level++;
  return level;
}

// The number of pixels of all levels.
MGS_FN int64 pixel_count(const View& v) {
  Grid last = grid_of(v, level_count(v) - 1);
  return last.first_pixel + (int64)last.width * last.height;
}

// One projected Gaussian, in one cache line; its pixels are those of its level.
struct alignas(64) Splat {
  float x, y;          // projected mean (means2d), pixels
  float A, B, C;       // conic, 1 / px^2
  float log2_opacity;  // compensations included
  float weight;        // w of sort-free blending
  float r, g, b;       // colour; from harmonics, at least 0
  float z;             // camera-space depth
  float reach;         // squared Mahalanobis radius at which alpha is alpha_min
  float det;           // of the conic, from a sum of squares: A C - B^2 would cancel
  short x0, x1, y0, y1;  // pixels of the ellipse's box, [x0, x1) x [y0, y1); empty: not visible
  int level;
};

// The same before it is packed.
template <class V>
struct Projected {
  V x, y, A, B, C, log2_opacity, weight, r, g, b, z, reach, det, x0, x1, y0, y1, level;
};

// dL/d of the fields of a Splat that pixels read; x and y in pixels of the image. `log_opacity` is
// dL/d ln o, `log_compensation` that of the factor of an antialiased footprint.
template <class V>
struct SplatGrad {
  V x, y, A, B, C, log_opacity, log_compensation, weight, r, g, b, z;
};

MGS_FN float square(float a) { return a * a; }
template <class V>
MGS_FN V of(float x) {
  return splat_value(V{}, x);
}
// NaN becomes `high`
template <class V>
MGS_FN V clamp(V a, V low, V high) {
  return max_of(low, min_of(a, high));
}

// ---------------------------------------------------------------- weights
// The weight w of sort-free blending, from depth d, largest scale s_max and phi >= 0.
//   MOBILE_GS, paper Eq. 3: w = phi^2 + phi / d^2 + exp(s_max / d), the exponent clamped
//   SORT_FREE_GS, linear:   w = max(0, 1 - d / sigma) phi
// Same formula: Weighting.weights in render/sortfree.py, weight_of in the viewer's project.wgsl and
// project.glsl.
template <class V>
MGS_FN V weight_of(const View& v, V d, V s_max, V phi) {
  if (v.weighting == SORT_FREE_GS) return max_of(of<V>(0), 1.0f - d / v.sigma) * phi;
  V w = phi * phi;
  if (v.weighting != NO_DEPTH) w += phi / (d * d);
  if (v.weighting != NO_SCALE) w += exp_of(min_of(s_max / d, of<V>(v.exponent_max)));
  return w;
}

template <class V>
struct WeightGrad {
  V d, s_max, phi;
};

// Gradients of w, times `grad` = dL/dw.
template <class V>
MGS_FN WeightGrad<V> weight_adjoint(const View& v, V d, V s_max, V phi, V grad) {
  const V zero = of<V>(0);
  WeightGrad<V> out = {zero, zero, zero};
  if (v.weighting == SORT_FREE_GS) {
    V near_share = 1.0f - d / v.sigma;
    out.phi = grad * max_of(zero, near_share);
    out.d = select(near_share > 0, -grad * phi / v.sigma, zero);
    return out;
  }
  V inverse = 1.0f / d;
  out.phi = grad * 2.0f * phi;
  if (v.weighting != NO_DEPTH) {
    out.phi += grad * inverse * inverse;
    out.d -= grad * 2.0f * phi * inverse * inverse * inverse;
  }
  V exponent = s_max * inverse;
  if (v.weighting != NO_SCALE) {
    V e = select(exponent <= v.exponent_max, grad * exp_of(exponent) * inverse, zero);
    out.s_max = e;
    out.d -= e * exponent;
  }
  return out;
}

// ---------------------------------------------------------------- spherical harmonics
// Real spherical harmonics in the unit direction (x, y, z), in the order and with the signs of
// 3DGS. Same formula: sh_basis in spherical_harmonics.py, harmonics in project.wgsl and
// project.glsl.
template <class V>
MGS_FN void sh_basis(int size, V x, V y, V z, V* out) {
  out[0] = of<V>(0.28209479177387814f);
  if (size < 4) return;
  const float c1 = 0.4886025119029199f;
  out[1] = -c1 * y, out[2] = c1 * z, out[3] = -c1 * x;
  if (size < 9) return;
  V xx = x * x, yy = y * y, zz = z * z;
  out[4] = 1.0925484305920792f * x * y;
  out[5] = -1.0925484305920792f * y * z;
  out[6] = 0.31539156525252005f * (2.0f * zz - xx - yy);
  out[7] = -1.0925484305920792f * x * z;
  out[8] = 0.5462742152960396f * (xx - yy);
  if (size < 16) return;
  out[9] = -0.5900435899266435f * y * (3.0f * xx - yy);
  out[10] = 2.890611442640554f * x * y * z;
  out[11] = -0.4570457994644658f * y * (4.0f * zz - xx - yy);
  out[12] = 0.3731763325901154f * z * (2.0f * zz - 3.0f * xx - 3.0f * yy);
  out[13] = -0.4570457994644658f * x * (4.0f * zz - xx - yy);
  out[14] = 1.445305721320277f * z * (xx - yy);
  out[15] = -0.5900435899266435f * x * (xx - 3.0f * yy);
}

// Gradient of sum(k[i] basis[i]) with respect to the direction (x, y, z).
template <class V>
MGS_FN void sh_basis_adjoint(int size, V x, V y, V z, const V* k, V* g) {
  g[0] = g[1] = g[2] = of<V>(0);
  if (size < 4) return;
  const float c1 = 0.4886025119029199f;
  g[0] = -c1 * k[3], g[1] = -c1 * k[1], g[2] = c1 * k[2];
  if (size < 9) return;
  const float c2 = 1.0925484305920792f, c20 = 0.31539156525252005f, c22 = 0.5462742152960396f;
  g[0] += c2 * (y * k[4] - z * k[7]) - 2.0f * c20 * x * k[6] + 2.0f * c22 * x * k[8];
  g[1] += c2 * (x * k[4] - z * k[5]) - 2.0f * c20 * y * k[6] - 2.0f * c22 * y * k[8];
  g[2] += c2 * (-y * k[5] - x * k[7]) + 4.0f * c20 * z * k[6];
  if (size < 16) return;
  V xx = x * x, yy = y * y, zz = z * z;
  const float c33 = 0.5900435899266435f, c32 = 2.890611442640554f, c31 = 0.4570457994644658f;
  const float c30 = 0.3731763325901154f, c34 = 1.445305721320277f;
  g[0] += -c33 * 6.0f * x * y * k[9] + c32 * y * z * k[10] + c31 * 2.0f * x * y * k[11] -
          c30 * 6.0f * x * z * k[12] - c31 * (4.0f * zz - 3.0f * xx - yy) * k[13] +
          c34 * 2.0f * x * z * k[14] - c33 * 3.0f * (xx - yy) * k[15];
  g[1] += -c33 * 3.0f * (xx - yy) * k[9] + c32 * x * z * k[10] -
          c31 * (4.0f * zz - xx - 3.0f * yy) * k[11] - c30 * 6.0f * y * z * k[12] +
          c31 * 2.0f * x * y * k[13] - c34 * 2.0f * y * z * k[14] + c33 * 6.0f * x * y * k[15];
  g[2] += c32 * x * y * k[10] - c31 * 8.0f * y * z * k[11] +
          c30 * (6.0f * zz - 3.0f * xx - 3.0f * yy) * k[12] - c31 * 8.0f * x * z * k[13] +
          c34 * (xx - yy) * k[14];
}

// ---------------------------------------------------------------- lobes
// View-dependent opacity and phi (render/lobes.py): o = sigmoid(logit), phi = max(0, raw_phi).
template <class V>
struct LobeValues {
  V logit, raw_phi;
};

template <class V>
MGS_FN LobeValues<V> evaluate_lobes(const View& view, const float* lobes, const V* basis) {
  LobeValues<V> lobe = {of<V>(0), of<V>(0)};
  FOR_EACH_SH(i, view.lobe_size) {
    lobe.logit += basis[i] * number_at<V>(lobes, 2 * i);
    lobe.raw_phi += basis[i] * number_at<V>(lobes, 2 * i + 1);
  }
  return lobe;
}

MGS_FN int larger(int a, int b) { return a > b ? a : b; }
// Floats per Gaussian in `sh`: its harmonics, those that are not in `more`, or its colour.
MGS_FN int sh_floats(const View& view) {
  return view.more_width ? 3 : 3 * larger(view.sh_size, 1);
}
// Floats of a row of `more` that the colour has.
MGS_FN int more_floats(const View& view) { return view.more_width ? 3 * (view.sh_size - 1) : 0; }

// ---------------------------------------------------------------- projection
// Perspective projection of a 3D Gaussian to a 2D one (3DGS, Eq. 5: Sigma' = J W Sigma W^T J^T), as
// render/project.py. px and py are the rows of J W R S, whose products are Sigma'.
template <class V>
struct Geometry {
  V x, y, z;         // camera space
  V tx, ty, u, v;    // x/z and y/z, and both clamped
  V rotation[9];     // of the Gaussian, row by row
  V inverse_length;  // of the quaternion
  V axes[9];         // camera rotation times Gaussian rotation, unscaled
  V px[3], py[3];    // rows of the projected square root of the covariance
};

// Unit vector from the camera to the Gaussian, in world space.
template <class V>
struct Direction {
  V x, y, z, inverse_distance;
};

template <class V>
MGS_FN Direction<V> direction_of(const View& view, const V* mean) {
  V x = mean[0] - view.position[0], y = mean[1] - view.position[1];
  V z = mean[2] - view.position[2];
  V inverse = 1.0f / sqrt_of(x * x + y * y + z * z);
  return {x * inverse, y * inverse, z * inverse, inverse};
}

template <class V>
MGS_FN void rotation_of(const V* q, V inverse_length, V* m) {
  V w = q[0] * inverse_length, x = q[1] * inverse_length;
  V y = q[2] * inverse_length, z = q[3] * inverse_length;
  m[0] = 1.0f - 2.0f * (y * y + z * z), m[1] = 2.0f * (x * y - w * z), m[2] = 2.0f * (x * z + w * y);
  m[3] = 2.0f * (x * y + w * z), m[4] = 1.0f - 2.0f * (x * x + z * z), m[5] = 2.0f * (y * z - w * x);
  m[6] = 2.0f * (x * z - w * y), m[7] = 2.0f * (y * z + w * x), m[8] = 1.0f - 2.0f * (x * x + y * y);
}

// Returns a mask: false outside the planes and where the quaternion has length 0.
template <class V>
MGS_FN auto geometry_of(const View& view, const V* mean, const V* q, const V* scale,
                        Geometry<V>& g) {
  const float* r = view.rotation;
  g.z = r[6] * mean[0] + r[7] * mean[1] + r[8] * mean[2] + view.translation[2];
  V norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  auto shown = (g.z > view.near_plane) & (g.z < view.far_plane) & (norm > 0.0f);
  if (!any_of(shown)) return shown;
  g.x = r[0] * mean[0] + r[1] * mean[1] + r[2] * mean[2] + view.translation[0];
  g.y = r[3] * mean[0] + r[4] * mean[1] + r[5] * mean[2] + view.translation[1];
  g.inverse_length = 1.0f / sqrt_of(norm);
  rotation_of(q, g.inverse_length, g.rotation);
  V inverse_z = 1.0f / g.z;
  g.tx = g.x * inverse_z, g.ty = g.y * inverse_z;
  g.u = clamp(g.tx, of<V>(view.limits[0]), of<V>(view.limits[1]));
  g.v = clamp(g.ty, of<V>(view.limits[2]), of<V>(view.limits[3]));
  V jx = view.focal[0] * inverse_z, jy = view.focal[1] * inverse_z;
  for (int n = 0; n < 3; n++) {
    for (int k = 0; k < 3; k++)
      g.axes[3 * k + n] = r[3 * k] * g.rotation[n] + r[3 * k + 1] * g.rotation[3 + n] +
                          r[3 * k + 2] * g.rotation[6 + n];
    g.px[n] = jx * (g.axes[n] - g.u * g.axes[6 + n]) * scale[n];
    g.py[n] = jy * (g.axes[3 + n] - g.v * g.axes[6 + n]) * scale[n];
  }
  return shown;
}

// The 2D covariance before the blur, its determinant, and both after it. The determinants are sums
// of squares (Cauchy-Binet), which cannot cancel.
template <class V>
struct Covariance {
  V c[3];  // cross product of px and py
  V det_before, var_x, var_y, cov, det;
};

template <class V>
MGS_FN Covariance<V> covariance_of(const View& view, const Geometry<V>& g) {
  Covariance<V> s;
  s.var_x = s.var_y = of<V>(view.blur), s.cov = of<V>(0);
  for (int n = 0; n < 3; n++) {
    s.var_x += g.px[n] * g.px[n];
    s.var_y += g.py[n] * g.py[n];
    s.cov += g.px[n] * g.py[n];
  }
  s.c[0] = g.px[1] * g.py[2] - g.px[2] * g.py[1];
  s.c[1] = g.px[2] * g.py[0] - g.px[0] * g.py[2];
  s.c[2] = g.px[0] * g.py[1] - g.px[1] * g.py[0];
  s.det_before = s.c[0] * s.c[0] + s.c[1] * s.c[1] + s.c[2] * s.c[2];
  s.det = s.det_before + view.blur * (s.var_x + s.var_y - view.blur);
  return s;
}

// The level of a Gaussian of weight w: choose_levels in render/levels.py.
template <class V>
MGS_FN V level_of(const View& view, const Covariance<V>& s, V w) {
  const V one = of<V>(1), zero = of<V>(0);
  if (!(view.level_sigma > 0)) return zero;
  V skew = 0.5f * (s.var_x - s.var_y);
  V larger = 0.5f * (s.var_x + s.var_y) + sqrt_of(skew * skew + s.cov * s.cov);
  V needed = square(view.level_sigma) * sqrt_of(max_of(w * (1 / WEIGHT_UNIT), one));
  V share = s.det / (larger * needed);
  return select(share >= 4.0f, one, zero) + select(share >= 16.0f, one, zero) +
         select(share >= 64.0f, one, zero);
}

// Numbers of pixels of the image in a row of each pixel of a level.
template <class V>
MGS_FN V side_of(V level) {
  return select(level > 1.5f, select(level > 2.5f, of<V>(8), of<V>(4)),
                select(level > 0.5f, of<V>(2), of<V>(1)));
}

// The covariance at a level of pixels `side` wide, in them: less what enlarging adds (at_level in
// render/levels.py). Returns log2 of the opacity's factor.
template <class V>
MGS_FN V to_level(Covariance<V>& s, V side) {
  V area = side * side, spread = 0.25f * (area - 1.0f);
  V det = s.det - spread * (s.var_x + s.var_y) + spread * spread;
  V factor = 0.5f * log2_of(s.det / det);
  s.var_x = (s.var_x - spread) / area, s.var_y = (s.var_y - spread) / area;
  s.cov /= area, s.det = det / (area * area);
  return factor;
}

// Sets a splat's box in an image of width x height: empty where `shown` is false. Returns where it
// is not empty.
template <class V, class Mask>
MGS_FN Mask set_box(Projected<V>& s, Mask shown, V rx, V ry, V width, V height) {
  const V zero = of<V>(0);
  s.x0 = clamp(-floor_of(0.5f - (s.x - rx)), zero, width);
  s.x1 = clamp(floor_of(s.x + rx - 0.5f) + 1.0f, zero, width);
  s.y0 = clamp(-floor_of(0.5f - (s.y - ry)), zero, height);
  s.y1 = clamp(floor_of(s.y + ry - 0.5f) + 1.0f, zero, height);
  shown = shown & (s.x1 > s.x0) & (s.y1 > s.y0);
  s.x0 = select(shown, s.x0, zero), s.x1 = select(shown, s.x1, zero);
  s.y0 = select(shown, s.y0, zero), s.y1 = select(shown, s.y1, zero);
  return shown;
}

template <class V>
MGS_FN V largest(const V* s) {
  return max_of(s[0], max_of(s[1], s[2]));
}

template <class V>
MGS_FN void read_numbers(const float* numbers, int count, V* out) {
  for (int i = 0; i < count; i++) out[i] = number_at<V>(numbers, i);
}

template <class V>
MGS_FN void read_scales(const View& view, const float* scales, V* out) {
  read_numbers(scales, 3, out);
  for (int k = 0; k < 3; k++)
    if (view.raw) out[k] = exp_of(out[k]);
}

// Returns where the Gaussian can touch the image; elsewhere its box is empty. Sort-free blending
// takes opacity and phi from `lobes`; sorted blending (lobe_size 0) takes `opacities`. With sh_size 0
// `sh` holds the colour, which is used as it is. Number 3 of `more` follows the first harmonics, which
// `sh` has. All are as number_at reads them.
template <class V>
MGS_FN auto project(const View& view, const float* means, const float* quats, const float* scales,
                    const float* opacities, const float* sh, const float* more,
                    const float* lobes, Projected<V>& s) {
  const V zero = of<V>(0), one = of<V>(1);
  V mean[3], q[4], scale[3], basis[16];
  read_numbers(means, 3, mean), read_numbers(quats, 4, q), read_scales(view, scales, scale);
  s = Projected<V>{};
  Geometry<V> g = {};
  auto shown = geometry_of(view, mean, q, scale, g);
  if (!any_of(shown)) return shown;
  Direction<V> direction = direction_of(view, mean);
  sh_basis(larger(view.sh_size, view.lobe_size), direction.x, direction.y, direction.z, basis);
  LobeValues<V> lobe = {zero, zero};
  V opacity;
  if (view.lobe_size) {
    lobe = evaluate_lobes(view, lobes, basis);
    opacity = 1.0f / (1.0f + exp_of(-lobe.logit));
  } else {
    opacity = number_at<V>(opacities, 0);
    if (view.raw) opacity = 1.0f / (1.0f + exp_of(-opacity));
  }
  shown = shown & (opacity > view.alpha_min);
  Covariance<V> cov = covariance_of(view, g);
  if (view.antialiased) shown = shown & (cov.det_before > 0.0f);
  if (!any_of(shown)) return shown;
  s.x = view.focal[0] * g.tx + view.center[0], s.y = view.focal[1] * g.ty + view.center[1];
  s.z = g.z;
  s.log2_opacity = log2_of(opacity);
  s.reach = (2 / LOG2_E) * (s.log2_opacity - log2_of(of<V>(view.alpha_min)));  // 2 ln(o / alpha_min)
  s.weight = weight_of(view, g.z, largest(scale), max_of(lobe.raw_phi, zero));

  bool given = view.sh_size == 0;
  V color[3];
  for (int k = 0; k < 3; k++) color[k] = given ? number_at<V>(sh, k) : of<V>(0.5f);
  FOR_EACH_SH(i, view.sh_size)
    for (int k = 0; k < 3; k++) color[k] += basis[i] * number_at<V>(i ? more : sh, 3 * i + k);
  s.r = given ? color[0] : max_of(color[0], zero);
  s.g = given ? color[1] : max_of(color[1], zero);
  s.b = given ? color[2] : max_of(color[2], zero);
  V compensation = view.antialiased ? 0.5f * log2_of(cov.det_before / cov.det) : zero;  // log2
  // not in the image: not in the border of a coarse target either
  V rx = sqrt_of(s.reach * cov.var_x), ry = sqrt_of(s.reach * cov.var_y);
  V width = of<V>((float)view.width), height = of<V>((float)view.height);
  shown = set_box(s, shown, rx, ry, width, height);
  s.level = level_of(view, cov, s.weight);
  auto coarse = shown & (s.level > 0.0f);
  if (any_of(coarse)) {
    V side = select(coarse, side_of(s.level), one), inverse_side = 1.0f / side;
    V factor = to_level(cov, side);
    s.log2_opacity += factor;
    s.reach += (2 / LOG2_E) * factor;
    s.x = s.x * inverse_side + select(coarse, one, zero);
    s.y = s.y * inverse_side + select(coarse, one, zero);
    for (int l = 1; l < LEVELS; l++) {
      Grid grid = grid_of(view, l);
      width = select(s.level == (float)l, of<V>((float)grid.width), width);
      height = select(s.level == (float)l, of<V>((float)grid.height), height);
    }
  }
  V inverse_det = 1.0f / cov.det;
  s.log2_opacity += compensation;
  s.det = inverse_det;
  s.A = cov.var_y * inverse_det, s.B = -cov.cov * inverse_det, s.C = cov.var_x * inverse_det;
  // one test finds every value that is not finite: only for finite x is x - x 0
  V check = s.A + s.B + s.C + s.x + s.y + s.weight + color[0] + color[1] + color[2];
  check += scale[0] + scale[1] + scale[2] + lobe.logit + lobe.raw_phi + s.log2_opacity + opacity +
           cov.det;
  if (view.raw) {  // exp_of limits its argument
    for (int k = 0; k < 3; k++) check += number_at<V>(scales, k);
    if (!view.lobe_size) check += number_at<V>(opacities, 0);
  }
  shown = shown & (check - check == 0.0f);
  return set_box(s, shown, sqrt_of(s.reach * cov.var_x), sqrt_of(s.reach * cov.var_y), width,
                 height);
}

// In pixels of the image.
template <class V>
MGS_FN V radius_of(const Projected<V>& s) {
  return side_of(s.level) * sqrt_of(s.reach / s.det * max_of(s.A, s.C));
}

// Gradient of the rotation matrix (row by row) back to a quaternion of any length.
template <class V>
MGS_FN void quaternion_adjoint(const V* q, V inverse_length, const V* m, V* out) {
  V w = q[0] * inverse_length, x = q[1] * inverse_length;
  V y = q[2] * inverse_length, z = q[3] * inverse_length;
  V two_x = 2.0f * x, two_y = 2.0f * y, two_z = 2.0f * z;
  V gw = 2.0f * (x * (m[7] - m[5]) + y * (m[2] - m[6]) + z * (m[3] - m[1]));
  V gx = 2.0f * (y * (m[1] + m[3]) + z * (m[2] + m[6]) + w * (m[7] - m[5]) - two_x * (m[4] + m[8]));
  V gy = 2.0f * (x * (m[1] + m[3]) + z * (m[5] + m[7]) + w * (m[2] - m[6]) - two_y * (m[0] + m[8]));
  V gz = 2.0f * (x * (m[2] + m[6]) + y * (m[5] + m[7]) + w * (m[3] - m[1]) - two_z * (m[0] + m[4]));
  V along = gw * w + gx * x + gy * y + gz * z;  // moving along q changes nothing
  out[0] = (gw - along * w) * inverse_length, out[1] = (gx - along * x) * inverse_length;
  out[2] = (gy - along * y) * inverse_length, out[3] = (gz - along * z) * inverse_length;
}

// Adjoint of project for visible Gaussians. Sets every gradient once: that of the opacity for
// sorted blending, of the lobes for sort-free blending. Of one Gaussian, it adds those of `more`.
template <class V>
MGS_FN void project_adjoint(const View& view, const float* means, const float* quats,
                            const float* scales, const float* opacities, const float* more,
                            const float* lobes, const Projected<V>& s, const SplatGrad<V>& d,
                            float* g_mean, float* g_quat, float* g_scale,
                            float* g_opacity, float* g_sh, float* g_more, float* g_lobes) {
  const V zero = of<V>(0);
  V mean[3], q[4], scale[3], basis[16], inner[16], g_dir[3];
  read_numbers(means, 3, mean), read_scales(view, scales, scale);
  // direction-dependent terms come first: their registers are free before the geometry needs them
  Direction<V> direction = direction_of(view, mean);
  int size = larger(view.sh_size, view.lobe_size);
  sh_basis(size, direction.x, direction.y, direction.z, basis);
  LobeValues<V> lobe = evaluate_lobes(view, lobes, basis);
  WeightGrad<V> gw =
      weight_adjoint(view, s.z, largest(scale), max_of(lobe.raw_phi, zero), d.weight);
  if (view.detached) gw.d = gw.s_max = zero;
  bool given = view.sh_size == 0;
  V gc[3] = {d.r, d.g, d.b};
  if (!given) {
    gc[0] = select(s.r > 0.0f, d.r, zero), gc[1] = select(s.g > 0.0f, d.g, zero);
    gc[2] = select(s.b > 0.0f, d.b, zero);
  }
  for (int k = 0; k < 3; k++)
    if (given) set_number(g_sh, k, gc[k]);
  // 1 - o computed as a sigmoid: near o = 1 the difference would lose its digits
  V g_logit = d.log_opacity / (1.0f + exp_of(lobe.logit));
  V g_phi = select(lobe.raw_phi > 0.0f, gw.phi, zero);
  FOR_EACH_SH(i, size) inner[i] = zero;
  FOR_EACH_SH(i, view.sh_size) {
    for (int k = 0; k < 3; k++) {
      // the first one is the same in all directions
      if (i) inner[i] += gc[k] * number_at<V>(more, 3 * i + k);
      bool adds = i && view.more_width && lanes_of(zero) == 1;
      V before = adds ? number_at<V>(g_more, 3 * i + k) : zero;
      // rounded before it is added, as where several processes add
      set_number(i ? g_more : g_sh, 3 * i + k, before + rounded_product(basis[i], gc[k]));
    }
  }
  FOR_EACH_SH(i, view.lobe_size) {
    inner[i] += g_logit * number_at<V>(lobes, 2 * i) + g_phi * number_at<V>(lobes, 2 * i + 1);
    set_number(g_lobes, 2 * i, basis[i] * g_logit);
    set_number(g_lobes, 2 * i + 1, basis[i] * g_phi);
  }
  if (g_opacity) {
    V given_opacity = number_at<V>(opacities, 0);
    V factor = view.raw ? 1.0f + exp_of(given_opacity) : given_opacity;  // 1 - o is 1 / the former
    set_number(g_opacity, 0, d.log_opacity / factor);
  }
  sh_basis_adjoint(size, direction.x, direction.y, direction.z, inner, g_dir);
  V along = g_dir[0] * direction.x + g_dir[1] * direction.y + g_dir[2] * direction.z;
  const V towards[3] = {(g_dir[0] - along * direction.x) * direction.inverse_distance,
                        (g_dir[1] - along * direction.y) * direction.inverse_distance,
                        (g_dir[2] - along * direction.z) * direction.inverse_distance};

  read_numbers(quats, 4, q);
  Geometry<V> g = {};
  geometry_of(view, mean, q, scale, g);
  const float* r = view.rotation;
  V inverse_z = 1.0f / g.z, jx = view.focal[0] * inverse_z, jy = view.focal[1] * inverse_z;
  // conic K = inverse of the covariance: dSigma = -K dK K, the off-diagonal counted once
  V half_b = 0.5f * d.B;
  V m00 = d.A * s.A + half_b * s.B, m01 = d.A * s.B + half_b * s.C;
  V m10 = half_b * s.A + d.C * s.B, m11 = half_b * s.B + d.C * s.C;
  V g_xx = -(s.A * m00 + s.B * m10), g_yy = -(s.B * m01 + s.C * m11);
  V g_xy = -(s.A * m01 + s.B * m11) - (s.B * m00 + s.C * m10);
  V along_cross = zero;  // dL/d of px x py, by that product
  Covariance<V> cov;
  auto coarse = s.level > 0.0f;
  if (any_of(coarse) || view.antialiased) {
    cov = covariance_of(view, g);
    // of 1/2 ln det S, to which both factors of the opacity belong
    V level_share = select(coarse, d.log_opacity, zero), share = level_share;
    if (view.antialiased) share -= d.log_compensation;
    share *= 0.5f / cov.det;
    // at a level, dL/d of the covariance in its pixels, and the factor's -1/2 ln det S'
    level_share *= 0.5f;
    V inverse_side = 1.0f / side_of(s.level), inverse_area = inverse_side * inverse_side;
    g_xx = share * cov.var_y + inverse_area * (g_xx - level_share * s.A);
    g_yy = share * cov.var_x + inverse_area * (g_yy - level_share * s.C);
    g_xy = -2.0f * share * cov.cov + inverse_area * (g_xy - 2.0f * level_share * s.B);
    if (view.antialiased) along_cross = d.log_compensation / cov.det_before;
  }

  // the first of the largest axes
  auto first = (scale[0] >= scale[1]) & (scale[0] >= scale[2]);
  auto second = scale[1] >= scale[2];
  const V of_axis[3] = {select(first, gw.s_max, zero),
                        select(first, zero, select(second, gw.s_max, zero)),
                        select(first, zero, select(second, zero, gw.s_max))};
  V g_u = zero, g_v = zero, g_z = d.z + gw.d, g_m[9], turn[4];
  for (int n = 0; n < 3; n++) {
    V gp = 2.0f * g_xx * g.px[n] + g_xy * g.py[n], gq = g_xy * g.px[n] + 2.0f * g_yy * g.py[n];
    if (view.antialiased) {
      int i = (n + 1) % 3, j = (n + 2) % 3;
      gp += along_cross * (g.py[i] * cov.c[j] - g.py[j] * cov.c[i]);
      gq += along_cross * (cov.c[i] * g.px[j] - cov.c[j] * g.px[i]);
    }
    g_z -= (gp * g.px[n] + gq * g.py[n]) * inverse_z;
    V ax = gp * jx, ay = gq * jy, az = -ax * g.u - ay * g.v;  // towards the scaled axis
    V found = ax * g.axes[n] + ay * g.axes[3 + n] + az * g.axes[6 + n] + of_axis[n];
    set_number(g_scale, n, view.raw ? found * scale[n] : found);
    g_u -= ax * g.axes[6 + n] * scale[n];
    g_v -= ay * g.axes[6 + n] * scale[n];
    for (int k = 0; k < 3; k++)
      g_m[3 * k + n] = scale[n] * (r[k] * ax + r[3 + k] * ay + r[6 + k] * az);
  }
  quaternion_adjoint(q, g.inverse_length, g_m, turn);
  for (int k = 0; k < 4; k++) set_number(g_quat, k, turn[k]);
  V g_tx = d.x * view.focal[0] + select(g.u == g.tx, g_u, zero);
  V g_ty = d.y * view.focal[1] + select(g.v == g.ty, g_v, zero);
  V g_x = g_tx * inverse_z, g_y = g_ty * inverse_z;
  g_z -= g_x * g.tx + g_y * g.ty;
  for (int k = 0; k < 3; k++)
    set_number(g_mean, k, r[k] * g_x + r[3 + k] * g_y + r[6 + k] * g_z + towards[k]);
}
