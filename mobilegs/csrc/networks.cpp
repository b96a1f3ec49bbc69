// Codebook look-ups and the networks that decode the Gaussians of a .mgs file. The references are
// codebooks.py, appearance.py and lobes.py. A group of Gaussians passes through all layers while it
// is in the cache, one Gaussian per SIMD lane: results do not depend on threads or neighbours.
#include "group.h"
#include "parallel.h"

#include <algorithm>
#include <cmath>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

constexpr int AXES = 3, OCTAVES = 16, ENCODED = 2 * AXES * OCTAVES;
constexpr int HIDDEN = 64, CONTEXT = 13, LATENTS = 3, JOINED = CONTEXT + LATENTS;
constexpr int LATENTS_MAX = 32, HIDDEN_MAX = 256, OUTPUTS_MAX = 32, REST_MAX = 45;

// Rounds a product to float32: the compiler must not fuse it with the following sum.
MGS_FN vfloat rounded(vfloat x) {
  asm("" : "+m"(x));
  return x;
}

// Contracts normalised positions into [0, 1]^3, bit for bit like `contract` of appearance.py.
void contract(const Column* position, Column* unit) {
  for (int at = 0; at < GROUP; at += LANES) {
    vfloat u[AXES], square[AXES];
    for (int a = 0; a < AXES; a++) {
      u[a] = load(&position[a][at]);
      square[a] = rounded(u[a] * u[a]);
    }
    vfloat length = sqrt_of(square[0] + square[1] + square[2]);
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
void encode_frequencies(const Column* unit, Column* encoded) {
  for (int a = 0; a < AXES; a++)
    for (int at = 0; at < GROUP; at += LANES) {
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

// Runs work(from, many) for all groups of `count` Gaussians.
template <class Work>
void for_groups(int64 count, Work work) {
  parallel_for(count, 16 * GROUP, [&](int64 from, int64 to) {
    for (; from < to; from += GROUP) work(from, (int)std::min<int64>(GROUP, to - from));
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
  for_groups(count, [=](int64 from, int many) {
    alignas(64) Column unit[AXES], encoded[ENCODED], hidden[HIDDEN], joined[JOINED];
    alignas(64) Column out[3 + REST_MAX];
    load_group(positions, AXES, from, many, AXES, unit);
    contract(unit, unit);
    encode_frequencies(unit, encoded);
    layer<RELU>(weights, nullptr, HIDDEN, ENCODED, encoded, hidden);
    layer<IDENTITY>(context2, nullptr, CONTEXT, HIDDEN, hidden, joined);
    load_group(statics, statics_stride, from, many, LATENTS, joined + CONTEXT);
    layer<LEAKY>(static1, nullptr, HIDDEN, JOINED, joined, hidden);
    layer<IDENTITY>(static2, nullptr, 3, HIDDEN, hidden, out);
    if (rest) {
      load_group(views, views_stride, from, many, LATENTS, joined + CONTEXT);
      layer<LEAKY>(view1, nullptr, HIDDEN, JOINED, joined, hidden);
      layer<IDENTITY>(view2, nullptr, rest, HIDDEN, hidden, out + 3);
    }
    store_group(out, 3 + rest, from, many, 3 + rest, sh);
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
  for_groups(count, [=](int64 from, int many) {
    alignas(64) Column buffers[2][HIDDEN_MAX + LATENTS_MAX + 1], out[OUTPUTS_MAX];
    Column *in = buffers[0], *next = buffers[1];
    const float* offsets = weights;
    int columns = 0;
    if (layers) {
      int known = std::min(sh_size, COLOR);
      load_group(sh, sh_size, from, many, known, in);
      std::fill(in[known], in[COLOR], 0.0f);
      load_group(log_scales, SCALES, from, many, SCALES, in + COLOR);
      for (Column* row = in + COLOR; row < in + COLOR + SCALES; row++)
        for (float& scale : *row) scale = std::exp(scale);
      load_group(quats, TURNS, from, many, TURNS, in + COLOR + SCALES);
      normalise(in, COLOR);
      normalise(in + COLOR, SCALES);
      normalise(in + COLOR + SCALES, TURNS);
      load_group(latents, latent_count, from, many, latent_count, in + STATICS);
      columns = STATICS + latent_count;
    }
    for (int i = 0; i < layers; i++) {
      layer<RELU>(offsets + widths[i], offsets, widths[i], columns, in, next);
      offsets += widths[i] * (1 + columns);
      columns = widths[i];
      std::swap(in, next);
    }
    load_group(latents, latent_count, from, many, latent_count, in + columns);
    columns += latent_count;
    if (logits) load_group(logits, 1, from, many, 1, in + columns++);
    layer<IDENTITY>(offsets + outputs, offsets, outputs, columns, in, out);
    store_group(out, outputs, from, many, outputs, lobes);
  });
}
