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

// The area of an ellipse as a share of the image, and its gradient by the log-scales: overdraw in
// train/student/overdraw.py.
MGS_FN float area_of(const View& v, const float* mean, const float* q, const float* log_scale,
                     float opacity, float alpha_min, float level_sigma, float* gradient) {
  gradient[0] = gradient[1] = gradient[2] = 0;
  if (!(opacity > alpha_min)) return 0;
  float m[9], offset[3], scale[3], u[3], squares[3], sum = 0, half = 0;
  rotation_of(q, 1 / sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), m);
  for (int a = 0; a < 3; a++) offset[a] = mean[a] - v.position[a], scale[a] = expf(log_scale[a]);
  float length = sqrtf(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]);
  float distance = max_of(length, v.near_plane);
  float focal = v.focal[0] * v.focal[1] / (distance * distance);
  for (int a = 0; a < 3; a++) {
    u[a] = (offset[0] * m[a] + offset[1] * m[3 + a] + offset[2] * m[6 + a]) / distance;
    squares[a] = square(u[a] * scale[(a + 1) % 3] * scale[(a + 2) % 3]);
    sum += squares[a];
    half += 0.5f * scale[a] * scale[a] * (1 - u[a] * u[a]);  // of the sum of both variances
  }
  const float tiny = 1.17549435e-38f, pi = 3.14159265f;
  float share = pi * focal / ((float)v.width * v.height) * 2 * logf(opacity / alpha_min);
  float area = share * sqrtf(sum), slope = area < 1 ? area / max_of(sum, tiny) : 0.0f;
  area = min_of(area, 1.0f);
  float factor = 1, factor_slope = 0, root = 1;
  if (level_sigma > 0) {
    float inside = half * half - sum, least = 1e-6f * half * half + tiny;
    root = sqrtf(max_of(inside, least));
    float variance = sum / (half + root) * focal + v.blur;
    factor = 3 / 1.3862943611f * level_sigma * level_sigma / variance;
    const float lowest = 1.0f / (1 << 2 * (LEVELS - 1));
    if (factor >= lowest && factor <= 1) factor_slope = -factor / variance;
    factor = clamp(factor, lowest, 1.0f);
    for (int a = 0; a < 3 && factor_slope != 0; a++) {
      float sum_slope = 2 * (sum - squares[a]);
      float half_slope = scale[a] * scale[a] * (1 - u[a] * u[a]);
      float root_slope = inside > least ? half * half_slope - 0.5f * sum_slope
                                        : 1e-6f * half * half_slope;
      root_slope /= root;
      float variance_slope =
          focal / (half + root) * (sum_slope - sum * (half_slope + root_slope) / (half + root));
      gradient[a] = area * factor_slope * variance_slope;
    }
  }
  for (int a = 0; a < 3; a++) gradient[a] += factor * slope * (sum - squares[a]);
  return area * factor;
}

// The fragments per pixel of one Gaussian, and their gradient by its log-scales: 0 unless `view`
// could show it if it were opaque.
MGS_FN float fragments_of(const View& view, const float* mean, const float* q,
                          const float* log_scale, float opacity, float alpha_min,
                          float level_sigma, float* gradient) {
  const float black[3] = {0, 0, 0}, opaque = 1;
  float scale[3] = {expf(log_scale[0]), expf(log_scale[1]), expf(log_scale[2])};
  Projected<float> s;
  gradient[0] = gradient[1] = gradient[2] = 0;
  if (!project(view, mean, q, scale, &opaque, black, black, nullptr, s)) return 0;
  return area_of(view, mean, q, log_scale, opacity, alpha_min, level_sigma, gradient);
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
