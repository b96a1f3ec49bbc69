// Losses of images in CUDA, launched by train/cuda_losses.py; the reference is train/losses.py. The
// sums of a loss stay on the GPU: a first kernel writes those of each block, a second one adds them
// and divides, and the kernel of the gradient reads what that left.
#pragma once
#include "cuda_common.h"
#include "photo_loss.h"

namespace {

// Writes the sums of a block's threads, added in the order of its warps.
template <int N>
MGS_FN void write_block_sums(const float (&mine)[N], float* sums) {
  __shared__ float parts[N][THREADS / WARP];
  UNROLL
  for (int k = 0; k < N; k++) {
    float part = sum_of_lanes(mine[k]);
    if (lane_of_thread() == 0) parts[k][warp_of_thread()] = part;
  }
  __syncthreads();
  if (threadIdx.x >= N) return;
  float sum = 0;
  for (int w = 0; w < (int)blockDim.x / WARP; w++) sum += parts[threadIdx.x][w];
  sums[N * (int64)blockIdx.x + threadIdx.x] = sum;
}

// Adds the sums of all blocks, in one block; its first thread gets the totals.
template <int N>
MGS_FN void add_blocks(const float* sums, int blocks, double (&totals)[N]) {
  __shared__ double parts[N][THREADS];
  int me = threadIdx.x;
  for (int k = 0; k < N; k++) {
    double sum = 0;
    for (int64 b = me; b < blocks; b += THREADS) sum += sums[N * b + k];
    parts[k][me] = sum;
  }
  for (int half = THREADS / 2; half; half /= 2) {
    __syncthreads();
    if (me < half)
      for (int k = 0; k < N; k++) parts[k][me] += parts[k][me + half];
  }
  for (int k = 0; k < N; k++) totals[k] = parts[k][0];
}

// ---------------------------------------------------------------- the loss against a photo
// A block has TILE x TILE pixels: TILE rows of LINE numbers, as they lie in memory, so taps are 3
// numbers apart. A thread blurs RUN numbers together, which follow each other in the direction of
// the window and share what they read.
constexpr int LINE = 3 * TILE, RUN = 4, LOSS_THREADS = LINE * TILE / RUN;
constexpr int TALL = TILE + 2 * RADIUS;
constexpr int WIDE = LINE + 6 * RADIUS + 2;  // with 2 unused, against conflicts of banks

struct LossTile {
  int top, left, height, length;  // of the block and of the image, in rows and numbers
};

MGS_FN LossTile loss_tile(int height, int width) {
  int across = (width + TILE - 1) / TILE;
  return {(int)blockIdx.x / across * TILE, (int)blockIdx.x % across * LINE, height, 3 * width};
}

// Calls use(row, column, place) for the numbers of the tile and of its margin. `place` is that in
// the image, or -1 outside.
template <class Use>
MGS_FN void for_margin(const LossTile& tile, Use use) {
  for (int k = threadIdx.x; k < TALL * WIDE; k += LOSS_THREADS) {
    int row = k / WIDE, column = k % WIDE;
    int y = tile.top + row - RADIUS, i = tile.left + column - 3 * RADIUS;
    bool inside = y >= 0 && y < tile.height && i >= 0 && i < tile.length;
    use(row, column, inside ? (int64)y * tile.length + i : -1);
  }
}

// Adds a window's share of the numbers that read(i, values) sets, to RUN sums one after the other.
template <int MAPS, class Read>
MGS_FN void blur_run(float (&sums)[RUN][MAPS], Read read) {
  UNROLL
  for (int i = 0; i < TAPS + RUN - 1; i++) {
    float values[MAPS];
    read(i, values);
    UNROLL
    for (int j = 0; j < RUN; j++) {
      if (i < j || i - j >= TAPS) continue;
      UNROLL
      for (int m = 0; m < MAPS; m++) sums[j][m] += window_tap(i - j) * values[m];
    }
  }
}

// Blurs MAPS maps, whose numbers read(row, column, values) sets for the places of for_margin. Calls
// use(row, column, place, blurred) for the tile's numbers inside the image.
template <int MAPS, class Read, class Use>
MGS_FN void blur_tile(const LossTile& tile, Read read, Use use) {
  __shared__ float across[MAPS][TALL][LINE];
  __syncthreads();  // all threads have written what `read` reads
  for (int k = threadIdx.x; k < TALL * LINE / RUN; k += LOSS_THREADS) {
    int row = k / (LINE / RUN), run = k % (LINE / RUN), first = run / 3 * 3 * RUN + run % 3;
    float sums[RUN][MAPS] = {};
    blur_run(sums, [&](int i, float* values) { read(row, first + 3 * i, values); });
    UNROLL
    for (int j = 0; j < RUN; j++)
      for (int m = 0; m < MAPS; m++) across[m][row][first + 3 * j] = sums[j][m];
  }
  __syncthreads();
  int column = threadIdx.x % LINE, top = threadIdx.x / LINE * RUN;
  float sums[RUN][MAPS] = {};
  blur_run(sums, [&](int i, float* values) {
    for (int m = 0; m < MAPS; m++) values[m] = across[m][top + i][column];
  });
  UNROLL
  for (int j = 0; j < RUN; j++) {
    int y = tile.top + top + j, i = tile.left + column;
    if (y < tile.height && i < tile.length)
      use(top + j + RADIUS, column + 3 * RADIUS, (int64)y * tile.length + i, sums[j]);
  }
}

MGS_FN float weight_at(const float* mask, int64 place) { return mask ? mask[place / 3] : 1.0f; }

}  // namespace

// Writes a block's sums of m |x - y|, m (1 - SSIM), m (x - y)^2 and m, and to the three `maps` the
// gradient of `dissimilarity` times the second by the moments. The weight m of a pixel is that of
// `mask`, or 1 if it is null; where it is 0, the window sees y in place of x.
KERNEL(LOSS_THREADS, 5)
mgs_photo_terms(int height, int width, const float* x, const float* y, const float* mask,
                float dissimilarity, float* maps, float* block_sums) {
  __shared__ float image[TALL][WIDE], photo[TALL][WIDE];
  LossTile tile = loss_tile(height, width);
  int64 count = (int64)height * tile.length;
  for_margin(tile, [&](int row, int column, int64 place) {
    float b = place < 0 ? 0.0f : y[place];
    photo[row][column] = b;
    image[row][column] = place >= 0 && weight_at(mask, place) > 0 ? x[place] : b;
  });
  Terms<float> terms = {};
  float weights = 0;
  blur_tile<4>(
      tile,
      [&](int row, int column, float* v) {
        float a = image[row][column], b = photo[row][column];
        v[0] = a, v[1] = b, v[2] = a * a + b * b, v[3] = a * b;
      },
      [&](int row, int column, int64 place, const float* v) {
        float weight = weight_at(mask, place);
        MomentGradients<float> to = add_terms(image[row][column], photo[row][column], weight,
                                              {v[0], v[1], v[2], v[3]}, dissimilarity, terms);
        maps[place] = to.mean;
        maps[count + place] = to.squares, maps[2 * count + place] = to.product;
        weights += weight;
      });
  write_block_sums<4>({terms.absolute, terms.unlike, terms.squared, weights}, block_sums);
}

// One block. Writes the loss and the mean squared difference, which is NaN where no pixel counts,
// and the share of a number's terms in the loss.
KERNEL(THREADS, 1)
mgs_photo_finish(int blocks, float l1, float dissimilarity, const float* block_sums, float* loss,
                 float* error, float* share) {
  double totals[4];
  add_blocks(block_sums, blocks, totals);
  if (threadIdx.x) return;
  double count = totals[3] > 1 ? totals[3] : 1;
  *loss = (float)((l1 * totals[0] + dissimilarity * totals[1]) / count);
  *error = (float)(totals[2] / totals[3]);
  *share = (float)(1 / count);
}

// Writes the gradient of the loss by x, times `grad`.
KERNEL(LOSS_THREADS, 5)
mgs_photo_gradient(int height, int width, const float* x, const float* y, const float* mask,
                   float l1, const float* maps, const float* share, const float* grad,
                   float* gradient) {
  __shared__ float kept[3][TALL][WIDE];
  LossTile tile = loss_tile(height, width);
  int64 count = (int64)height * tile.length;
  float scale = *share * *grad;
  for_margin(tile, [&](int row, int column, int64 place) {
    for (int m = 0; m < 3; m++)
      kept[m][row][column] = place < 0 ? 0.0f : maps[m * count + place];
  });
  blur_tile<3>(
      tile,
      [&](int row, int column, float* v) {
        for (int m = 0; m < 3; m++) v[m] = kept[m][row][column];
      },
      [&](int, int, int64 place, const float* v) {
        float found = photo_gradient(x[place], y[place], weight_at(mask, place),
                                     {v[0], v[1], v[2]}, l1);
        gradient[place] = scale * found;
      });
}

// ---------------------------------------------------------------- distillation
namespace {

// Images and the teacher's, of one or three values per pixel. `mask` is null where all pixels
// count, and the depths and `alpha` where depths do not.
struct Distilled {
  const float *image, *teacher, *depth, *alpha, *teacher_depth, *mask;
};

// For the gradients: shares of a difference of colours and of depths, and the mean of the latter.
struct DistillFactors {
  float color, depth, mean;
};

MGS_FN bool depth_counts(const Distilled& in, int64 i) {
  return in.depth && in.alpha[i] > 0.5f && in.teacher_depth[i] > 0 && in.depth[i] > 0 &&
         (!in.mask || in.mask[i] > 0);
}

MGS_FN float log_depth_error(const Distilled& in, int64 i) {
  return logf(in.depth[i] / in.alpha[i]) - logf(in.teacher_depth[i]);
}

}  // namespace

// One thread per pixel. Writes a block's sums of m |image - teacher| and m, and of the errors of
// log-depths, their squares and their number.
KERNEL(THREADS, 4)
mgs_distill_terms(int64 pixels, int channels, PARAM Distilled in, float* block_sums) {
  int64 i = global_thread();
  float weight = 0, absolute = 0, error = 0, counts = 0;
  if (i < pixels) {
    weight = in.mask ? in.mask[i] : 1.0f;
    for (int64 k = channels * i; k < channels * (i + 1); k++)
      absolute += fabsf(in.image[k] - in.teacher[k]);
    if (depth_counts(in, i)) error = log_depth_error(in, i), counts = 1;
  }
  write_block_sums<5>({weight * absolute, weight, error, error * error, counts}, block_sums);
}

// One block. Writes the loss: the mean difference of colours and the variance of the errors of
// log-depths, with their weights.
KERNEL(THREADS, 1)
mgs_distill_finish(int blocks, int channels, float color_weight, float depth_weight,
                   const float* block_sums, float* loss, DistillFactors* factors) {
  double totals[5];
  add_blocks(block_sums, blocks, totals);
  if (threadIdx.x) return;
  double values = channels * totals[1], number = totals[4] > 1 ? totals[4] : 1;
  double color = color_weight / (values > 1 ? values : 1), mean = totals[2] / number;
  *loss = (float)(color * totals[0] + depth_weight * (totals[3] / number - mean * mean));
  *factors = {(float)color, (float)(2 * depth_weight / number), (float)mean};
}

// One thread per pixel. Writes the gradients of the loss, times `grad`.
KERNEL(THREADS, 4)
mgs_distill_gradient(int64 pixels, int channels, PARAM Distilled in, const DistillFactors* factors,
                     const float* grad, float* to_image, float* to_depth, float* to_alpha) {
  int64 i = global_thread();
  if (i >= pixels) return;
  float scale = *grad, to_color = scale * factors->color * (in.mask ? in.mask[i] : 1.0f);
  for (int64 k = channels * i; k < channels * (i + 1); k++)
    to_image[k] = to_color * sign_of_difference(in.image[k], in.teacher[k]);
  if (!in.depth) return;
  float to_error = 0;
  bool counts = depth_counts(in, i);
  if (counts) to_error = scale * factors->depth * (log_depth_error(in, i) - factors->mean);
  to_depth[i] = counts ? to_error / in.depth[i] : 0.0f;
  to_alpha[i] = counts ? -to_error / in.alpha[i] : 0.0f;
}
