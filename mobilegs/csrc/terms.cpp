// The gradients of a student's rate term, before and after quantisation. Sums add blocks of rows in
// order: they do not depend on the number of threads.
#include "parallel.h"
#include "terms.h"

#include <cmath>
#include <vector>

#define EXPORT extern "C" __attribute__((visibility("default")))

static constexpr int BLOCK = 512;  // rows

// Returns sum over [0, blocks) of part(block), which several threads compute.
template <class Part>
static double sum_of_blocks(int64 blocks, Part part) {
  std::vector<double> parts(blocks);
  parallel_for(blocks, 1, [&](int64 first, int64 end) {
    for (int64 block = first; block < end; block++) parts[block] = part(block);
  });
  double sum = 0;
  for (double each : parts) sum += each;
  return sum;
}

// Sums of term(value, column) over the rows of values[count][columns].
template <class Term>
static std::vector<double> column_sums(int64 count, int columns, const float* values, Term term) {
  int64 blocks = (count + BLOCK - 1) / BLOCK;
  std::vector<double> parts((size_t)blocks * columns, 0.0), sums(columns, 0.0);
  parallel_for(blocks, 4, [&](int64 first, int64 end) {
    for (int64 block = first; block < end; block++) {
      double* part = &parts[(size_t)block * columns];
      for (int64 i = block * BLOCK; i < std::min(count, (block + 1) * BLOCK); i++)
        for (int c = 0; c < columns; c++) part[c] += term(values[i * columns + c], c);
    }
  });
  for (int64 block = 0; block < blocks; block++)
    for (int c = 0; c < columns; c++) sums[c] += parts[(size_t)block * columns + c];
  return sums;
}

// Adds the gradients of the estimated rate term to `gradients`, [count][columns]:
// add_early_rate_gradients in train/student/quantization.py. `share` is the scale in standard
// deviations.
EXPORT void mgs_early_rate(int64_t count, int columns, const float* values, float weight,
                           float share, float least, float* gradients) {
  std::vector<float> means(columns), scales(columns);
  std::vector<double> sums =
      column_sums(count, columns, values, [](float x, int) { return (double)x; });
  for (int c = 0; c < columns; c++) means[c] = (float)(sums[c] / count);
  sums = column_sums(count, columns, values,
                     [&](float x, int c) { return (double)square(x - means[c]); });
  for (int c = 0; c < columns; c++) scales[c] = squared_scale(sums[c] / count, share, least);
  parallel_for(count, 4 * BLOCK, [&](int64 first, int64 end) {
    for (int64 i = first; i < end; i++)
      for (int c = 0; c < columns; c++) {
        float x = values[i * columns + c] - means[c];
        gradients[i * columns + c] += early_rate_gradient(x, scales[c], weight);
      }
  });
}

// Returns the bits of a rotation's angles with a step size larger by `ratio`, less those with one as
// much smaller: log_step_gradient in representation/uniform_quantizer.py.
EXPORT double mgs_angle_bits(int64_t count, const float* quats, float step, float ratio) {
  std::vector<int16_t> codes((size_t)count * 6);
  parallel_for(count, BLOCK, [&](int64 first, int64 end) {
    for (int64 i = first; i < end; i++) {
      float vector[3];
      rotation_vector(quats + 4 * i, vector);
      for (int k = 0; k < 6; k++)
        codes[k * count + i] = angle_code(vector[k % 3], k < 3 ? step / ratio : step * ratio);
    }
  });
  double bits[6] = {0};
  parallel_for(6, 1, [&](int64 first, int64 end) {
    for (int64 k = first; k < end; k++) {
      std::vector<int> counts(2 * CODE_LIMIT + 1, 0);
      for (int64 i = 0; i < count; i++) counts[codes[k * count + i] + CODE_LIMIT]++;
      for (int each : counts) bits[k] += entropy_part(each, count);
    }
  });
  return bits[3] + bits[4] + bits[5] - bits[0] - bits[1] - bits[2];
}

// Adds the gradients of the rate term of uniform codes to `gradients`, [count][columns], and returns
// that of the logarithm of the step size: add_rate_gradients in train/student/quantization.py.
// `pseudo` is added to the count of every code of a column.
EXPORT double mgs_rate(int64_t count, int columns, const float* values, float step, float weight,
                       float pseudo, float* gradients) {
  constexpr int LEAST = -CODE_LIMIT - 2, PLACES = 2 * CODE_LIMIT + 5;  // two more on each side
  std::vector<std::vector<float>> slopes(columns);  // of a code's length up to the next one
  parallel_for(columns, 1, [&](int64 first, int64 end) {
    std::vector<int> counts(PLACES);
    for (int64 c = first; c < end; c++) {
      std::fill(counts.begin(), counts.end(), 0);
      for (int64 i = 0; i < count; i++)
        counts[(int)nearest_code(values[i * columns + c] / step) - LEAST]++;
      slopes[c].reserve(PLACES - 1);
      for (int k = 0; k + 1 < PLACES; k++)
        slopes[c].push_back(rate_gradient(counts[k], counts[k + 1], pseudo, weight, step));
    }
  });
  std::vector<double> means =
      column_sums(count, columns, values, [](float x, int) { return (double)x; });
  return -sum_of_blocks((count + BLOCK - 1) / BLOCK, [&](int64 block) {
    double sum = 0;
    for (int64 i = block * BLOCK; i < std::min(count, (block + 1) * BLOCK); i++)
      for (int c = 0; c < columns; c++) {
        float x = values[i * columns + c];
        float gradient = slopes[c][place_below(x, step, LEAST, PLACES - 2)];
        gradients[i * columns + c] += gradient;
        // a larger step size moves codes together, as if values moved towards their mean
        sum += gradient * (x - (float)(means[c] / count));
      }
    return sum;
  });
}
