// The default student's step around its renderings in CUDA, one thread per Gaussian: the arithmetic
// is in student.h. All Gaussians are decoded, since projection finds those in sight.
#pragma once
#include "cuda_common.h"
#include "student.h"

namespace {

constexpr int STEPS_MAX = 8;

// Steps of Adam on tensors [rows][columns], whose gradients lie in rows `strides` floats apart;
// optim.py mirrors the fields.
struct Steps {
  Trained tensors[STEPS_MAX];
  int64 rows[STEPS_MAX], strides[STEPS_MAX];
  int count;
};

constexpr int EDGE = 16;  // of the part of a product of matrices that a block's threads add at a time

// Adds the gradients of the shared weights over the Gaussians of a block, and writes them to `parts`.
// All threads of the block call each function.
struct BlockTotals {
  float* parts;
  float (*staged)[EDGE][THREADS + 1];  // in shared memory; a row more spreads it over the banks

  // The numbers in `b` are 1 if it is null.
  MGS_CALL void products(const Column* a, int rows, const Column* b, int columns, int at) {
    int me = threadIdx.x, r = me / EDGE, c = me % EDGE;
    for (int row = 0; row < rows; row += EDGE)
      for (int column = 0; column < columns; column += EDGE) {
        __syncthreads();  // all threads have read what was staged before
        for (int k = 0; k < EDGE; k++) {
          staged[0][k][me] = row + k < rows ? a[row + k][0] : 0;
          staged[1][k][me] = column + k >= columns ? 0 : b ? b[column + k][0] : 1;
        }
        __syncthreads();
        if (row + r >= rows || column + c >= columns) continue;
        float sum = 0;
        for (int i = 0; i < THREADS; i++) sum += staged[0][r][i] * staged[1][c][i];
        parts[at + (row + r) * columns + column + c] = sum;
      }
  }
  MGS_CALL void sums(const Column* a, int rows, int at) { products(a, rows, nullptr, 1, at); }
  MGS_CALL void product(const Column* a, const Column* b, int rows, int at) {
    float sum = 0;
    for (int r = 0; r < rows; r++) sum += a[r][0] * b[r][0];
    number(sum, at);
  }
  MGS_CALL void number(float x, int at) {
    Column one[1] = {{x}};
    sums(one, 1, at);
  }
};

}  // namespace

// One block: rounds the shared weights.
KERNEL(THREADS, 1)
mgs_student_prepare(PARAM Student s) {
  prepare(s, threadIdx.x, THREADS, [] { __syncthreads(); });
}

KERNEL(THREADS, 2)
mgs_student_decode(PARAM Student s, PARAM Decoded out) {
  int64 i = global_thread();
  if (i >= s.count) return;
  GroupValues g;
  decode_group(s, {nullptr, i, 1}, g);
  store_group(g.mean, 3, i, 1, 3, out.means);
  store_group(g.quat, 4, i, 1, 4, out.quats);
  store_group(g.log_scale, 3, i, 1, 3, out.log_scales);
  store_group(g.sh, s.colors, i, 1, s.colors, out.sh);
  store_group(g.lobe, s.lobes, i, 1, s.lobes, out.lobes);
}

// Takes a step of Adam on all Gaussians, from the gradients of decoded values and of overdraw. Writes
// the gradients of the shared weights, parts[blocks][Places::size].
KERNEL(THREADS, 2)
mgs_student_update(PARAM Student s, PARAM Decoded in, PARAM Overdraw overdraw, float* parts) {
  __shared__ float staged[2][EDGE][THREADS + 1];
  int64 i = global_thread();
  int many = i < s.count;
  GroupValues g;
  GroupGradients d;
  decode_group(s, {nullptr, i, many}, g);
  load_gradients(s, in, i, many, d);
  add_overdraw(overdraw, g, d);
  BlockTotals totals = {parts + (int64)blockIdx.x * Places(s).size, staged};
  adjoint_of_group(s, g, many, d, totals);
  if (!many) return;
  for (int k = 0; k < TENSORS; k++) {
    const Trained& t = s.tensor(k);
    const Column* found = d.of(s, k);
    for (int c = 0; c < t.columns; c++) {
      int64 n = i * t.columns + c;
      adam(t, found[c][0] + (t.grad ? t.grad[n] : 0), t.values + n, t.mean + n, t.square + n);
    }
  }
}

// Takes a step of Adam on the shared parameters, one thread per number.
KERNEL(THREADS, 4)
mgs_student_finish(PARAM Student s, int blocks, const float* parts) {
  int64 number = global_thread();
  int size = Places(s).size;
  for (int i = 0; i < s.shared_count; i++) {
    const Shared& p = s.shared[i];
    if (number < shared_size(p)) {
      double sum = 0;
      const float* part = parts + shared_place(p, (int)number);
      for (int block = 0; block < blocks; block++) sum += part[(int64)block * size];
      return shared_adam(p, (int)number, (float)sum);
    }
    number -= shared_size(p);
  }
}

// Takes the steps of all tensors, one thread per number; each tensor has whole blocks.
KERNEL(THREADS, 4)
mgs_adam(PARAM Steps steps) {
  int64 block = blockIdx.x;
  for (int i = 0; i < steps.count; i++) {
    const Trained& t = steps.tensors[i];
    int64 size = steps.rows[i] * t.columns, blocks = (size + THREADS - 1) / THREADS;
    if (block < blocks) {
      int64 n = block * THREADS + threadIdx.x;
      if (n >= size) return;
      float gradient = t.grad[n / t.columns * steps.strides[i] + n % t.columns];
      return adam(t, gradient, t.values + n, t.mean + n, t.square + n);
    }
    block -= blocks;
  }
}
