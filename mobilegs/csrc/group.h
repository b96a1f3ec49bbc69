// Layers of small networks for a group of Gaussians, one per SIMD lane, or for one in a CUDA thread:
// networks.cpp decodes files, student.h trains. A group stays in the cache; results do not depend on
// threads or neighbours.
#pragma once
#include "lanes.h"

#ifndef MGS_CUDA
#include <algorithm>
#include <cmath>
#endif

namespace {

#ifdef MGS_CUDA
constexpr int GROUP = 1, SPAN = 1;
#else
constexpr int GROUP = 64;                  // Gaussians
constexpr int SPAN = LANES == 16 ? 4 : 2;  // vectors per unit whose sums stay in registers
#endif
constexpr int ROWS = 4;  // units at a time
// static_inputs of render/view_network.py: harmonics of degree 0 and 1, scales, quaternion
constexpr int COLOR = 12, SCALES = 3, TURNS = 4, STATICS = COLOR + SCALES + TURNS;
constexpr float LENGTH_MIN = 1e-12f;

using Column = float[GROUP];  // one number per Gaussian of a group

MGS_FN void clear(Column* rows, int width, int from) {
  for (int c = 0; c < width; c++)
    for (int i = from; i < GROUP; i++) rows[c][i] = 0;
}

MGS_FN void copy(const Column* from, int width, Column* to) {
  for (int c = 0; c < width; c++)
    for (int i = 0; i < GROUP; i++) to[c][i] = from[c][i];
}

// Transpose rows [from, from + many) of a matrix, columns [0, width), into a group, and back. The
// rest of the group is zeros.
MGS_CALL void load_group(const float* matrix, int64 stride, int64 from, int many, int width,
                         Column* rows) {
  auto row_of = [=](int i) { return matrix + (from + i) * stride; };
  rows_to_lanes(row_of, width, many, rows[0], GROUP);
  clear(rows, width, many);
}
MGS_CALL void store_group(const Column* rows, int64 stride, int64 from, int many, int width,
                          float* matrix) {
  auto row_of = [=](int i) { return matrix + (from + i) * stride; };
  lanes_to_rows(rows[0], GROUP, width, many, row_of);
}

enum Activation { IDENTITY, RELU, LEAKY };

template <Activation ACTIVATION>
MGS_FN vfloat activate(vfloat x) {
  if constexpr (ACTIVATION == RELU) return max_of(x, vfloat{});
  if constexpr (ACTIVATION == LEAKY) return max_of(x, 0.01f * x);
  return x;
}

// The activation of offset + weights . input for the units [row, row + MANY) of a layer.
template <int MANY, Activation ACTIVATION>
MGS_CALL void some_units(const float* weights, const float* offsets, int columns, int row,
                         const Column* in, Column* out) {
  const float* weight = weights + (int64)row * columns;
  for (int at = 0; at < GROUP; at += SPAN * LANES) {
    vfloat sums[MANY][SPAN];
    for (int r = 0; r < MANY; r++)
      for (int s = 0; s < SPAN; s++)
        sums[r][s] = splat_value(vfloat{}, offsets ? offsets[row + r] : 0.0f);
    for (int c = 0; c < columns; c++) {
      vfloat x[SPAN];
      for (int s = 0; s < SPAN; s++) x[s] = load(&in[c][at + s * LANES]);
      for (int r = 0; r < MANY; r++)
        for (int s = 0; s < SPAN; s++) sums[r][s] += x[s] * weight[r * columns + c];
    }
    for (int r = 0; r < MANY; r++)
      for (int s = 0; s < SPAN; s++)
        store(&out[row + r][at + s * LANES], activate<ACTIVATION>(sums[r][s]));
  }
}

template <Activation ACTIVATION>
MGS_CALL void layer(const float* weights, const float* offsets, int rows, int columns,
                    const Column* in, Column* out) {
  int row = 0;
  for (; row + ROWS <= rows; row += ROWS)
    some_units<ROWS, ACTIVATION>(weights, offsets, columns, row, in, out);
  for (; row < rows; row++) some_units<1, ACTIVATION>(weights, offsets, columns, row, in, out);
}

// Divides rows by their common length, like torch's `normalize`.
MGS_CALL void normalise(Column* rows, int many) {
  for (int at = 0; at < GROUP; at += LANES) {
    vfloat square = {};
    for (int r = 0; r < many; r++) square += load(&rows[r][at]) * load(&rows[r][at]);
    vfloat length = sqrt_of(square);
    length = max_of(length, splat_value(length, LENGTH_MIN));
    for (int r = 0; r < many; r++) store(&rows[r][at], load(&rows[r][at]) / length);
  }
}

}  // namespace
