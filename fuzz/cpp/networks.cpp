// libFuzzer target for networks.cpp: codebook look-ups, colours and lobes of any latents and weights;
// and for the two loops of decode.h that take numbers instead of bytes.
//
// The shapes are those that the header of a file may announce; weights, latents and positions are any
// finite float16 numbers, as the decoder of a file checks them. Each result must be finite, and each
// row must be the same, bit by bit, when it is decoded by itself.
#include <cmath>
#include <memory>
#include <vector>

#include "../../mobilegs/csrc/decode.h"
#include "../../mobilegs/csrc/networks.cpp"
#include "input.h"

namespace {

constexpr int COUNT_MOST = 2 * GROUP + 3;
constexpr int ENTRIES_MOST = 40, COORDINATES = 3, COLUMNS_MOST = 6;
constexpr int CODE_MAX = 1 << 14;               // the largest magnitude of a code in a file
constexpr float STEP_MIN = 1e-5f, STEP_MAX = 1e3f;  // the step sizes that a file may have

// Finite float16 numbers from the input, as floats; when it ends they repeat with changed signs.
class Numbers {
 public:
  explicit Numbers(Input& input) {
    while (input.left() && patterns_.size() < 4096) patterns_.push_back(input.take<uint16_t>());
    if (patterns_.empty()) patterns_.push_back(0);
  }
  float next() {
    uint16_t pattern = patterns_[at_ % patterns_.size()] ^ uint16_t(at_ / patterns_.size() << 15);
    at_++;
    int exponent = pattern >> 10 & 31, fraction = pattern & 1023;
    if (exponent == 31) exponent = 30;  // neither infinite nor NaN
    float size = exponent ? std::ldexp(1.0f + float(fraction) / 1024, exponent - 15)
                          : std::ldexp(float(fraction), -24);
    return pattern >> 15 ? -size : size;
  }
  void fill(Exact<float>& out) {
    for (size_t i = 0; i < out.size; i++) out[i] = next();
  }

 private:
  std::vector<uint16_t> patterns_;
  size_t at_ = 0;
};

void check(bool fine) {
  if (!fine) std::abort();
}

void check_row(const float* row, const Exact<float>& single) {
  check(std::memcmp(row, single.data, 4 * single.size) == 0);
  for (size_t i = 0; i < single.size; i++) check(std::isfinite(row[i]));
}

void look_up(Input& input) {
  int64_t count = input.between(0, COUNT_MOST);
  int books = int(input.between(1, 6)), length = int(input.between(1, 8));
  int size = int(input.between(1, ENTRIES_MOST));
  Exact<int16_t> indices(size_t(count * books));
  Exact<float> centers(size_t(books * size * length)), values(size_t(count * books * length));
  bool stray = false;
  for (size_t i = 0; i < indices.size; i++) {
    uint16_t given = input.take<uint16_t>();
    // most are in range, so that look-ups succeed
    indices[i] = int16_t(given & 0xFF00 ? given % size : given);
    stray |= indices[i] < 0 || indices[i] >= size;
  }
  Numbers(input).fill(centers);
  int found = mgs_gather_entries(count, indices.data, centers.data, books, size, length, values.data);
  check(found == stray);
  if (stray) return;
  for (size_t i = 0; i < indices.size; i++)
    for (int j = 0; j < length; j++)
      check(values[i * length + j] ==
            centers[((i % books) * size + indices[i]) * size_t(length) + j]);
}

void colors(Input& input) {
  int64_t count = input.between(0, COUNT_MOST), row = input.between(0, COUNT_MOST);
  const int rests[] = {0, 9, 24, 45};
  int rest = rests[input.between(0, 3)];
  int64_t stride = input.between(LATENTS, 2 * LATENTS);
  size_t size = HIDDEN * ENCODED + CONTEXT * HIDDEN + 2 * HIDDEN * JOINED + (3 + rest) * HIDDEN;
  // a slice of a matrix: nothing follows the last row's numbers
  size_t latents = count ? size_t((count - 1) * stride + LATENTS) : 0;
  Exact<float> positions(size_t(COORDINATES * count)), statics(latents), views(latents);
  Exact<float> weights(size), sh(size_t(count * (3 + rest))), single(size_t(3 + rest));
  Numbers numbers(input);
  for (auto* part : {&positions, &statics, &views, &weights}) numbers.fill(*part);
  mgs_decode_colors(count, positions.data, statics.data, stride, views.data, stride, weights.data,
                    rest, sh.data);
  if (!count) return;
  row %= count;
  mgs_decode_colors(1, positions.data + COORDINATES * row, statics.data + stride * row, stride,
                    views.data + stride * row, stride, weights.data, rest, single.data);
  check_row(sh.data + row * (3 + rest), single);
}

void lobes(Input& input) {
  int64_t count = input.between(0, COUNT_MOST), row = input.between(0, COUNT_MOST);
  int latent_count = int(input.between(0, LATENTS_MAX)), degree = int(input.between(0, 3));
  int outputs = 2 * (degree + 1) * (degree + 1), layers = int(input.between(0, 3));
  const int harmonics[] = {3, 12, 27, 48};
  int sh_size = harmonics[input.between(0, 3)];
  bool base = input.between(0, 1);
  Exact<int32_t> widths{size_t(layers)};
  size_t size = 0, columns = size_t(STATICS + latent_count);
  for (int i = 0; i < layers; i++) {
    // mostly narrow, for speed
    widths[i] = int32_t(input.between(0, 7) ? input.between(1, 9) : input.between(1, HIDDEN_MAX));
    size += size_t(widths[i]) * (1 + columns);
    columns = size_t(widths[i]);
  }
  if (!layers) columns = 0;
  size += size_t(outputs) * (1 + columns + size_t(latent_count) + base);
  size_t rows = size_t(count);
  Exact<float> latents(rows * latent_count), logits(base ? rows : 0), sh(rows * sh_size);
  Exact<float> log_scales(rows * SCALES), quats(rows * TURNS), weights(size);
  Exact<float> found(rows * outputs), single{size_t(outputs)};
  Numbers numbers(input);
  for (auto* part : {&latents, &logits, &sh, &log_scales, &quats, &weights}) numbers.fill(*part);
  for (size_t i = 0; i < log_scales.size; i++)  // of at most 80, as a file's
    if (log_scales[i] > 80) log_scales[i] = 80;
  auto decode = [&](int64_t first, int64_t many, float* out) {
    mgs_decode_lobes(many, latents.data + first * latent_count, latent_count,
                     base ? logits.data + first : nullptr, sh.data + first * sh_size, sh_size,
                     log_scales.data + first * SCALES, quats.data + first * TURNS, weights.data,
                     widths.data, layers, outputs, out);
  };
  decode(0, count, found.data);
  if (!count) return;
  row %= count;
  decode(row, 1, single.data);
  check_row(found.data + row * outputs, single);
}

void join(Input& input) {
  int64_t count = input.between(0, 3000);
  int many = int(input.between(1, COLUMNS_MOST));
  const uint16_t* columns[COLUMNS_MOST];
  std::unique_ptr<Exact<uint16_t>> held[COLUMNS_MOST];
  Exact<int32_t> least{size_t(many)}, out(size_t(count * many));
  for (int c = 0; c < many; c++) {
    least[c] = int32_t(input.between(-CODE_MAX, CODE_MAX));
    held[c] = std::make_unique<Exact<uint16_t>>(size_t(count));
    columns[c] = held[c]->data;
  }
  for (int c = 0; c < many; c++)
    for (int64_t i = 0; i < count; i++) (*held[c])[i] = input.take<uint16_t>();
  mgs_join_columns(count, many, columns, least.data, out.data);
  for (int64_t i = 0; i < count; i++)
    for (int c = 0; c < many; c++) check(out[i * many + c] == columns[c][i] + least[c]);
}

void refine(Input& input) {
  int64_t count = input.between(0, 300);
  int most = int(input.between(0, 2000));
  Exact<uint8_t> table(size_t(most) + 1), bits(size_t(COORDINATES * count));
  Exact<int32_t> codes(size_t(COORDINATES * count));
  for (int i = 0; i <= most; i++) table[i] = uint8_t(i * 9 / (most + 1));
  float step = input.take<float>();
  if (!(step >= STEP_MIN && step <= STEP_MAX)) step = STEP_MAX;
  for (size_t i = 0; i < codes.size; i++) codes[i] = int32_t(input.between(-CODE_MAX, CODE_MAX));
  mgs_refinement_bits(codes.data, count, step, table.data, most, bits.data);
  for (size_t i = 0; i < bits.size; i++) check(bits[i] <= 8);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Input input(data, size);
  switch (input.take<uint8_t>() % 5) {
    case 0: look_up(input); break;
    case 1: colors(input); break;
    case 2: lobes(input); break;
    case 3: join(input); break;
    default: refine(input);
  }
  return 0;
}
