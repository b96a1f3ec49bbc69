// SSIM (Wang et al. 2004) per pixel and channel, and its adjoint, for images [h, w, 3]; 11 x 11
// Gaussian window, sigma 1.5, zero padding. The reference is ssim_map in train/losses.py. Rows are
// blurred as they lie in memory: taps are 3 floats apart.
#include "lanes.h"
#include "parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int RADIUS = 5, TAPS = 2 * RADIUS + 1;
constexpr float C1 = 0.01f * 0.01f, C2 = 0.03f * 0.03f;

struct Window {
  float tap[TAPS];
  Window() {
    double sum = 0, value[TAPS];
    for (int i = 0; i < TAPS; i++) sum += value[i] = std::exp(-(i - RADIUS) * (i - RADIUS) / 4.5);
    for (int i = 0; i < TAPS; i++) tap[i] = (float)(value[i] / sum);
  }
};
const Window window;

// Rows of an image, padded for the window on both sides and for whole vectors at the end.
struct Rows {
  int length, stride;
  explicit Rows(int width)
      : length(3 * width), stride((3 * width + LANES - 1) / LANES * LANES + 6 * RADIUS) {}
};

// Blurs the rows [from, to) of MAPS maps. `fill(y, rows)` writes row y of every map to rows[m],
// which is already offset past the margin; `use(y, rows)` receives the blurred rows. GCC's loops take
// 1.2 times as long if it inlines them.
template <int MAPS, class Fill, class Use>
__attribute__((noinline)) void blur(int height, const Rows& rows, int from, int to, Fill fill, Use use) {
  int first = std::max(0, from - RADIUS), last = std::min(height, to + RADIUS);
  size_t block = (size_t)MAPS * rows.stride;
  std::unique_ptr<float[]> across(new float[block * (last - first)]);
  std::unique_ptr<float[]> raw(new float[block]()), down(new float[block]);
  float* in[MAPS];
  float* out[MAPS];
  for (int m = 0; m < MAPS; m++) {
    in[m] = raw.get() + m * rows.stride + 3 * RADIUS;
    out[m] = down.get() + m * rows.stride;
  }
  for (int y = first; y < last; y++) {
    fill(y, in);
    for (int m = 0; m < MAPS; m++) {
      const float* p = in[m] - 3 * RADIUS;
      float* q = across.get() + block * (y - first) + m * rows.stride;
      for (int i = 0; i < rows.length; i += LANES) {
        vfloat sum = load(p + i) * window.tap[0];
        for (int k = 1; k < TAPS; k++) sum += load(p + i + 3 * k) * window.tap[k];
        store(q + i, sum);
      }
    }
  }
  for (int y = from; y < to; y++) {
    int top = std::max(first, y - RADIUS), bottom = std::min(last - 1, y + RADIUS);
    for (int m = 0; m < MAPS; m++) {
      for (int i = 0; i < rows.length; i += LANES) {
        vfloat sum = {};
        for (int r = top; r <= bottom; r++)
          sum += load(across.get() + block * (r - first) + m * rows.stride + i) *
                 window.tap[r - y + RADIUS];
        store(out[m] + i, sum);
      }
    }
    use(y, out);
  }
}

constexpr int BAND = 48;  // rows of an image at a time; it does not change any sum

struct Score {
  float luminance, contrast, luminance_scale, contrast_scale;
};

MGS_FN Score score_of(float mean_x, float mean_y, float squares, float product) {
  return {2 * mean_x * mean_y + C1, 2 * (product - mean_x * mean_y) + C2,
          mean_x * mean_x + mean_y * mean_y + C1, squares - mean_x * mean_x - mean_y * mean_y + C2};
}

}  // namespace

// Writes SSIM to `score`, [h][3 w], and the four blurred maps to `means`, [h][4][3 w], for the
// backward pass.
EXPORT void mgs_ssim_forward(int height, int width, const float* x, const float* y, float* means,
                             float* score) {
  Rows rows(width);
  parallel_for(height, BAND, [&](int from, int to) {
    blur<4>(
        height, rows, from, to,
        [&](int row, float** in) {
          const float *a = x + (int64)row * rows.length, *b = y + (int64)row * rows.length;
          for (int i = 0; i < rows.length; i++) {
            in[0][i] = a[i], in[1][i] = b[i];
            in[2][i] = a[i] * a[i] + b[i] * b[i], in[3][i] = a[i] * b[i];
          }
        },
        [&](int row, float** out) {
          float* kept = means + (int64)row * 4 * rows.length;
          for (int m = 0; m < 4; m++)
            std::memcpy(kept + m * rows.length, out[m], sizeof(float) * rows.length);
          for (int i = 0; i < rows.length; i++) {
            Score s = score_of(out[0][i], out[1][i], out[2][i], out[3][i]);
            score[(int64)row * rows.length + i] =
                s.luminance * s.contrast / (s.luminance_scale * s.contrast_scale);
          }
        });
  });
}

// Writes dL/dx to `out_grad`, for dL/d score in `grad`.
EXPORT void mgs_ssim_backward(int height, int width, const float* x, const float* y,
                              const float* means, const float* grad, float* out_grad) {
  Rows rows(width);
  parallel_for(height, BAND, [&](int from, int to) {
    blur<3>(
        height, rows, from, to,
        [&](int row, float** in) {
          const float* kept = means + (int64)row * 4 * rows.length;
          const float* g = grad + (int64)row * rows.length;
          for (int i = 0; i < rows.length; i++) {
            float mean_x = kept[i], mean_y = kept[rows.length + i];
            Score s = score_of(mean_x, mean_y, kept[2 * rows.length + i], kept[3 * rows.length + i]);
            float share = g[i] / (s.luminance_scale * s.contrast_scale);
            float value = s.luminance * s.contrast / (s.luminance_scale * s.contrast_scale);
            float product = 2 * share * s.luminance, squares = -g[i] * value / s.contrast_scale;
            in[0][i] = share * 2 * mean_y * s.contrast -
                       g[i] * value * 2 * mean_x / s.luminance_scale - product * mean_y -
                       squares * 2 * mean_x;
            in[1][i] = squares;
            in[2][i] = product;
          }
        },
        [&](int row, float** out) {
          int64 at = (int64)row * rows.length;
          for (int i = 0; i < rows.length; i++)
            out_grad[at + i] = out[0][i] + 2 * x[at + i] * out[1][i] + y[at + i] * out[2][i];
        });
  });
}
