// Terms of a student's loss that need no image, with their gradients: overdraw, and the rate before
// and after quantisation. Sums add blocks of rows in order: they do not depend on the number of
// threads.
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

// Returns the fragments per pixel of a view, and writes their gradient by log_scales, [m][3]. Only
// Gaussians count that `view` could show if they were opaque.
EXPORT double mgs_overdraw(const View* view, int64_t m, const float* means, const float* quats,
                           const float* log_scales, const float* opacities, float alpha_min,
                           float level_sigma, float* gradients) {
  return sum_of_blocks((m + BLOCK - 1) / BLOCK, [&](int64 block) {
    double sum = 0;
    for (int64 i = block * BLOCK; i < std::min(m, (block + 1) * BLOCK); i++)
      sum += fragments_of(*view, means + 3 * i, quats + 4 * i, log_scales + 3 * i, opacities[i],
                          alpha_min, level_sigma, gradients + 3 * i);
    return sum;
  });
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

// Adds the gradients of the rate term of uniform codes to `gradients`, [count][columns], and returns
// that of the logarithm of the step size: add_rate_gradients in train/student/quantization.py.
// Codes lie in [-limit, limit]; `pseudo` is added to the count of every code of a column.
EXPORT double mgs_rate(int64_t count, int columns, const float* values, const int32_t* codes,
                       int limit, float step, float weight, float pseudo, float* gradients) {
  struct Lengths {
    int least;
    std::vector<float> slopes;  // of a code's length up to the next one
  };
  std::vector<Lengths> lengths(columns);
  parallel_for(columns, 1, [&](int64 first, int64 end) {
    for (int64 c = first; c < end; c++) {
      // the code of a value that is not a number may be any integer
      auto code_of = [&](int64 i) { return std::clamp(codes[i * columns + c], -limit, limit); };
      int low = limit, high = -limit;
      for (int64 i = 0; i < count; i++)
        low = std::min(low, code_of(i)), high = std::max(high, code_of(i));
      low -= 2, high += 2;
      std::vector<int64> counts(high - low + 1, 0);
      for (int64 i = 0; i < count; i++) counts[code_of(i) - low]++;
      lengths[c].least = low;
      for (size_t k = 0; k + 1 < counts.size(); k++)
        lengths[c].slopes.push_back(
            rate_gradient(counts[k], counts[k + 1], pseudo, weight, step));
    }
  });
  std::vector<double> means =
      column_sums(count, columns, values, [](float x, int) { return (double)x; });
  return -sum_of_blocks((count + BLOCK - 1) / BLOCK, [&](int64 block) {
    double sum = 0;
    for (int64 i = block * BLOCK; i < std::min(count, (block + 1) * BLOCK); i++)
      for (int c = 0; c < columns; c++) {
        const Lengths& own = lengths[c];
        float x = values[i * columns + c];
        int at = place_below(x, step, own.least, (int)own.slopes.size() - 1);
        float gradient = own.slopes[at];
        gradients[i * columns + c] += gradient;
        // a larger step size moves codes together, as if values moved towards their mean
        sum += gradient * (x - (float)(means[c] / count));
      }
    return sum;
  });
}
