// The default student's decoding, its adjoint and Adam, for CPUs (student.cpp) and CUDA
// (cuda_student.h). The reference is train/student/shared_decode.py with the model, the decoders and
// the quantisers that it calls; train/student/program.py calls both.
#pragma once
#include "core.h"
#include "group.h"
#include "terms.h"

namespace {

enum Phase { EXPLICIT = 0, WITH_LATENTS = 1, QUANTIZED = 2 };

constexpr int COLORS_MAX = 48, LATENTS_MAX = 32, LOBES_MAX = 32, HIDDEN_MAX = 64;
// of Adam: 1 - beta1, beta2, 1 - beta2; 1 - 0.999f would be off by 1e-5
constexpr float NEW1 = 0.1f, OLD2 = 0.999f, NEW2 = 0.001f, EPS = 1e-15f;
constexpr float HALF_MAX = 65504, HALF_NORMAL = 6.103515625e-05f;
enum { SCALE_STEP, ROTATION_STEP, COLOR_STEP, LOGIT_STEP, LATENT_STEP, STEPS };
constexpr int TENSORS = 7, SHARED = 12;  // of a student, with a row per Gaussian and without

// A tensor with a row per Gaussian, and its Adam. `grad` holds gradients of other terms of the loss,
// or is null. The rates are lr / (1 - beta1^t) and 1 / sqrt(1 - beta2^t).
struct Trained {
  float *values, *mean, *square;
  const float* grad;
  int columns;
  float rate, root;
};

// A parameter of all Gaussians, [rows][tensor.columns], or the logarithm of a step size. Number (r, c)
// is at + r * row_step + c * column_step of the weights: rounded to float16 with so many significant
// `bits`, or, if these are 0, the step size initial * e^number, limited to least and most.
struct Shared {
  Trained tensor;
  int rows, at, row_step, column_step, bits;
  float initial, least, most;
};

// The parameters of a student; program.py mirrors the fields. `color0` and `color1` are harmonics
// while explicit, then latents of colours; a quantised student has them in one tensor.
struct Student {
  Trained means, quats, log_scales, color0, color1, logits, latents;
  Shared shared[SHARED];
  int64 count;
  int phase;
  int colors, lobes, hidden;  // values of colours and lobes, hidden units
  float center[3], radius, unit;  // of the grid of positions; unit: 2^exponent
  int rounds;                     // 1: means are rounded to the grid
  int shared_count;
  float base;                // of a logit in the first lobe
  const unsigned char* bits;  // of rotations, by the difference of log-scales in 256ths
  int last_bits;              // the last entry
  float *weights, *turned;    // see Places; written by `prepare`
  MGS_CALL int inputs() const { return color0.columns + color1.columns; }
  MGS_CALL int first_width() const { return STATICS + latents.columns; }
  MGS_CALL int last_width() const { return hidden + latents.columns + 1; }
  MGS_CALL const Trained& tensor(int k) const {
    const Trained* tensors[] = {&means, &quats, &log_scales, &color0, &color1, &logits, &latents};
    return *tensors[k];
  }
};

// Places of the shared weights: matrices row by row, of colours [colors][inputs], of the first layer
// [hidden][first_width] and [hidden], of the last [lobes][last_width] and [lobes]; step sizes. Those
// of the turned matrices, through which gradients go back; of the first layer only the columns of
// latents.
struct Places {
  int color, first, first_offset, last, bias, steps, size;
  int turned_color, turned_first, turned_last, turned_size;
  MGS_CALL explicit Places(const Student& s) {
    color = turned_color = 0;
    first = color + (s.phase == EXPLICIT ? 0 : s.colors * s.inputs());
    turned_first = first;
    turned_last = turned_first + s.latents.columns * s.hidden;
    turned_size = turned_last + s.last_width() * s.lobes;
    first_offset = first + s.hidden * s.first_width();
    last = first_offset + s.hidden;
    bias = last + s.lobes * s.last_width();
    steps = bias + s.lobes;
    size = steps + STEPS;
  }
};

// Values of the Gaussians in sight, or their gradients, [m][...].
struct Decoded {
  float *means, *quats, *log_scales, *sh, *lobes;
};

// ---------------------------------------------------------------- values
// Rounds to 24 - `dropped` significant bits, ties to even.
template <class V>
MGS_FN V round_bits(V x, int dropped) {
  auto bits = bits_of(x);
  int half = 1 << (dropped - 1);
  return float_of((bits + (half - 1) + ((bits >> dropped) & 1)) & ~(2 * half - 1));
}

// The nearest float16 numbers, as to_float16 in representation/float16.py; -0 becomes 0.
template <class V>
MGS_FN V nearest_half(V x) {
  x = min_of(max_of(x, splat_value(x, -HALF_MAX)), splat_value(x, HALF_MAX));
  return select(max_of(x, -x) < HALF_NORMAL, (x + 0.75f) - 0.75f, round_bits(x, 13));
}

MGS_FN float shared_value(const Shared& p, int number) {
  float value = p.tensor.values[number];
  if (p.bits) return nearest_half(p.bits < 11 ? round_bits(value, 24 - p.bits) : value);
  return step_of({&value, p.initial, p.least, p.most});
}

MGS_FN int shared_place(const Shared& p, int number) {
  return p.at + number / p.tensor.columns * p.row_step + number % p.tensor.columns * p.column_step;
}

MGS_FN int shared_size(const Shared& p) { return p.rows * p.tensor.columns; }

// Writes the weights and the turned matrices. Each of `many` threads calls it with its number;
// `wait` lets all reach a place.
template <class Wait>
MGS_CALL void prepare(const Student& s, int thread, int many, Wait wait) {
  Places at(s);
  for (int k = thread; k < at.size; k += many) s.weights[k] = 0;
  wait();
  for (int i = 0; i < s.shared_count; i++)
    for (int n = thread; n < shared_size(s.shared[i]); n += many)
      s.weights[shared_place(s.shared[i], n)] = shared_value(s.shared[i], n);
  if (thread == 0) s.weights[at.last + s.last_width() - 1] = s.base;
  wait();
  auto turn = [&](int from, int to, int rows, int width, int first_column) {
    for (int n = thread; n < rows * (width - first_column); n += many)
      s.turned[to + n] = s.weights[from + n % rows * width + n / rows + first_column];
  };
  if (s.phase != EXPLICIT) turn(at.color, at.turned_color, s.colors, s.inputs(), 0);
  turn(at.first, at.turned_first, s.hidden, s.first_width(), STATICS);
  turn(at.last, at.turned_last, s.lobes, s.last_width(), 0);
}

// The Gaussians of a group: those that `ids` names, or from number `from` on if it is null.
struct Members {
  const int* ids;
  int64 from;
  int many;
  MGS_CALL int64 operator[](int i) const { return ids ? ids[i] : from + i; }
};

// Loads means, and rounds them to the grid (PositionGrid in mgs/positions.py).
MGS_CALL void load_means(const Student& s, const Members& members, Column* mean) {
  for (int i = 0; i < members.many; i++)
    for (int a = 0; a < 3; a++) mean[a][i] = s.means.values[3 * members[i] + a];
  clear(mean, 3, members.many);
  if (!s.rounds) return;
  float per_unit = 1 / s.unit;  // a power of 2
  for (int a = 0; a < 3; a++)
    for (int at = 0; at < GROUP; at += LANES) {
      vfloat stored = nearest_half((load(&mean[a][at]) - s.center[a]) / s.radius * per_unit);
      store(&mean[a][at], s.center[a] + s.radius * (stored * s.unit));
    }
}

// Decoded values of a group, and what their adjoints need again.
struct alignas(64) GroupValues {
  Column mean[3], quat[4], log_scale[3], sh[COLORS_MAX], lobe[LOBES_MAX];
  Column input[COLORS_MAX];
  Column first_in[STATICS + LATENTS_MAX];         // static inputs, latents
  Column last_in[HIDDEN_MAX + LATENTS_MAX + 1];  // hidden units, latents, base logit
  Column turn[4];                                // the quaternion before it was made canonical
  // quantised: what a step size is multiplied by, less the unquantised value in steps
  Column scale_off[3], input_off[COLORS_MAX], logit_off[1], latent_off[LATENTS_MAX];
  Column vector[3], vector_off[3];  // of the quantised rotation
};

MGS_CALL void load_values(const Trained& t, const Members& members, Column* rows) {
  auto row_of = [&](int i) { return t.values + members[i] * t.columns; };
  rows_to_lanes(row_of, t.columns, members.many, rows[0], GROUP);
  clear(rows, t.columns, members.many);
}

MGS_CALL void quantize(float step, int columns, Column* rows, Column* off) {
  for (int c = 0; c < columns; c++)
    for (int i = 0; i < GROUP; i++) {
      float multiple = rows[c][i] / step, code = nearest_code(multiple);
      off[c][i] = code - multiple;
      rows[c][i] = code * step;
    }
}

// Makes the quaternions in `turn` unit ones with w >= 0.
MGS_CALL void canonical(const Column* turn, Column* quat) {
  for (int i = 0; i < GROUP; i++) {
    float w = turn[0][i], x = turn[1][i], y = turn[2][i], z = turn[3][i];
    float length = max_of(sqrtf(w * w + x * x + y * y + z * z), LENGTH_MIN);
    float share = (w < 0 ? -1.0f : 1.0f) / length;
    quat[0][i] = w * share, quat[1][i] = x * share, quat[2][i] = y * share, quat[3][i] = z * share;
  }
}

// Replaces the canonical quaternions of the first `many` by quantised ones, as RotationQuantizer;
// `log_scale` holds quantised values.
MGS_CALL void quantize_rotations(const Student& s, float step, int many, GroupValues& g) {
  for (int i = 0; i < many; i++) {
    float w = g.quat[0][i], q[3] = {g.quat[1][i], g.quat[2][i], g.quat[3][i]};
    float sine = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    float share = 2 * atan2f(sine, w) / max_of(sine, ANGLE_MIN), squares = 0;
    for (int a = 0; a < 3; a++) {
      float apart = fabsf(g.log_scale[(a + 1) % 3][i] - g.log_scale[(a + 2) % 3][i]);
      float parts = (float)(1 << s.bits[(int)min_of(apart * 256, (float)s.last_bits)]);
      float multiple = q[a] * share / step;
      float code = floorf((multiple + 0.5f) * parts);
      float quantized = (code + 0.5f) / parts - 0.5f;
      g.vector_off[a][i] = quantized - multiple;
      g.vector[a][i] = quantized * step;
      squares += g.vector[a][i] * g.vector[a][i];
    }
    float angle = sqrtf(squares);
    float half = angle < ANGLE_MIN ? 0.5f : sinf(angle / 2) / angle;
    g.quat[0][i] = cosf(angle / 2);
    for (int a = 0; a < 3; a++) g.quat[a + 1][i] = half * g.vector[a][i];
  }
  clear(g.vector, 3, many), clear(g.vector_off, 3, many);
}

// Decodes a group; its lanes without a Gaussian are finite.
MGS_CALL void decode_group(const Student& s, const Members& members, GroupValues& g) {
  Places at(s);
  const float *weights = s.weights, *steps = weights + at.steps;
  int inputs = s.inputs(), latents = s.latents.columns;
  load_means(s, members, g.mean);
  Column *latent = g.last_in + s.hidden, *logit = latent + latents;
  load_values(s.quats, members, g.turn);
  load_values(s.log_scales, members, g.log_scale);
  load_values(s.color0, members, g.input);
  load_values(s.color1, members, g.input + s.color0.columns);
  load_values(s.latents, members, latent);
  load_values(s.logits, members, logit);
  canonical(g.turn, g.quat);
  if (s.phase == QUANTIZED) {
    quantize(steps[SCALE_STEP], 3, g.log_scale, g.scale_off);
    quantize(steps[COLOR_STEP], inputs, g.input, g.input_off);
    quantize(steps[LATENT_STEP], latents, latent, g.latent_off);
    quantize(steps[LOGIT_STEP], 1, logit, g.logit_off);
    quantize_rotations(s, steps[ROTATION_STEP], members.many, g);
  }
  if (s.phase == EXPLICIT)
    copy(g.input, s.colors, g.sh);
  else
    layer<IDENTITY>(weights + at.color, nullptr, s.colors, inputs, g.input, g.sh);

  Column* statics = g.first_in;
  int known = s.colors < COLOR ? s.colors : COLOR;
  copy(g.sh, known, statics);
  clear(statics + known, COLOR - known, 0);
  for (int a = 0; a < SCALES; a++)
    for (int i = 0; i < GROUP; i += LANES)
      store(&statics[COLOR + a][i], exp_of(load(&g.log_scale[a][i])));
  copy(g.quat, TURNS, statics + COLOR + SCALES);
  normalise(statics, COLOR);
  normalise(statics + COLOR, SCALES);
  normalise(statics + COLOR + SCALES, TURNS);
  copy(latent, latents, statics + STATICS);
  layer<RELU>(weights + at.first, weights + at.first_offset, s.hidden, s.first_width(), g.first_in,
              g.last_in);
  layer<IDENTITY>(weights + at.last, weights + at.bias, s.lobes, s.last_width(), g.last_in, g.lobe);
}

// ---------------------------------------------------------------- gradients
// Gradients of decoded values in; out, in the same memory, of the trained ones.
struct alignas(64) GroupGradients {
  Column mean[3], quat[4], log_scale[3], sh[COLORS_MAX], lobe[LOBES_MAX];
  Column input[COLORS_MAX], last_in[HIDDEN_MAX + LATENTS_MAX + 1], more[LATENTS_MAX];

  // Of tensor `k` of a student.
  MGS_CALL const Column* of(const Student& s, int k) const {
    const Column* latent = last_in + s.hidden;
    if (k == 0) return mean;
    if (k == 1) return quat;
    if (k == 2) return log_scale;
    if (k == 3) return input;
    if (k == 4) return input + s.color0.columns;
    return k == 5 ? latent + s.latents.columns : latent;
  }
};

// Through quats_of: the rotation step's gradient, summed over the group. The values' is that of the
// quaternions.
MGS_CALL float rotation_step_gradient(const GroupValues& g, const Column* quat, int many) {
  float sum = 0;
  for (int i = 0; i < many; i++) {
    float v[3] = {g.vector[0][i], g.vector[1][i], g.vector[2][i]};
    float angle = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    float d[3] = {quat[1][i], quat[2][i], quat[3][i]}, along = 0, half = 0.5f;
    if (angle >= ANGLE_MIN) {
      float sine = sinf(angle / 2), cosine = cosf(angle / 2);
      half = sine / angle;
      float slope = (0.5f * cosine - half) / angle;  // of half, by the angle
      float dot = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];
      along = (slope * dot - 0.5f * sine * quat[0][i]) / angle;
    }
    for (int a = 0; a < 3; a++) sum += (half * d[a] + along * v[a]) * g.vector_off[a][i];
  }
  return sum;
}

MGS_CALL void adjoint_of_canonical(const GroupValues& g, Column* quat) {
  for (int i = 0; i < GROUP; i++) {
    float w = g.turn[0][i], x = g.turn[1][i], y = g.turn[2][i], z = g.turn[3][i];
    float length = max_of(sqrtf(w * w + x * x + y * y + z * z), LENGTH_MIN);
    float share = (w < 0 ? -1.0f : 1.0f) / length, along = 0;
    for (int k = 0; k < 4; k++) along += quat[k][i] * g.quat[k][i];
    for (int k = 0; k < 4; k++) quat[k][i] = share * (quat[k][i] - along * g.quat[k][i]);
  }
}

MGS_CALL void load_gradients(const Student& s, const Decoded& in, int64 from, int many,
                             GroupGradients& d) {
  load_group(in.means, 3, from, many, 3, d.mean);
  load_group(in.quats, 4, from, many, 4, d.quat);
  load_group(in.log_scales, 3, from, many, 3, d.log_scale);
  load_group(in.sh, s.colors, from, many, s.colors, d.sh);
  load_group(in.lobes, s.lobes, from, many, s.lobes, d.lobe);
}

// The overdraw term of one view; program.py mirrors the fields. Opacities are those without view
// dependence. A weight of 0 leaves the term out.
struct Overdraw {
  View view;
  float weight, alpha_min, level_sigma;
};

MGS_CALL void add_overdraw(const Overdraw& o, const GroupValues& g, GroupGradients& d) {
  if (o.weight == 0) return;
  vfloat first_lobe;
  sh_basis(1, vfloat{}, vfloat{}, vfloat{}, &first_lobe);
  for (int at = 0; at < GROUP; at += LANES) {
    vfloat mean[3], q[4], log_scale[3], gradient[3];
    for (int a = 0; a < 4; a++) q[a] = load(&g.quat[a][at]);
    for (int a = 0; a < 3; a++)
      mean[a] = load(&g.mean[a][at]), log_scale[a] = load(&g.log_scale[a][at]);
    vfloat logit = first_lobe * load(&g.lobe[0][at]);
    overdraw_gradient(o.view, mean, q, log_scale, logit, o.alpha_min, o.level_sigma, gradient);
    for (int a = 0; a < 3; a++)
      store(&d.log_scale[a][at], load(&d.log_scale[a][at]) + o.weight * gradient[a]);
  }
}

// From the gradients of a group's decoded values to those of its trained values, and of the shared
// weights. `totals` adds these at their places: of rows a and columns b products(a, rows, b, columns,
// at) adds a b^T, sums(a, rows, at) the sum of each row, product(a, b, rows, at) sum a b, and
// number(x, at) a number; each of them over the Gaussians.
template <class Totals>
MGS_CALL void adjoint_of_group(const Student& s, const GroupValues& g, int many, GroupGradients& d,
                               Totals& totals) {
  Places at(s);
  int latents = s.latents.columns;
  totals.products(d.lobe, s.lobes, g.last_in, s.last_width(), at.last);
  totals.sums(d.lobe, s.lobes, at.bias);
  layer<IDENTITY>(s.turned + at.turned_last, nullptr, s.last_width(), s.lobes, d.lobe, d.last_in);
  for (int r = 0; r < s.hidden; r++)
    for (int i = 0; i < GROUP; i++) d.last_in[r][i] = g.last_in[r][i] > 0 ? d.last_in[r][i] : 0;
  totals.products(d.last_in, s.hidden, g.first_in, s.first_width(), at.first);
  totals.sums(d.last_in, s.hidden, at.first_offset);
  layer<IDENTITY>(s.turned + at.turned_first, nullptr, latents, s.hidden, d.last_in, d.more);
  Column *latent = d.last_in + s.hidden, *logit = latent + latents;
  for (int c = 0; c < latents; c++)
    for (int i = 0; i < GROUP; i++) latent[c][i] += d.more[c][i];
  if (s.phase == EXPLICIT) {
    copy(d.sh, s.colors, d.input);
  } else {
    totals.products(d.sh, s.colors, g.input, s.inputs(), at.color);
    layer<IDENTITY>(s.turned + at.turned_color, nullptr, s.inputs(), s.colors, d.sh, d.input);
  }
  if (s.phase != QUANTIZED) return adjoint_of_canonical(g, d.quat);
  totals.product(d.log_scale, g.scale_off, 3, at.steps + SCALE_STEP);
  totals.product(d.input, g.input_off, s.inputs(), at.steps + COLOR_STEP);
  totals.product(logit, g.logit_off, 1, at.steps + LOGIT_STEP);
  totals.product(latent, g.latent_off, latents, at.steps + LATENT_STEP);
  totals.number(rotation_step_gradient(g, d.quat, many), at.steps + ROTATION_STEP);
}

// Takes a step of Adam on LANES values, or one. Loops of floats would not become vectors: GCC gives up
// on as many arrays as may overlap.
template <class V>
MGS_FN void adam(const Trained& t, V g, float* p, float* m, float* v) {
  V mean = load_as(m, V{}), square = OLD2 * load_as(v, V{}) + NEW2 * g * g;
  mean += NEW1 * (g - mean);
  store(m, mean), store(v, square);
  store(p, load_as(p, V{}) - t.rate * mean / (sqrt_of(square) * t.root + EPS));
}

// Takes a step of Adam on number `n` of a shared parameter, whose weight has a gradient.
MGS_FN void shared_adam(const Shared& p, int n, float gradient) {
  const Trained& t = p.tensor;
  if (!p.bits) {
    float grown = p.initial * expf(t.values[n]);
    gradient *= grown >= p.least && grown <= p.most ? grown : 0.0f;
  }
  if (t.grad) gradient += t.grad[n];
  adam(t, gradient, t.values + n, t.mean + n, t.square + n);
}

}  // namespace
