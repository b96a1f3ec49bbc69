// Codebook look-ups and the networks that decode the Gaussians of a .mgs file. The references are
// codebooks.py, appearance.py and lobes.py. A tile of Gaussians passes through all layers while it
// is in the cache, one Gaussian per SIMD lane: results do not depend on threads or neighbours.
#include "lanes.h"
#include "parallel.h"

#include <algorithm>
#include <cmath>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int TILE = 64;                   // Gaussians
constexpr int SPAN = LANES == 16 ? 4 : 2;  // vectors per unit whose sums stay in registers
constexpr int ROWS = 4;                    // units at a time
constexpr int AXES = 3, OCTAVES = 16, ENCODED = 2 * AXES * OCTAVES;
constexpr int HIDDEN = 64, CONTEXT = 13, LATENTS = 3, JOINED = CONTEXT + LATENTS;
constexpr int COLOR = 12, SCALES = 3, TURNS = 4, STATICS = COLOR + SCALES + TURNS;
constexpr int LATENTS_MAX = 32, HIDDEN_MAX = 256, OUTPUTS_MAX = 32, REST_MAX = 45;
constexpr float LENGTH_MIN = 1e-12f;

using Row = float[TILE];  // one number per Gaussian of a tile

// Transpose rows [from, from + many) of a matrix, columns [0, width), into a tile, and back. The
// rest of the tile is zeros.
void load_tile(const float* matrix, int64 stride, int64 from, int many, int width, Row* rows) {
  for (int column = 0; column < width; column++) {
    const float* source = matrix + from * stride + column;
    for (int i = 0; i < many; i++) rows[column][i] = source[i * stride];
    std::fill(rows[column] + many, rows[column] + TILE, 0.0f);
  }
}
void store_tile(const Row* rows, int64 stride, int64 from, int many, int width, float* matrix) {
  for (int i = 0; i < many; i++)
    for (int column = 0; column < width; column++)
      matrix[(from + i) * stride + column] = rows[column][i];
}

// activate(offset + weights . input) for the units [row, row + MANY) of a layer.
template <int MANY, class Activate>
void some_units(const float* weights, const float* offsets, int columns, int row, const Row* in,
                Row* out, Activate activate) {
  const float* weight = weights + (int64)row * columns;
  for (int at = 0; at < TILE; at += SPAN * LANES) {
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
      for (int s = 0; s < SPAN; s++) store(&out[row + r][at + s * LANES], activate(sums[r][s]));
  }
}

template <class Activate>
void layer(const float* weights, const float* offsets, int rows, int columns, const Row* in,
           Row* out, Activate activate) {
  int row = 0;
  for (; row + ROWS <= rows; row += ROWS)
    some_units<ROWS>(weights, offsets, columns, row, in, out, activate);
  for (; row < rows; row++) some_units<1>(weights, offsets, columns, row, in, out, activate);
}

const auto identity = [](vfloat x) { return x; };
const auto relu = [](vfloat x) { return max_of(x, vfloat{}); };
const auto leaky = [](vfloat x) { return max_of(x, 0.01f * x); };

// Rounds a product to float32: the compiler must not fuse it with the following sum.
MGS_FN vfloat rounded(vfloat x) {
  asm("" : "+m"(x));
  return x;
}
MGS_FN vfloat root(vfloat x) {
  for (int i = 0; i < LANES; i++) x[i] = std::sqrt(x[i]);
  return x;
}

// Contracts normalised positions into [0, 1]^3, bit for bit like `contract` of appearance.py.
void contract(const Row* position, Row* unit) {
  for (int at = 0; at < TILE; at += LANES) {
    vfloat u[AXES], square[AXES];
    for (int a = 0; a < AXES; a++) {
      u[a] = load(&position[a][at]);
      square[a] = rounded(u[a] * u[a]);
    }
    vfloat length = root(square[0] + square[1] + square[2]);
    length = max_of(length, splat_value(length, 1.0f));
    vfloat shrink = 2.0f - 1.0f / length;
    for (int a = 0; a < AXES; a++)
      store(&unit[a][at], rounded(shrink * (u[a] / length)) * 0.25f + 0.5f);
  }
}

// sin(2 pi t) for |t| <= 1/4, to 5e-8.
MGS_FN vfloat sine_of_turns(vfloat t) {
  vfloat square = t * t;
  vfloat sum = square * 39.536705017089844f + -76.5497817993164f;
  sum = sum * square + 81.60100555419922f;
  sum = sum * square + -41.34165573120117f;
  return t * (sum * square + 6.283185005187988f);
}

// Sines of every octave of all axes, then their cosines.
void encode_frequencies(const Row* unit, Row* encoded) {
  for (int a = 0; a < AXES; a++)
    for (int at = 0; at < TILE; at += LANES) {
      vfloat turns = 0.5f * load(&unit[a][at]);
      for (int k = 0; k < OCTAVES; k++, turns += turns) {
        // adding and subtracting 1.5 * 2^23 rounds to an integer
        vfloat part = turns - (turns + 12582912.0f - 12582912.0f);
        vfloat size = max_of(part, -part);
        // reflect at a quarter of a turn
        vfloat folded = max_of(min_of(part, 0.5f - part), -0.5f - part);
        int row = a * OCTAVES + k;
        store(&encoded[row][at], sine_of_turns(folded));
        store(&encoded[ENCODED / 2 + row][at], sine_of_turns(0.25f - size));
      }
    }
}

// Divides rows by their common length, like torch's `normalize`.
void normalise(Row* rows, int many) {
  for (int at = 0; at < TILE; at += LANES) {
    vfloat square = {};
    for (int r = 0; r < many; r++) square += load(&rows[r][at]) * load(&rows[r][at]);
    vfloat length = root(square);
    length = max_of(length, splat_value(length, LENGTH_MIN));
    for (int r = 0; r < many; r++) store(&rows[r][at], load(&rows[r][at]) / length);
  }
}

// Runs work(from, many) for all tiles of `count` Gaussians.
template <class Work>
void for_tiles(int64 count, Work work) {
  parallel_for(count, 16 * TILE, [&](int64 from, int64 to) {
    for (; from < to; from += TILE) work(from, (int)std::min<int64>(TILE, to - from));
  });
}

}  // namespace

// Copies the entries of `books` codebooks [books][size][length] at indices [count][books] into
// values [count][books][length]. Returns 0, or 1 if an index is out of range.
EXPORT int mgs_gather_entries(int64 count, const int16_t* indices, const float* centers, int books,
                              int size, int length, float* values) {
  std::atomic<int> strays{0};
  parallel_parts(count, [&](int64 from, int64 to) {
    int found = 0;
    for (int64 i = from; i < to; i++)
      for (int b = 0; b < books; b++) {
        int index = indices[i * books + b];
        bool stray = index < 0 || index >= size;
        found |= stray;
        const float* entry = centers + ((int64)b * size + (stray ? 0 : index)) * length;
        for (int j = 0; j < length; j++) values[(i * books + b) * length + j] = entry[j];
      }
    strays |= found;
  });
  return strays;
}

// Harmonics [count][3 + rest] of positions and latents, [count][3] each, with rows of latents
// `stride` floats apart. `weights` are context1, context2, static1, static2, view1 and view2, each
// row by row.
EXPORT void mgs_decode_colors(int64 count, const float* positions, const float* statics,
                              int64 statics_stride, const float* views, int64 views_stride,
                              const float* weights, int rest, float* sh) {
  const float* context2 = weights + HIDDEN * ENCODED;
  const float* static1 = context2 + CONTEXT * HIDDEN;
  const float* static2 = static1 + HIDDEN * JOINED;
  const float* view1 = static2 + 3 * HIDDEN;
  const float* view2 = view1 + HIDDEN * JOINED;
  for_tiles(count, [=](int64 from, int many) {
    alignas(64) Row unit[AXES], encoded[ENCODED], hidden[HIDDEN], joined[JOINED];
    alignas(64) Row out[3 + REST_MAX];
    load_tile(positions, AXES, from, many, AXES, unit);
    contract(unit, unit);
    encode_frequencies(unit, encoded);
    layer(weights, nullptr, HIDDEN, ENCODED, encoded, hidden, relu);
    layer(context2, nullptr, CONTEXT, HIDDEN, hidden, joined, identity);
    load_tile(statics, statics_stride, from, many, LATENTS, joined + CONTEXT);
    layer(static1, nullptr, HIDDEN, JOINED, joined, hidden, leaky);
    layer(static2, nullptr, 3, HIDDEN, hidden, out, identity);
    if (rest) {
      load_tile(views, views_stride, from, many, LATENTS, joined + CONTEXT);
      layer(view1, nullptr, HIDDEN, JOINED, joined, hidden, leaky);
      layer(view2, nullptr, rest, HIDDEN, hidden, out + 3, identity);
    }
    store_tile(out, 3 + rest, from, many, 3 + rest, sh);
  });
}

// Lobes [count][outputs] of latents [count][latents] and of base opacities `logits` [count], which
// may be null. The `layers` hidden layers of the given `widths` also take sh [count][sh_size],
// log_scales [count][3] and quats [count][4]. `weights` are the offsets and the matrix of each
// hidden layer, then the bias and one matrix for the last hidden layer, the latents and the base.
EXPORT void mgs_decode_lobes(int64 count, const float* latents, int latent_count,
                             const float* logits, const float* sh, int sh_size,
                             const float* log_scales, const float* quats, const float* weights,
                             const int32_t* widths, int layers, int outputs, float* lobes) {
  for_tiles(count, [=](int64 from, int many) {
    alignas(64) Row buffers[2][HIDDEN_MAX + LATENTS_MAX + 1], out[OUTPUTS_MAX];
    Row *in = buffers[0], *next = buffers[1];
    const float* offsets = weights;
    int columns = 0;
    if (layers) {
      int known = std::min(sh_size, COLOR);
      load_tile(sh, sh_size, from, many, known, in);
      std::fill(in[known], in[COLOR], 0.0f);
      load_tile(log_scales, SCALES, from, many, SCALES, in + COLOR);
      for (Row* row = in + COLOR; row < in + COLOR + SCALES; row++)
        for (float& scale : *row) scale = std::exp(scale);
      load_tile(quats, TURNS, from, many, TURNS, in + COLOR + SCALES);
      normalise(in, COLOR);
      normalise(in + COLOR, SCALES);
      normalise(in + COLOR + SCALES, TURNS);
      load_tile(latents, latent_count, from, many, latent_count, in + STATICS);
      columns = STATICS + latent_count;
    }
    for (int i = 0; i < layers; i++) {
      layer(offsets + widths[i], offsets, widths[i], columns, in, next, relu);
      offsets += widths[i] * (1 + columns);
      columns = widths[i];
      std::swap(in, next);
    }
    load_tile(latents, latent_count, from, many, latent_count, in + columns);
    columns += latent_count;
    if (logits) load_tile(logits, 1, from, many, 1, in + columns++);
    layer(offsets + outputs, offsets, outputs, columns, in, out, identity);
    store_tile(out, outputs, from, many, outputs, lobes);
  });
}
