// The arithmetic of both renderers, shared by the CPU and CUDA kernels: weights, spherical
// harmonics, lobes, projection, and their adjoints, for one Gaussian. pairs.h has the arithmetic of
// one Gaussian at one pixel. The reference is mobilegs/render: project.py, sorted.py, sortfree.py,
// lobes.py, levels.py; tests compare every output and gradient with it.
#pragma once
#include "lanes.h"

#define TILE 16
#define ALPHA_MAX 0.99f
#define TRANSMITTANCE_MIN 1e-4f
#define WEIGHT_MIN 1e-12f
#define LEVELS 4
#define WEIGHT_UNIT 10.0f
#define SURFACE_ALPHA 0.5f
#define SURFACE_MARGIN 0.05f
#define NO_SURFACE 3e38f  // beyond every depth
#define LOG2_E 1.4426950408889634f

enum WeightingKind { MOBILE_GS = 0, NO_DEPTH = 1, NO_SCALE = 2, SORT_FREE_GS = 3, TWO_PASS = 4 };

// The camera, background and weighting of one image; render/kernels/kernel_view.py mirrors the
// fields.
struct View {
  float rotation[9], translation[3], position[3];  // world to camera; camera centre
  float focal[2], center[2];                       // pixels
  float limits[4];                                 // range of x/z and y/z in the Jacobian
  float near_plane;
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

// The grid with a tile, by the tile's number.
MGS_FN Grid grid_of_tile(const View& v, int tile) {
  Grid g = grid_of(v, 0);
  for (int l = 1; l < level_count(v) && tile >= g.first_tile + g.tiles; l++) g = grid_of(v, l);
  return g;
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
  short x0, x1, y0, y1;  // pixels of the ellipse's box, [x0, x1) x [y0, y1); empty: not visible
  float det;             // of the conic, from a sum of squares: A C - B^2 would cancel
  int level;
};

// dL/d of the fields of a Splat that pixels read; x and y in pixels of the image. `log_opacity` is
// dL/d ln o, `log_compensation` that of the factor of an antialiased footprint.
struct SplatGrad {
  float x, y, A, B, C, log_opacity, log_compensation, weight, r, g, b, z;
};

MGS_FN float square(float a) { return a * a; }
MGS_FN float clamp(float a, float low, float high) { return max_of(low, min_of(a, high)); }
// a clamped float as a pixel index, also for NaN
MGS_FN short pixel(float a, int limit) { return (short)clamp(a, 0.0f, (float)limit); }

// ---------------------------------------------------------------- weights
// The weight w of sort-free blending, from depth d, largest scale s_max and phi >= 0.
//   MOBILE_GS, paper Eq. 3: w = phi^2 + phi / d^2 + exp(s_max / d), the exponent clamped
//   SORT_FREE_GS, linear:   w = max(0, 1 - d / sigma) phi
// Same formula: Weighting.weights in render/sortfree.py, weight_of in the viewer's project.wgsl and
// project.glsl.
MGS_FN float weight_of(const View& v, float d, float s_max, float phi) {
  if (v.weighting == TWO_PASS) return 1;
  if (v.weighting == SORT_FREE_GS) return max_of(0.0f, 1 - d / v.sigma) * phi;
  float w = phi * phi;
  if (v.weighting != NO_DEPTH) w += phi / (d * d);
  if (v.weighting != NO_SCALE) w += expf(min_of(s_max / d, v.exponent_max));
  return w;
}

struct WeightGrad {
  float d, s_max, phi;
};

// Gradients of w, times `grad` = dL/dw.
MGS_FN WeightGrad weight_adjoint(const View& v, float d, float s_max, float phi, float grad) {
  WeightGrad out = {0, 0, 0};
  if (v.weighting == TWO_PASS) return out;
  if (v.weighting == SORT_FREE_GS) {
    float near_share = 1 - d / v.sigma;
    out.phi = grad * max_of(0.0f, near_share);
    out.d = near_share > 0 ? -grad * phi / v.sigma : 0.0f;
    return out;
  }
  float inverse = 1 / d;
  out.phi = grad * 2 * phi;
  if (v.weighting != NO_DEPTH) {
    out.phi += grad * inverse * inverse;
    out.d -= grad * 2 * phi * inverse * inverse * inverse;
  }
  float exponent = s_max * inverse;
  if (v.weighting != NO_SCALE && exponent <= v.exponent_max) {
    float e = grad * expf(exponent) * inverse;
    out.s_max = e;
    out.d -= e * exponent;
  }
  return out;
}

// TWO_PASS: the depth up to which Gaussians count where this one is the surface.
MGS_FN float limit_of(const Splat& s) { return (1 + SURFACE_MARGIN) * s.z; }

// ---------------------------------------------------------------- spherical harmonics
// Real spherical harmonics in the unit direction (x, y, z), in the order and with the signs of
// 3DGS. Same formula: sh_basis in spherical_harmonics.py, harmonics in project.wgsl and
// project.glsl.
MGS_FN void sh_basis(int size, float x, float y, float z, float* out) {
  out[0] = 0.28209479177387814f;
  if (size < 4) return;
  const float c1 = 0.4886025119029199f;
  out[1] = -c1 * y, out[2] = c1 * z, out[3] = -c1 * x;
  if (size < 9) return;
  float xx = x * x, yy = y * y, zz = z * z;
  out[4] = 1.0925484305920792f * x * y;
  out[5] = -1.0925484305920792f * y * z;
  out[6] = 0.31539156525252005f * (2 * zz - xx - yy);
  out[7] = -1.0925484305920792f * x * z;
  out[8] = 0.5462742152960396f * (xx - yy);
  if (size < 16) return;
  out[9] = -0.5900435899266435f * y * (3 * xx - yy);
  out[10] = 2.890611442640554f * x * y * z;
  out[11] = -0.4570457994644658f * y * (4 * zz - xx - yy);
  out[12] = 0.3731763325901154f * z * (2 * zz - 3 * xx - 3 * yy);
  out[13] = -0.4570457994644658f * x * (4 * zz - xx - yy);
  out[14] = 1.445305721320277f * z * (xx - yy);
  out[15] = -0.5900435899266435f * x * (xx - 3 * yy);
}

// Gradient of sum(k[i] basis[i]) with respect to the direction (x, y, z).
MGS_FN void sh_basis_adjoint(int size, float x, float y, float z, const float* k, float* g) {
  g[0] = g[1] = g[2] = 0;
  if (size < 4) return;
  const float c1 = 0.4886025119029199f;
  g[0] = -c1 * k[3], g[1] = -c1 * k[1], g[2] = c1 * k[2];
  if (size < 9) return;
  const float c2 = 1.0925484305920792f, c20 = 0.31539156525252005f, c22 = 0.5462742152960396f;
  g[0] += c2 * (y * k[4] - z * k[7]) - 2 * c20 * x * k[6] + 2 * c22 * x * k[8];
  g[1] += c2 * (x * k[4] - z * k[5]) - 2 * c20 * y * k[6] - 2 * c22 * y * k[8];
  g[2] += c2 * (-y * k[5] - x * k[7]) + 4 * c20 * z * k[6];
  if (size < 16) return;
  float xx = x * x, yy = y * y, zz = z * z;
  const float c33 = 0.5900435899266435f, c32 = 2.890611442640554f, c31 = 0.4570457994644658f;
  const float c30 = 0.3731763325901154f, c34 = 1.445305721320277f;
  g[0] += -c33 * 6 * x * y * k[9] + c32 * y * z * k[10] + c31 * 2 * x * y * k[11] -
          c30 * 6 * x * z * k[12] - c31 * (4 * zz - 3 * xx - yy) * k[13] + c34 * 2 * x * z * k[14] -
          c33 * 3 * (xx - yy) * k[15];
  g[1] += -c33 * 3 * (xx - yy) * k[9] + c32 * x * z * k[10] - c31 * (4 * zz - xx - 3 * yy) * k[11] -
          c30 * 6 * y * z * k[12] + c31 * 2 * x * y * k[13] - c34 * 2 * y * z * k[14] +
          c33 * 6 * x * y * k[15];
  g[2] += c32 * x * y * k[10] - c31 * 8 * y * z * k[11] + c30 * (6 * zz - 3 * xx - 3 * yy) * k[12] -
          c31 * 8 * x * z * k[13] + c34 * (xx - yy) * k[14];
}

// ---------------------------------------------------------------- lobes
// View-dependent opacity and phi (render/lobes.py): o = sigmoid(logit), phi = max(0, raw_phi).
struct LobeValues {
  float logit, raw_phi;
};

MGS_FN LobeValues evaluate_lobes(const View& view, const float* lobes, const float* basis) {
  LobeValues lobe = {0, 0};
  FOR_EACH_SH(i, view.lobe_size) {
    lobe.logit += basis[i] * lobes[2 * i];
    lobe.raw_phi += basis[i] * lobes[2 * i + 1];
  }
  return lobe;
}

MGS_FN int larger(int a, int b) { return a > b ? a : b; }
// Floats per Gaussian in `sh`: its harmonics, or its colour.
MGS_FN int sh_floats(const View& view) { return 3 * larger(view.sh_size, 1); }

// ---------------------------------------------------------------- projection
// Perspective projection of a 3D Gaussian to a 2D one (3DGS, Eq. 5: Sigma' = J W Sigma W^T J^T), as
// render/project.py. px and py are the rows of J W R S, whose products are Sigma'.
struct Geometry {
  float x, y, z;                   // camera space
  float tx, ty, u, v;              // x/z and y/z, and both clamped
  float rotation[9];               // of the Gaussian, row by row
  float inverse_length;            // of the quaternion
  float axes[9];                   // camera rotation times Gaussian rotation, unscaled
  float px[3], py[3];              // rows of the projected square root of the covariance
};

// Unit vector from the camera to the Gaussian, in world space.
struct Direction {
  float x, y, z, inverse_distance;
};

MGS_FN Direction direction_of(const View& view, const float* mean) {
  float x = mean[0] - view.position[0], y = mean[1] - view.position[1];
  float z = mean[2] - view.position[2];
  float inverse = 1 / sqrtf(x * x + y * y + z * z);
  return {x * inverse, y * inverse, z * inverse, inverse};
}

MGS_FN void rotation_of(const float* q, float inverse_length, float* m) {
  float w = q[0] * inverse_length, x = q[1] * inverse_length;
  float y = q[2] * inverse_length, z = q[3] * inverse_length;
  m[0] = 1 - 2 * (y * y + z * z), m[1] = 2 * (x * y - w * z), m[2] = 2 * (x * z + w * y);
  m[3] = 2 * (x * y + w * z), m[4] = 1 - 2 * (x * x + z * z), m[5] = 2 * (y * z - w * x);
  m[6] = 2 * (x * z - w * y), m[7] = 2 * (y * z + w * x), m[8] = 1 - 2 * (x * x + y * y);
}

// Returns false if the Gaussian is behind the near plane or its quaternion has length 0.
MGS_FN bool geometry_of(const View& view, const float* mean, const float* q, const float* scale,
                        Geometry& g) {
  const float* r = view.rotation;
  g.z = r[6] * mean[0] + r[7] * mean[1] + r[8] * mean[2] + view.translation[2];
  if (!(g.z > view.near_plane)) return false;
  g.x = r[0] * mean[0] + r[1] * mean[1] + r[2] * mean[2] + view.translation[0];
  g.y = r[3] * mean[0] + r[4] * mean[1] + r[5] * mean[2] + view.translation[1];
  float norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (!(norm > 0)) return false;
  g.inverse_length = 1 / sqrtf(norm);
  rotation_of(q, g.inverse_length, g.rotation);
  float inverse_z = 1 / g.z;
  g.tx = g.x * inverse_z, g.ty = g.y * inverse_z;
  g.u = clamp(g.tx, view.limits[0], view.limits[1]);
  g.v = clamp(g.ty, view.limits[2], view.limits[3]);
  float jx = view.focal[0] * inverse_z, jy = view.focal[1] * inverse_z;
  for (int n = 0; n < 3; n++) {
    for (int k = 0; k < 3; k++)
      g.axes[3 * k + n] = r[3 * k] * g.rotation[n] + r[3 * k + 1] * g.rotation[3 + n] +
                          r[3 * k + 2] * g.rotation[6 + n];
    g.px[n] = jx * (g.axes[n] - g.u * g.axes[6 + n]) * scale[n];
    g.py[n] = jy * (g.axes[3 + n] - g.v * g.axes[6 + n]) * scale[n];
  }
  return true;
}

// The 2D covariance before the blur, its determinant, and both after it. The determinants are sums
// of squares (Cauchy-Binet), which cannot cancel.
struct Covariance {
  float c[3];  // cross product of px and py
  float det_before, var_x, var_y, cov, det;
};

MGS_FN Covariance covariance_of(const View& view, const Geometry& g) {
  Covariance s;
  s.var_x = s.var_y = view.blur, s.cov = 0;
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
MGS_FN int level_of(const View& view, const Covariance& s, float w) {
  if (!(view.level_sigma > 0)) return 0;
  float skew = 0.5f * (s.var_x - s.var_y);
  float larger = 0.5f * (s.var_x + s.var_y) + sqrtf(skew * skew + s.cov * s.cov);
  float needed = square(view.level_sigma) * sqrtf(max_of(w * (1 / WEIGHT_UNIT), 1.0f));
  float share = s.det / (larger * needed);
  return (share >= 4) + (share >= 16) + (share >= 64);
}

// The covariance at a level, in its pixels: less what enlarging adds (at_level in
// render/levels.py). Returns ln of the opacity's factor.
MGS_FN float to_level(Covariance& s, int level) {
  float side = (float)(1 << level), area = side * side, spread = 0.25f * (area - 1);
  float det = s.det - spread * (s.var_x + s.var_y) + spread * spread;
  float log_factor = 0.5f * logf(s.det / det);
  s.var_x = (s.var_x - spread) / area, s.var_y = (s.var_y - spread) / area;
  s.cov /= area, s.det = det / (area * area);
  return log_factor;
}

// Sets a splat's box in an image of width x height; false, with an empty box, if it misses it.
MGS_FN bool set_box(Splat& s, float rx, float ry, int width, int height) {
  s.x0 = pixel(ceilf(s.x - rx - 0.5f), width);
  s.x1 = pixel(floorf(s.x + rx - 0.5f) + 1, width);
  s.y0 = pixel(ceilf(s.y - ry - 0.5f), height);
  s.y1 = pixel(floorf(s.y + ry - 0.5f) + 1, height);
  if (s.x1 > s.x0 && s.y1 > s.y0) return true;
  s.x0 = s.x1 = s.y0 = s.y1 = 0;
  return false;
}

MGS_FN float largest(const float* s) { return max_of(s[0], max_of(s[1], s[2])); }

// Returns false, with an empty box, if the Gaussian cannot touch the image. Sort-free blending
// takes opacity and phi from `lobes`; sorted blending (lobe_size 0) takes `opacity`. With sh_size 0
// `sh` holds the colour, which is used as it is.
MGS_FN bool project(const View& view, const float* mean, const float* q, const float* scale,
                    float opacity, const float* sh, const float* lobes, Splat& s) {
  s.x0 = s.x1 = s.y0 = s.y1 = 0;
  s.z = 0, s.level = 0;
  Geometry g = {};
  if (!geometry_of(view, mean, q, scale, g)) return false;
  float basis[16];
  Direction direction = direction_of(view, mean);
  sh_basis(larger(view.sh_size, view.lobe_size), direction.x, direction.y, direction.z, basis);
  LobeValues lobe = {0, 0};
  if (view.lobe_size) {
    lobe = evaluate_lobes(view, lobes, basis);
    opacity = 1 / (1 + expf(-lobe.logit));
  }
  if (!(opacity > view.alpha_min)) return false;
  Covariance cov = covariance_of(view, g);
  if (view.antialiased && !(cov.det_before > 0)) return false;
  s.x = view.focal[0] * g.tx + view.center[0], s.y = view.focal[1] * g.ty + view.center[1];
  s.z = g.z;
  s.log2_opacity = log2f(opacity);
  s.reach = (2 / LOG2_E) * (s.log2_opacity - log2f(view.alpha_min));  // 2 ln(o / alpha_min)
  s.weight = weight_of(view, g.z, largest(scale), max_of(lobe.raw_phi, 0.0f));

  bool given = view.sh_size == 0;
  float color[3];
  for (int k = 0; k < 3; k++) color[k] = given ? sh[k] : 0.5f;
  FOR_EACH_SH(i, view.sh_size)
    for (int k = 0; k < 3; k++) color[k] += basis[i] * sh[3 * i + k];
  s.r = given ? color[0] : max_of(color[0], 0.0f);
  s.g = given ? color[1] : max_of(color[1], 0.0f);
  s.b = given ? color[2] : max_of(color[2], 0.0f);
  float compensation =
      view.antialiased ? 0.5f * LOG2_E * logf(cov.det_before / cov.det) : 0.0f;  // log2
  float rx = sqrtf(s.reach * cov.var_x), ry = sqrtf(s.reach * cov.var_y);
  int level = level_of(view, cov, s.weight);
  float center_x = s.x, center_y = s.y;
  if (level > 0) {
    float factor = to_level(cov, level), inverse_side = 1.0f / (1 << level);
    s.log2_opacity += LOG2_E * factor;
    s.reach += 2 * factor;
    s.x = s.x * inverse_side + 1, s.y = s.y * inverse_side + 1;
  }
  float inverse_det = 1 / cov.det;
  s.log2_opacity += compensation;
  s.det = inverse_det;
  s.A = cov.var_y * inverse_det, s.B = -cov.cov * inverse_det, s.C = cov.var_x * inverse_det;
  // one test finds every value that is not finite: only for finite x is x - x 0
  float check = s.A + s.B + s.C + s.x + s.y + s.weight + color[0] + color[1] + color[2];
  check += scale[0] + scale[1] + scale[2] + lobe.logit + lobe.raw_phi + s.log2_opacity;
  if (!(check - check == 0)) return false;
  if (level == 0) return set_box(s, rx, ry, view.width, view.height);
  // not in the image: not in the border of a coarse target either
  Splat whole;
  whole.x = center_x, whole.y = center_y;
  if (!set_box(whole, rx, ry, view.width, view.height)) return false;
  Grid grid = grid_of(view, level);
  s.level = level;
  return set_box(s, sqrtf(s.reach * cov.var_x), sqrtf(s.reach * cov.var_y), grid.width,
                 grid.height);
}

// In pixels of the image.
MGS_FN float radius_of(const Splat& s) {
  return (float)(1 << s.level) * sqrtf(s.reach / s.det * max_of(s.A, s.C));
}

// Gradient of the rotation matrix (row by row) back to a quaternion of any length.
MGS_FN void quaternion_adjoint(const float* q, float inverse_length, const float* m, float* out) {
  float w = q[0] * inverse_length, x = q[1] * inverse_length;
  float y = q[2] * inverse_length, z = q[3] * inverse_length;
  float gw = 2 * (x * (m[7] - m[5]) + y * (m[2] - m[6]) + z * (m[3] - m[1]));
  float gx = 2 * (y * (m[1] + m[3]) + z * (m[2] + m[6]) + w * (m[7] - m[5]) - 2 * x * (m[4] + m[8]));
  float gy = 2 * (x * (m[1] + m[3]) + z * (m[5] + m[7]) + w * (m[2] - m[6]) - 2 * y * (m[0] + m[8]));
  float gz = 2 * (x * (m[2] + m[6]) + y * (m[5] + m[7]) + w * (m[3] - m[1]) - 2 * z * (m[0] + m[4]));
  float along = gw * w + gx * x + gy * y + gz * z;  // moving along q changes nothing
  out[0] = (gw - along * w) * inverse_length, out[1] = (gx - along * x) * inverse_length;
  out[2] = (gy - along * y) * inverse_length, out[3] = (gz - along * z) * inverse_length;
}

// Adjoint of project for a visible Gaussian. Writes every gradient once: that of the opacity for
// sorted blending, of the lobes for sort-free blending.
MGS_FN void project_adjoint(const View& view, const float* mean, const float* q, const float* scale,
                            float opacity, const float* sh, const float* lobes, const Splat& s,
                            const SplatGrad& d, float* g_mean, float* g_quat, float* g_scale,
                            float* g_opacity, float* g_sh, float* g_lobes) {
  // direction-dependent terms come first: their registers are free before the geometry needs them
  Direction direction = direction_of(view, mean);
  int size = larger(view.sh_size, view.lobe_size);
  float basis[16], inner[16], g_dir[3];
  sh_basis(size, direction.x, direction.y, direction.z, basis);
  LobeValues lobe = evaluate_lobes(view, lobes, basis);
  WeightGrad gw = weight_adjoint(view, s.z, largest(scale), max_of(lobe.raw_phi, 0.0f), d.weight);
  if (view.detached) gw.d = gw.s_max = 0;
  bool given = view.sh_size == 0;
  float gc[3] = {given || s.r > 0 ? d.r : 0.0f, given || s.g > 0 ? d.g : 0.0f,
                 given || s.b > 0 ? d.b : 0.0f};
  for (int k = 0; k < 3; k++)
    if (given) g_sh[k] = gc[k];
  // 1 - o computed as a sigmoid: near o = 1 the difference would lose its digits
  float g_logit = d.log_opacity / (1 + expf(lobe.logit));
  float g_phi = lobe.raw_phi > 0 ? gw.phi : 0.0f;
  FOR_EACH_SH(i, size) inner[i] = 0;
  FOR_EACH_SH(i, view.sh_size) {
    inner[i] = gc[0] * sh[3 * i] + gc[1] * sh[3 * i + 1] + gc[2] * sh[3 * i + 2];
    for (int k = 0; k < 3; k++) g_sh[3 * i + k] = basis[i] * gc[k];
  }
  FOR_EACH_SH(i, view.lobe_size) {
    inner[i] += g_logit * lobes[2 * i] + g_phi * lobes[2 * i + 1];
    g_lobes[2 * i] = basis[i] * g_logit, g_lobes[2 * i + 1] = basis[i] * g_phi;
  }
  if (g_opacity) *g_opacity = d.log_opacity / opacity;
  sh_basis_adjoint(size, direction.x, direction.y, direction.z, inner, g_dir);
  float along = g_dir[0] * direction.x + g_dir[1] * direction.y + g_dir[2] * direction.z;
  const float towards[3] = {(g_dir[0] - along * direction.x) * direction.inverse_distance,
                            (g_dir[1] - along * direction.y) * direction.inverse_distance,
                            (g_dir[2] - along * direction.z) * direction.inverse_distance};

  Geometry g = {};
  geometry_of(view, mean, q, scale, g);
  const float* r = view.rotation;
  float inverse_z = 1 / g.z, jx = view.focal[0] * inverse_z, jy = view.focal[1] * inverse_z;
  // conic K = inverse of the covariance: dSigma = -K dK K, the off-diagonal counted once
  float half_b = 0.5f * d.B;
  float m00 = d.A * s.A + half_b * s.B, m01 = d.A * s.B + half_b * s.C;
  float m10 = half_b * s.A + d.C * s.B, m11 = half_b * s.B + d.C * s.C;
  float g_xx = -(s.A * m00 + s.B * m10), g_yy = -(s.B * m01 + s.C * m11);
  float g_xy = -(s.A * m01 + s.B * m11) - (s.B * m00 + s.C * m10);
  float along_cross = 0;  // dL/d of px x py, by that product
  Covariance cov;
  if (s.level > 0 || view.antialiased) {
    cov = covariance_of(view, g);
    // of 1/2 ln det S, to which both factors of the opacity belong
    float share = (s.level > 0 ? d.log_opacity : 0.0f) -
                  (view.antialiased ? d.log_compensation : 0.0f);
    share *= 0.5f / cov.det;
    // at a level, dL/d of the covariance in its pixels, and the factor's -1/2 ln det S'
    float level_share = s.level > 0 ? 0.5f * d.log_opacity : 0.0f;
    float inverse_area = 1.0f / (1 << 2 * s.level);
    g_xx = share * cov.var_y + inverse_area * (g_xx - level_share * s.A);
    g_yy = share * cov.var_x + inverse_area * (g_yy - level_share * s.C);
    g_xy = -2 * share * cov.cov + inverse_area * (g_xy - 2 * level_share * s.B);
    if (view.antialiased) along_cross = d.log_compensation / cov.det_before;
  }

  int largest_axis =
      scale[0] >= scale[1] ? (scale[0] >= scale[2] ? 0 : 2) : (scale[1] >= scale[2] ? 1 : 2);
  float g_u = 0, g_v = 0, g_z = d.z + gw.d, g_m[9];
  for (int n = 0; n < 3; n++) {
    float gp = 2 * g_xx * g.px[n] + g_xy * g.py[n], gq = g_xy * g.px[n] + 2 * g_yy * g.py[n];
    if (view.antialiased) {
      int i = (n + 1) % 3, j = (n + 2) % 3;
      gp += along_cross * (g.py[i] * cov.c[j] - g.py[j] * cov.c[i]);
      gq += along_cross * (cov.c[i] * g.px[j] - cov.c[j] * g.px[i]);
    }
    g_z -= (gp * g.px[n] + gq * g.py[n]) * inverse_z;
    float ax = gp * jx, ay = gq * jy, az = -ax * g.u - ay * g.v;  // towards the scaled axis
    g_scale[n] = ax * g.axes[n] + ay * g.axes[3 + n] + az * g.axes[6 + n];
    if (n == largest_axis) g_scale[n] += gw.s_max;
    g_u -= ax * g.axes[6 + n] * scale[n];
    g_v -= ay * g.axes[6 + n] * scale[n];
    for (int k = 0; k < 3; k++)
      g_m[3 * k + n] = scale[n] * (r[k] * ax + r[3 + k] * ay + r[6 + k] * az);
  }
  quaternion_adjoint(q, g.inverse_length, g_m, g_quat);
  float g_tx = d.x * view.focal[0] + (g.u == g.tx ? g_u : 0.0f);
  float g_ty = d.y * view.focal[1] + (g.v == g.ty ? g_v : 0.0f);
  float g_x = g_tx * inverse_z, g_y = g_ty * inverse_z;
  g_z -= g_x * g.tx + g_y * g.ty;
  for (int k = 0; k < 3; k++)
    g_mean[k] = r[k] * g_x + r[3 + k] * g_y + r[6 + k] * g_z + towards[k];
}
