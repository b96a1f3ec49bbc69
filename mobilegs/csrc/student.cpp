// The default student's step around its renderings on CPUs: the Gaussians that its views can show,
// their decoded values, and from the gradients of these values a step of Adam. The arithmetic is in
// student.h; train/student/program.py calls these functions.
//
// A block of rows belongs to one thread; sums over Gaussians add the blocks in order. So results do
// not depend on the number of threads.
#include "parallel.h"
#include "student.h"

#include <memory>
#include <vector>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int BLOCK = 512;  // rows; a group never lies in two blocks

// Adds sum over the group of a[r] b[c] to totals[r * columns + c], for MANY_A rows and MANY_B
// columns.
template <int MANY_A, int MANY_B>
void some_products(const Column* a, const Column* b, int columns, float* totals) {
  vfloat sums[MANY_A][MANY_B] = {};
  for (int at = 0; at < GROUP; at += LANES) {
    vfloat y[MANY_B];
    for (int c = 0; c < MANY_B; c++) y[c] = load(&b[c][at]);
    for (int r = 0; r < MANY_A; r++) {
      vfloat x = load(&a[r][at]);
      for (int c = 0; c < MANY_B; c++) sums[r][c] += x * y[c];
    }
  }
  for (int r = 0; r < MANY_A; r++)
    for (int c = 0; c < MANY_B; c++) totals[r * columns + c] += sum_of(sums[r][c]);
}

void add_products(const Column* a, int rows, const Column* b, int columns, float* totals) {
  int r = 0;
  for (; r + 4 <= rows; r += 4) {
    int c = 0;
    for (; c + 4 <= columns; c += 4)
      some_products<4, 4>(a + r, b + c, columns, totals + r * columns + c);
    for (; c < columns; c++) some_products<4, 1>(a + r, b + c, columns, totals + r * columns + c);
  }
  for (; r < rows; r++)
    for (int c = 0; c < columns; c++)
      some_products<1, 1>(a + r, b + c, columns, totals + r * columns + c);
}

float sum_of_row(const Column& row) {
  vfloat sum = {};
  for (int at = 0; at < GROUP; at += LANES) sum += load(&row[at]);
  return sum_of(sum);
}

// sum over rows and Gaussians of a b
float sum_of_products(const Column* a, const Column* b, int rows) {
  vfloat sum = {};
  for (int r = 0; r < rows; r++)
    for (int at = 0; at < GROUP; at += LANES) sum += load(&a[r][at]) * load(&b[r][at]);
  return sum_of(sum);
}

// The gradients of the shared weights that a thread adds.
struct Totals {
  float* weights;
  void products(const Column* a, int rows, const Column* b, int columns, int at) {
    add_products(a, rows, b, columns, weights + at);
  }
  void sums(const Column* a, int rows, int at) {
    for (int r = 0; r < rows; r++) weights[at + r] += sum_of_row(a[r]);
  }
  void product(const Column* a, const Column* b, int rows, int at) {
    weights[at] += sum_of_products(a, b, rows);
  }
  void number(float x, int at) { weights[at] += x; }
};

// Takes a step of Adam on `many` values from number `first` on, whose gradients are the sums of two
// arrays; `more` may be null.
void adam_on(const Trained& t, int64 first, int64 many, const float* grads, const float* more) {
  float *p = t.values + first, *m = t.mean + first, *v = t.square + first;
  int64 i = 0;
  for (; i + LANES <= many; i += LANES) {
    vfloat g = load(grads + i);
    if (more) g += load(more + i);
    adam(t, g, p + i, m + i, v + i);
  }
  for (; i < many; i++) adam(t, more ? grads[i] + more[i] : grads[i], p + i, m + i, v + i);
}

int64 blocks_of(const Student& s) { return (s.count + BLOCK - 1) / BLOCK; }

// Runs work(from, many) for the groups of a block's places.
template <class Work>
void for_groups(const int64* starts, int64 block, Work work) {
  for (int64 at = starts[block]; at < starts[block + 1]; at += GROUP)
    work(at, (int)std::min<int64>(GROUP, starts[block + 1] - at));
}

// Marks the Gaussians of a group whose ellipse can touch the image for some rotation and opacity.
void mark_in_sight(const View& v, const Column* mean, const Column& scale, int* marks) {
  const float* r = v.rotation;
  float reach = -2 / LOG2_E * log2f(v.alpha_min);
  for (int i = 0; i < GROUP; i++) {
    float mx = mean[0][i], my = mean[1][i], mz = mean[2][i];
    float z = r[6] * mx + r[7] * my + r[8] * mz + v.translation[2], inverse = 1 / z;
    float x = (r[0] * mx + r[1] * my + r[2] * mz + v.translation[0]) * inverse;
    float y = (r[3] * mx + r[4] * my + r[5] * mz + v.translation[1]) * inverse;
    float u = clamp(x, v.limits[0], v.limits[1]), w = clamp(y, v.limits[2], v.limits[3]);
    float sx = v.focal[0] * inverse * scale[i], sy = v.focal[1] * inverse * scale[i];
    float rx = sqrtf(reach * (sx * sx * (1 + u * u) + v.blur)) + 1;  // a pixel for rounding
    float ry = sqrtf(reach * (sy * sy * (1 + w * w) + v.blur)) + 1;
    float left = v.focal[0] * x + v.center[0], top = v.focal[1] * y + v.center[1];
    marks[i] |= (z > v.near_plane) & (z < v.far_plane) & (left + rx > 0) & (left - rx < v.width) & (top + ry > 0) &
                (top - ry < v.height);
  }
}

}  // namespace

EXPORT int mgs_student_bytes() { return sizeof(Student); }
EXPORT int mgs_student_block() { return BLOCK; }
EXPORT void mgs_student_prepare(const Student* s) { prepare(*s, 0, 1, [] {}); }

// Lists the Gaussians that one of the views may show, or all if there is none, in rows[count]. They
// rise; those of block b lie at [starts[b], starts[b + 1]), starts[blocks + 1]. Returns their number.
EXPORT int64_t mgs_student_rows(const Student* student, const View* views, int number, int* rows,
                                int64_t* starts) {
  const Student& s = *student;
  starts[0] = 0;
  std::unique_ptr<uint8_t[]> seen(new uint8_t[std::max<int64>(1, s.count)]);
  // a quantised log-scale is at most half a step larger
  float margin = s.phase == QUANTIZED ? 0.5f * s.weights[Places(s).steps + SCALE_STEP] : 0;
  parallel_for(blocks_of(s), 4, [&](int64 first, int64 end) {
    alignas(64) Column mean[3], scale;
    int marks[GROUP];
    for (int64 block = first; block < end; block++) {
      int64 found = 0, last = std::min(s.count, (block + 1) * BLOCK);
      for (int64 at = block * BLOCK; at < last; at += GROUP) {
        int many = (int)std::min<int64>(GROUP, last - at);
        load_means(s, {nullptr, at, many}, mean);
        for (int i = 0; i < many; i++) {
          scale[i] = largest(s.log_scales.values + 3 * (at + i)) + margin;
          marks[i] = 0;
        }
        for (int i = many; i < GROUP; i++) scale[i] = 0, marks[i] = 0;
        if (number == 0) std::fill_n(marks, many, 1);
        for (int i = 0; i < GROUP; i += LANES) store(scale + i, exp_of(load(scale + i)));
        for (int k = 0; k < number; k++) mark_in_sight(views[k], mean, scale, marks);
        for (int i = 0; i < many; i++) seen[at + i] = marks[i] != 0, found += marks[i] != 0;
      }
      starts[block + 1] = found;
    }
  });
  for (int64 block = 0; block < blocks_of(s); block++) starts[block + 1] += starts[block];
  parallel_for(blocks_of(s), 4, [&](int64 first, int64 end) {
    int64 place = starts[first];
    for (int64 i = first * BLOCK; i < std::min(s.count, end * BLOCK); i++)
      if (seen[i]) rows[place++] = (int)i;
  });
  return starts[blocks_of(s)];
}

// Writes the decoded values of `rows`.
EXPORT void mgs_student_decode(const Student* student, const int* rows, const int64_t* starts,
                               const Decoded* out) {
  const Student& s = *student;
  parallel_for(blocks_of(s), 1, [&](int64 first, int64 end) {
    std::unique_ptr<GroupValues> g(new GroupValues);
    for (int64 block = first; block < end; block++)
      for_groups(starts, block, [&](int64 at, int many) {
        decode_group(s, {rows + at, 0, many}, *g);
        store_group(g->mean, 3, at, many, 3, out->means);
        store_group(g->quat, 4, at, many, 4, out->quats);
        store_group(g->log_scale, 3, at, many, 3, out->log_scales);
        store_group(g->sh, s.colors, at, many, s.colors, out->sh);
        store_group(g->lobe, s.lobes, at, many, s.lobes, out->lobes);
      });
  });
}

// Takes a step of Adam on all Gaussians and shared parameters, from the gradients `in` of the decoded
// values of `rows` and those of overdraw; the others have only the gradients of Trained.grad.
EXPORT void mgs_student_update(const Student* student, const int* rows, const int64_t* starts,
                               const Decoded* in, const Overdraw* overdraw) {
  const Student& s = *student;
  int width = 0, size = Places(s).size;
  for (int k = 0; k < TENSORS; k++) width += s.tensor(k).columns;
  std::vector<float> parts((size_t)blocks_of(s) * size, 0.0f);
  parallel_for(blocks_of(s), 1, [&](int64 first, int64 end) {
    std::unique_ptr<GroupValues> g(new GroupValues);
    std::unique_ptr<GroupGradients> d(new GroupGradients);
    std::vector<float> grads((size_t)BLOCK * width);
    for (int64 block = first; block < end; block++) {
      int64 from = block * BLOCK, to = std::min(s.count, from + BLOCK);
      std::fill(grads.begin(), grads.end(), 0.0f);
      for_groups(starts, block, [&](int64 at, int many) {
        decode_group(s, {rows + at, 0, many}, *g);
        load_gradients(s, *in, at, many, *d);
        add_overdraw(*overdraw, *g, *d);
        Totals totals{&parts[(size_t)block * size]};
        adjoint_of_group(s, *g, many, *d, totals);
        float* part = grads.data();
        for (int k = 0; k < TENSORS; k++) {
          int columns = s.tensor(k).columns;
          auto row_of = [=](int i) { return part + (rows[at + i] - from) * columns; };
          lanes_to_rows(d->of(s, k)[0], GROUP, columns, many, row_of);
          part += (int64)BLOCK * columns;
        }
      });
      const float* part = grads.data();
      for (int k = 0; k < TENSORS; k++) {
        const Trained& t = s.tensor(k);
        int64 at = from * t.columns;
        adam_on(t, at, (to - from) * t.columns, part, t.grad ? t.grad + at : nullptr);
        part += (int64)BLOCK * t.columns;
      }
    }
  });
  for (int i = 0; i < s.shared_count; i++)
    for (int n = 0; n < shared_size(s.shared[i]); n++) {
      double sum = 0;
      int place = shared_place(s.shared[i], n);
      for (int64 block = 0; block < blocks_of(s); block++) sum += parts[block * size + place];
      shared_adam(s.shared[i], n, (float)sum);
    }
}

// Takes a step of Adam on [rows][columns] values, whose gradients lie in rows `stride` floats apart.
EXPORT void mgs_adam(int64_t rows, int64_t stride, const Trained* t) {
  int columns = t->columns;
  parallel_for((rows + BLOCK - 1) / BLOCK, 4, [&](int64 first, int64 end) {
    int64 from = first * BLOCK, to = std::min(rows, end * BLOCK);
    int64 step = stride == columns ? to - from : 1;  // rows that lie together
    for (int64 row = from; row < to; row += step)
      adam_on(*t, row * columns, step * columns, t->grad + row * stride, nullptr);
  });
}
