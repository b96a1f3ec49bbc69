// The arithmetic of the terms of a student's loss that need no image, shared by the CPU (terms.cpp)
// and CUDA (cuda_terms.h). The reference is overdraw.py and quantization.py in train/student.
#pragma once
#include "core.h"

constexpr int CODE_LIMIT = 2047;    // of uniform_quantizer.py
constexpr float ANGLE_MIN = 1e-9f;  // of rotations.py

// A learned step size: initial * e^log_offset, within least and most.
struct LearnedStep {
  const float* log_offset;
  float initial, least, most;
};

MGS_FN float step_of(const LearnedStep& s) {
  return clamp(s.initial * expf(*s.log_offset), s.least, s.most);
}

// The code of a value that is so many step sizes.
MGS_FN float nearest_code(float multiple) {
  multiple = clamp(multiple, -(float)CODE_LIMIT, (float)CODE_LIMIT);
  return (multiple + 12582912.0f) - 12582912.0f;  // to the nearest integer, ties to even
}

// The gradient of the fragments per pixel of Gaussians by the log-scales: overdraw.py. It is 0 where
// `view` could not show a Gaussian if it were opaque.
template <class V>
MGS_FN void overdraw_gradient(const View& view, const V* mean, const V* q, const V* log_scale, V logit,
                      float alpha_min, float level_sigma, V* gradient) {
  const V zero = of<V>(0), one = of<V>(1), tiny = of<V>(1.17549435e-38f);
  const float black[3 * LANES] = {0};
  float means[3 * LANES], quats[4 * LANES], scales[3 * LANES], opaque[LANES];
  V m[9], offset[3], scale[3], u[3], squares[3], sum = zero, half = zero;
  for (int a = 0; a < 3; a++) scale[a] = exp_of(log_scale[a]);
  for (int a = 0; a < 3; a++) set_number(means, a, mean[a]), set_number(scales, a, scale[a]);
  for (int a = 0; a < 4; a++) set_number(quats, a, q[a]);
  set_number(opaque, 0, one);
  View plain = view;  // without harmonics
  plain.sh_size = plain.lobe_size = 0;
  Projected<V> s;
  auto shown = project(plain, means, quats, scales, opaque, black, black, nullptr, s);
  V opacity = 1.0f / (1.0f + exp_of(-logit));
  V check = logit + log_scale[0] + log_scale[1] + log_scale[2];  // exp_of limits its argument
  shown = shown & (opacity > alpha_min) & (check - check == 0.0f);
  for (int a = 0; a < 3; a++) gradient[a] = zero;
  if (!any_of(shown)) return;
  rotation_of(q, 1.0f / sqrt_of(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), m);
  for (int a = 0; a < 3; a++) offset[a] = mean[a] - view.position[a];
  V length = sqrt_of(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
  V distance = max_of(length, of<V>(view.near_plane));
  V focal = view.focal[0] * view.focal[1] / (distance * distance);
  for (int a = 0; a < 3; a++) {
    u[a] = (offset[0] * m[a] + offset[1] * m[3 + a] + offset[2] * m[6 + a]) / distance;
    V f = u[a] * scale[(a + 1) % 3] * scale[(a + 2) % 3];
    squares[a] = f * f;
    sum += squares[a];
    half += 0.5f * scale[a] * scale[a] * (1.0f - u[a] * u[a]);  // of the sum of both variances
  }
  const float pi = 3.14159265f, image = (float)view.width * view.height;
  V share = pi / image * 2 / LOG2_E * focal * (log2_of(opacity) - log2_of(of<V>(alpha_min)));
  V area = share * sqrt_of(sum), slope = select(area < 1.0f, area / max_of(sum, tiny), zero);
  area = min_of(area, one);
  for (int a = 0; a < 3; a++) gradient[a] = slope * (sum - squares[a]);
  if (level_sigma > 0) {
    const float lowest = 1.0f / (1 << 2 * (LEVELS - 1));
    V inside = half * half - sum, least = 1e-6f * half * half + tiny;
    V root = sqrt_of(max_of(inside, least)), both = half + root;
    V variance = sum / both * focal + view.blur;
    V free_factor = 3 / 1.3862943611f * level_sigma * level_sigma / variance;
    V factor = clamp(free_factor, of<V>(lowest), one);
    V factor_slope = select((free_factor >= lowest) & (free_factor <= 1.0f), -factor / variance, zero);
    for (int a = 0; a < 3; a++) {
      V sum_slope = 2.0f * (sum - squares[a]);
      V half_slope = scale[a] * scale[a] * (1.0f - u[a] * u[a]);
      V root_slope = select(inside > least, half * half_slope - 0.5f * sum_slope,
                            1e-6f * half * half_slope);
      root_slope = root_slope / root;
      V variance_slope = focal / both * (sum_slope - sum * (half_slope + root_slope) / both);
      gradient[a] = factor * gradient[a] + area * factor_slope * variance_slope;
    }
  }
  for (int a = 0; a < 3; a++) gradient[a] = select(shown, gradient[a], zero);
}

// The squared distance from a column's mean within which values cost almost no bits before
// quantisation. `share` is its root in standard deviations, at least `least`.
MGS_FN float squared_scale(double variance, float share, float least) {
  return square(max_of(share * (float)sqrt(variance), least));
}

// The gradient of the estimated rate by a value, x from the mean of its column.
MGS_FN float early_rate_gradient(float x, float squared_scale, float weight) {
  return weight * x / (x * x + squared_scale);
}

// The gradient of the rate by a value between two codes, from how many values of its column have
// each. `pseudo` is added to both counts.
MGS_FN float rate_gradient(float count, float next, float pseudo, float weight, float step) {
  return weight / step * log2f((count + pseudo) / (next + pseudo));
}

// The axis of a rotation times its angle, in radians: rotation_vectors in representation/rotations.py.
MGS_FN void rotation_vector(const float* q, float* vector) {
  float sign = q[0] < 0 ? -1.0f : 1.0f;
  float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  float share = sign / max_of(length, 1e-12f);
  for (int a = 0; a < 3; a++) vector[a] = q[a + 1] * share;
  float sine = sqrtf(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  float angle = 2 * atan2f(sine, q[0] * share);
  for (int a = 0; a < 3; a++) vector[a] *= angle / max_of(sine, ANGLE_MIN);
}

// The code of an angle without refinement bits, within +-CODE_LIMIT.
MGS_FN int angle_code(float angle, float step) {
  return (int)clamp(floorf(angle / step + 0.5f), (float)-CODE_LIMIT, (float)CODE_LIMIT);
}

// The part of an entropy in bits that `count` of all values with one code have.
MGS_FN double entropy_part(int64 count, int64 all) {
  double share = (double)count / all;
  return count ? -share * log2f((float)share) : 0.0;
}

// The place of the last code up to a value among those from `least` on, at most `last`.
MGS_FN int place_below(float value, float step, int least, int last) {
  return (int)clamp(floorf(value / step) - least, 0.0f, (float)last);
}
