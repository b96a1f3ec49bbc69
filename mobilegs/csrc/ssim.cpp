// The loss against a photo, of L1 and SSIM (Wang et al. 2004), and its gradient, for images
// [h, w, 3]; SSIM's window is a Gaussian of 11 x 11, sigma 1.5, zero padding. The reference is
// photo_loss in train/losses.py. Rows are blurred as they lie in memory: taps are 3 floats apart.
#include "parallel.h"
#include "photo_loss.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int DOWN = 4;  // rows that are blurred downwards together: a load serves all of them

struct Window {
  float padded[TAPS + 2 * (DOWN - 1)] = {};  // with zeros
  float* tap = padded + DOWN - 1;
  Window() {
    for (int i = 0; i < TAPS; i++) tap[i] = window_tap(i);
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
__attribute__((noinline)) void blur(int height, const Rows& rows, int from, int to, Fill fill,
                                    Use use) {
  int first = std::max(0, from - RADIUS), last = std::min(height, to + RADIUS);
  size_t block = (size_t)MAPS * rows.stride;
  std::unique_ptr<float[]> across(new float[block * (last - first)]);
  std::unique_ptr<float[]> raw(new float[block]()), down(new float[DOWN * block]);
  float* in[MAPS];
  float* out[MAPS];
  for (int m = 0; m < MAPS; m++) in[m] = raw.get() + m * rows.stride + 3 * RADIUS;
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
  for (int y = from; y < to; y += DOWN) {
    int top = std::max(first, y - RADIUS), bottom = std::min(last - 1, y + DOWN - 1 + RADIUS);
    for (int m = 0; m < MAPS; m++) {
      const float* p = across.get() + block * (top - first) + m * rows.stride;
      float* q = down.get() + m * rows.stride;
      for (int i = 0; i < rows.length; i += LANES) {
        vfloat sums[DOWN] = {};
        for (int r = top; r <= bottom; r++) {
          vfloat row = load(p + block * (r - top) + i);
          const float* tap = window.tap + r - y + RADIUS;
          for (int k = 0; k < DOWN; k++) sums[k] += row * tap[-k];
        }
        for (int k = 0; k < DOWN; k++) store(q + k * block + i, sums[k]);
      }
    }
    for (int k = 0; k < std::min(DOWN, to - y); k++) {
      for (int m = 0; m < MAPS; m++) out[m] = down.get() + k * block + m * rows.stride;
      use(y + k, out);
    }
  }
}

constexpr int BAND = 48;  // rows of an image at a time; it does not change any sum

// add_terms for the numbers at `i`, of one or of LANES of them; keeps what the gradient of SSIM
// needs. a, b: the rows of x and y; m: weights; blurred: the moments.
template <class V>
MGS_FN void add_terms_at(int i, const float* a, const float* b, const float* m, float** blurred,
                         float share, float* kept, int length, Terms<V>& terms) {
  auto at = [i](const float* p) { return load_as(p + i, V{}); };
  Moments<V> of = {at(blurred[0]), at(blurred[1]), at(blurred[2]), at(blurred[3])};
  MomentGradients<V> to = add_terms(at(a), at(b), at(m), of, share, terms);
  store(kept + i, to.mean);
  store(kept + length + i, to.squares), store(kept + 2 * length + i, to.product);
}

// Sets the gradient of the numbers at `i`, from the blurred maps of what add_terms_at kept.
template <class V>
MGS_FN void set_gradient(int i, const float* a, const float* b, const float* m, float** blurred,
                         float share, float* gradient) {
  auto at = [i](const float* p) { return load_as(p + i, V{}); };
  MomentGradients<V> of = {at(blurred[0]), at(blurred[1]), at(blurred[2])};
  store(gradient + i, photo_gradient(at(a), at(b), at(m), of, share));
}

}  // namespace

// Returns l1 sum m |x - y| + dissimilarity sum m (1 - SSIM) over pixels and channels, and writes its
// gradient by x, [h][w][3], and to `squared` sum m (x - y)^2. The weight m of a pixel is that of
// `mask`, or 1 if it is null; where it is 0, the window sees y in place of x. `scratch` has room for
// three images.
EXPORT double mgs_photo_loss(int height, int width, const float* x, const float* y,
                             const float* mask, float l1, float dissimilarity, float* scratch,
                             float* gradient, double* squared) {
  Rows rows(width);
  int length = rows.length;
  std::unique_ptr<double[]> sums(new double[2 * std::max(1, height)]);
  // weights of numbers, row by row; without a mask one row of ones
  std::vector<float> weights((size_t)length * (mask ? height : 1), 1.0f);
  if (mask)
    for (int64 i = 0; i < (int64)height * width; i++)
      std::fill_n(&weights[3 * i], 3, mask[i]);
  auto weights_of = [&](int row) { return weights.data() + (mask ? (int64)row * length : 0); };
  parallel_for(height, BAND, [&](int from, int to) {
    blur<4>(
        height, rows, from, to,
        [&](int row, float** in) {
          const float *a = x + (int64)row * length, *b = y + (int64)row * length;
          const float* m = weights_of(row);
          float *c = in[0], *d = in[1], *squares = in[2], *product = in[3];
          for (int i = 0; i < length; i++) c[i] = m[i] > 0 ? a[i] : b[i], d[i] = b[i];
          for (int i = 0; i < length; i++) squares[i] = c[i] * c[i] + d[i] * d[i];
          for (int i = 0; i < length; i++) product[i] = c[i] * d[i];
        },
        [&](int row, float** out) {
          const float *a = x + (int64)row * length, *b = y + (int64)row * length;
          const float* m = weights_of(row);
          float* kept = scratch + (int64)row * 3 * length;
          Terms<vfloat> terms = {};
          Terms<float> rest = {};
          int i = 0;
          for (; i + LANES <= length; i += LANES)
            add_terms_at(i, a, b, m, out, dissimilarity, kept, length, terms);
          for (; i < length; i++)
            add_terms_at(i, a, b, m, out, dissimilarity, kept, length, rest);
          sums[2 * row] = (double)l1 * (sum_of(terms.absolute) + rest.absolute) +
                          (double)dissimilarity * (sum_of(terms.unlike) + rest.unlike);
          sums[2 * row + 1] = sum_of(terms.squared) + rest.squared;
        });
  });
  parallel_for(height, BAND, [&](int from, int to) {
    blur<3>(
        height, rows, from, to,
        [&](int row, float** in) {
          const float* kept = scratch + (int64)row * 3 * length;
          for (int m = 0; m < 3; m++)
            std::memcpy(in[m], kept + m * length, sizeof(float) * length);
        },
        [&](int row, float** out) {
          int64 at = (int64)row * length;
          const float* m = weights_of(row);
          int i = 0;
          for (; i + LANES <= length; i += LANES)
            set_gradient<vfloat>(i, x + at, y + at, m, out, l1, gradient + at);
          for (; i < length; i++)
            set_gradient<float>(i, x + at, y + at, m, out, l1, gradient + at);
        });
  });
  double loss = 0;
  *squared = 0;
  for (int row = 0; row < height; row++) loss += sums[2 * row], *squared += sums[2 * row + 1];
  return loss;
}
