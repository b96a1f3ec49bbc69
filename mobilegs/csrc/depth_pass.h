// The depth pass of sort-free blending, shared by the CPU and CUDA kernels: a splat in its picture,
// and the visibility at a pixel. The reference is render/depth_pass.py, with the same constants.
#pragma once
#include "core.h"

#define PASS_LEVEL 2
#define PASS_BLUR 2.25f
#define DEPTH_FLOOR 0.02f
#define DEPTH_SLOPE 0.4f
#define ALPHAS_MIN 1e-6f
#define ALPHAS_MAX 16.0f

// The picture of the depth pass (render/depth_pass.py) as an image of its own, of one level.
MGS_FN View depth_view(const View& view) {
  Grid grid = grid_of(view, PASS_LEVEL);
  View pass = view;
  pass.level_sigma = 0, pass.width = grid.width, pass.height = grid.height;
  return pass;
}

MGS_FN float log_depth(const Splat& s) { return (1 / LOG2_E) * log2_of(s.z); }

// A visible splat in that picture, with ln z for its red; the box is empty where it is too faint.
MGS_FN Splat depth_splat(const View& pass, const Splat& s) {
  const float side = 1 << s.level, area = side * side, wide = 1 << PASS_LEVEL;
  float scale = area / s.det, more = 0.25f * (area - 1.0f) + PASS_BLUR;
  float var_x = s.C * scale + more, var_y = s.A * scale + more, own = area * scale;
  float det = own + more * (s.A + s.C) * scale + more * more, factor = 0.5f * log2_of(own / det);
  Projected<float> p = {};
  p.x = (s.level ? (s.x - 1.0f) * side : s.x) / wide + 1.0f;
  p.y = (s.level ? (s.y - 1.0f) * side : s.y) / wide + 1.0f;
  p.reach = s.reach + (2 / LOG2_E) * factor;
  float across = sqrt_of(max_of(p.reach, 0.0f)) / wide;
  set_box(p, p.reach > 0.0f, across * sqrt_of(var_x), across * sqrt_of(var_y), (float)pass.width,
          (float)pass.height);
  Splat out = s;
  float inverse = wide * wide / det;
  out.x = p.x, out.y = p.y, out.reach = p.reach, out.level = 0;
  out.A = var_y * inverse, out.B = s.B * scale * inverse, out.C = var_x * inverse;
  out.det = inverse * (wide * wide);
  out.log2_opacity = s.log2_opacity + factor;
  out.r = log_depth(s);
  out.x0 = (short)p.x0, out.x1 = (short)p.x1, out.y0 = (short)p.y0, out.y1 = (short)p.y1;
  return out;
}

// Parameters of the visibility at a pixel: exp2(density clamp(first + slope ln z, -1/2, 1/2)).
template <class V>
struct Fog {
  V density, first, slope;
};

// From the sums of a, a ln z and a (ln z)^2 at the pixel.
template <class V>
MGS_FN Fog<V> fog_of(V total, V first, V second) {
  V inverse = 1.0f / max_of(total, of<V>(ALPHAS_MIN)), mean = first * inverse;
  V variance = max_of(second * inverse - mean * mean, of<V>(0));
  V slope = DEPTH_SLOPE / (sqrt_of(variance) + DEPTH_FLOOR);
  return {-LOG2_E * min_of(total, of<V>(ALPHAS_MAX)), -slope * mean, slope};
}

// The place of a target's pixel in the picture, along an axis of `count` pixels: the pixel before it
// and the distance from that.
struct PicturePlace {
  int first;
  float part;
};
MGS_FN PicturePlace picture_place(int x, int level, int count) {
  float at = (x + (level ? -0.5f : 0.5f)) * (1 << level) * (1.0f / (1 << PASS_LEVEL)) + 0.5f;
  at = min_of(max_of(at, 0.0f), count - 1.0f);
  int first = (int)at < count - 2 ? (int)at : count - 2;
  return {first, at - first};
}

// The fog of a target's pixel, from the picture's three planes.
MGS_FN Fog<float> fog_of_pixel(const Grid& picture, const float* moments, int level, int x, int y) {
  PicturePlace column = picture_place(x, level, picture.width);
  PicturePlace row = picture_place(y, level, picture.height);
  const float* p = moments + (int64)row.first * picture.width + column.first;
  float found[3];
  for (int k = 0; k < 3; k++, p += (int64)picture.width * picture.height) {
    float left = p[0] + row.part * (p[picture.width] - p[0]);
    float right = p[1] + row.part * (p[picture.width + 1] - p[1]);
    found[k] = left + column.part * (right - left);
  }
  return fog_of(found[0], found[1], found[2]);
}

template <class V>
MGS_FN V visibility(const Fog<V>& fog, float log_z) {
  const V half = fog.density * 0.0f + 0.5f;
  return exp2_of(fog.density * clamp(fog.first + fog.slope * log_z, -half, half));
}
