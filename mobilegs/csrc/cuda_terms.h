// The rate term of a student's loss in CUDA, before and after quantisation. The arithmetic is in terms.h. The host reads nothing. Sums are doubles, added in a
// fixed order. The only atomics count codes: sums of integers do not depend on their order.
#pragma once
#include "cuda_common.h"
#include "student.h"
#include "terms.h"

namespace {

constexpr int PARTS = 128;        // blocks of a tensor, each with every PARTSth group of rows
constexpr int CHUNKS = 32;        // blocks that count the codes of a column
// counts of a column: from two below the least code to two above the largest
constexpr int LEAST = -CODE_LIMIT - 2, PLACES = 2 * CODE_LIMIT + 5;

// A tensor [count][columns] with a rate term; train/student/cuda_terms.py mirrors the fields.
struct RateTensor {
  const float *values, *before;  // before: gradients to which those of the term are added, or null
  float* gradients;
  LearnedStep step;  // nothing before quantisation
  int64 count;
  float weight;
  int columns, first;  // first: columns of the tensors before it
};
struct RateTensors {
  RateTensor tensors[6];
};

// The threads of a block form rows of `columns`. Adds the rows: those of the first get the sums. A
// kernel calls it once for each MANY.
template <int MANY>
MGS_FN void add_rows(int columns, double (&sums)[MANY]) {
  __shared__ double all[MANY][THREADS];
  int row = threadIdx.x / columns;
  for (int m = 0; m < MANY; m++) all[m][threadIdx.x] = sums[m];
  for (int left = THREADS / columns; left > 1; left = (left + 1) / 2) {
    __syncthreads();
    if (row >= left / 2) continue;
    for (int m = 0; m < MANY; m++)
      all[m][threadIdx.x] += all[m][threadIdx.x + (left + 1) / 2 * columns];
  }
  for (int m = 0; m < MANY; m++) sums[m] = all[m][threadIdx.x];
}

// One of PARTS blocks per tensor: calls visit(i) for the block's share of its values. Those of a
// thread are in one column, that of the thread.
template <class Visit>
MGS_FN void for_values(const RateTensor& t, Visit visit) {
  int size = THREADS / t.columns * t.columns;
  if ((int)threadIdx.x >= size) return;
  for (int64 i = (int64)(blockIdx.x % PARTS) * size + threadIdx.x; i < t.count * t.columns;
       i += (int64)PARTS * size)
    visit(i);
}

// Values are added relative to the first of their column: squares of large means would cancel.
MGS_FN float first_of(const RateTensor& t) {
  return t.count ? t.values[threadIdx.x % t.columns] : 0.0f;
}

// Write a block's sums of each column, and read those of all blocks, for the first row of threads.
template <int MANY>
MGS_FN void write_sums(const RateTensor& t, double (&sums)[MANY], double* parts) {
  add_rows(t.columns, sums);
  if ((int)threadIdx.x >= t.columns) return;
  int64 at = (int64)(t.first + threadIdx.x) * PARTS + blockIdx.x % PARTS;
  for (int m = 0; m < MANY; m++) parts[at * MANY + m] = sums[m];
}
template <int MANY>
MGS_FN void read_sums(const RateTensor& t, const double* parts, double (&sums)[MANY]) {
  int rows = THREADS / t.columns, row = threadIdx.x / t.columns;
  int64 first = (int64)(t.first + threadIdx.x % t.columns) * PARTS;
  for (int m = 0; m < MANY; m++) sums[m] = 0;
  for (int part = row; row < rows && part < PARTS; part += rows)
    for (int m = 0; m < MANY; m++) sums[m] += parts[(first + part) * MANY + m];
  add_rows(t.columns, sums);
}

MGS_FN void add_gradient(const RateTensor& t, int64 i, float gradient) {
  t.gradients[i] = (t.before ? t.before[i] : 0.0f) + gradient;
}

MGS_FN void add_count(int* count, int many) { atomicAdd(count, many); }

}  // namespace

// PARTS blocks per tensor: sums of values and of their squares.
KERNEL(THREADS, 4)
mgs_early_rate_sums(PARAM RateTensors in, double* parts) {
  const RateTensor& t = in.tensors[blockIdx.x / PARTS];
  float first = first_of(t);
  double sums[2] = {0, 0};
  for_values(t, [&](int64 i) {
    float x = t.values[i] - first;
    sums[0] += x, sums[1] += square(x);
  });
  write_sums(t, sums, parts);
}

// PARTS blocks per tensor. Each finds mean and scale of the columns, then gradients of its share.
KERNEL(THREADS, 4)
mgs_early_rate(PARAM RateTensors in, const double* parts, float share, float least) {
  __shared__ float means[THREADS], scales[THREADS];
  const RateTensor& t = in.tensors[blockIdx.x / PARTS];
  double sums[2];
  read_sums(t, parts, sums);
  if ((int)threadIdx.x < t.columns) {
    double mean = sums[0] / t.count, variance = sums[1] / t.count - mean * mean;
    means[threadIdx.x] = (float)(first_of(t) + mean);
    scales[threadIdx.x] = squared_scale(variance > 0 ? variance : 0, share, least);
  }
  __syncthreads();
  float mean = means[threadIdx.x % t.columns], scale = scales[threadIdx.x % t.columns];
  for_values(t, [&](int64 i) {
    add_gradient(t, i, early_rate_gradient(t.values[i] - mean, scale, t.weight));
  });
}

// CHUNKS blocks per column of all tensors. Adds the number of values of each code to `table`,
// [columns][PLACES].
KERNEL(THREADS, 4)
mgs_count_codes(PARAM RateTensors in, int columns, int* table) {
  __shared__ int counts[PLACES];
  int column = blockIdx.x % columns;
  const RateTensor* t = in.tensors;
  while (column >= t->first + t->columns) t++;
  float step = step_of(t->step);
  for (int k = threadIdx.x; k < PLACES; k += THREADS) counts[k] = 0;
  __syncthreads();
  for (int64 i = (int64)(blockIdx.x / columns) * THREADS + threadIdx.x; i < t->count;
       i += CHUNKS * THREADS) {
    float code = nearest_code(t->values[i * t->columns + column - t->first] / step);
    add_count(counts + (int)code - LEAST, 1);
  }
  __syncthreads();
  for (int k = threadIdx.x; k < PLACES; k += THREADS)
    if (counts[k]) add_count(table + (int64)column * PLACES + k, counts[k]);
}

// PARTS blocks per tensor: gradients, and sums of values, of gradients and of their products.
KERNEL(THREADS, 4)
mgs_rate(PARAM RateTensors in, const int* table, float pseudo, double* parts) {
  const RateTensor& t = in.tensors[blockIdx.x / PARTS];
  const int* counts = table + (int64)(t.first + threadIdx.x % t.columns) * PLACES;
  float step = step_of(t.step), first = first_of(t);
  double sums[3] = {0, 0, 0};
  for_values(t, [&](int64 i) {
    float x = t.values[i];
    int k = place_below(x, step, LEAST, PLACES - 2);
    float gradient = rate_gradient(counts[k], counts[k + 1], pseudo, t.weight, step);
    add_gradient(t, i, gradient);
    x -= first;
    sums[0] += x, sums[1] += gradient, sums[2] += gradient * x;
  });
  write_sums(t, sums, parts);
}

// One block per tensor: the gradient of the logarithm of its step size. A larger one moves codes
// together, as if values moved towards their mean.
KERNEL(THREADS, 4)
mgs_rate_total(PARAM RateTensors in, const double* parts, float* gradients) {
  const RateTensor& t = in.tensors[blockIdx.x];
  double sums[3], total[1] = {0};
  read_sums(t, parts, sums);
  if ((int)threadIdx.x < t.columns) total[0] = sums[0] / t.count * sums[1] - sums[2];
  add_rows(1, total);
  if (threadIdx.x == 0) gradients[blockIdx.x] = (float)total[0];
}

// CHUNKS blocks for each of three angles at a step size smaller by `ratio`, then at one as much
// larger. Adds the number of rotations of each code to `table`, [6][PLACES].
KERNEL(THREADS, 4)
mgs_count_angles(const float* quats, int64 count, PARAM LearnedStep step, float ratio, int* table) {
  __shared__ int counts[PLACES];
  int column = blockIdx.x % 6;
  float size = column < 3 ? step_of(step) / ratio : step_of(step) * ratio;
  for (int k = threadIdx.x; k < PLACES; k += THREADS) counts[k] = 0;
  __syncthreads();
  for (int64 i = (int64)(blockIdx.x / 6) * THREADS + threadIdx.x; i < count; i += CHUNKS * THREADS) {
    float vector[3];
    rotation_vector(quats + 4 * i, vector);
    // an index would put the vector into local memory
    float angle = column % 3 == 0 ? vector[0] : column % 3 == 1 ? vector[1] : vector[2];
    add_count(counts + angle_code(angle, size) - LEAST, 1);
  }
  __syncthreads();
  for (int k = threadIdx.x; k < PLACES; k += THREADS)
    if (counts[k]) add_count(table + (int64)column * PLACES + k, counts[k]);
}

// One block: `weight` times the bits by which a rotation's angles differ between the step sizes.
KERNEL(THREADS, 4)
mgs_angle_bits(int64 count, float weight, const int* table, float* bits) {
  double sum[1] = {0};
  for (int k = threadIdx.x; k < 6 * PLACES; k += THREADS)
    sum[0] += (k < 3 * PLACES ? -1 : 1) * entropy_part(table[k], count);
  add_rows(1, sum);
  if (threadIdx.x == 0) *bits = (float)(weight * sum[0]);
}
