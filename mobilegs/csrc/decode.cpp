// Loops over symbols that decode a .mgs file. The references are rans.py, bits.py, positions.py and
// rotations.py. Every length is checked before it is used: no input reads outside of `data`.
#include "decode.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files are read without swapping bytes");

namespace {

constexpr int PRECISION = 14, TOTAL = 1 << PRECISION;
constexpr uint32_t STATE_LOW = 1 << 16;
constexpr int ALPHABET_MAX = 4096, CONTEXTS_MAX = 64, LANES_MAX = 256, LANE_SYMBOLS = 2048;
constexpr int HEADER = 12, SHORT_MAX = 16, AXIS_BITS = 16, CLASSES = 3 * AXIS_BITS + 1;
constexpr int64_t ROWS = 1024;  // rows per pass of mgs_join_columns, which fit in the cache
constexpr int BLOCK = 32;  // rounds whose symbols are buffered before they go to their lanes

template <class T>
T load(const uint8_t* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

// Reads numbers from a stream of bits, lowest bit first. Reading beyond the end gives zeros: the
// caller checks `over` or knows the length.
class Bits {
 public:
  Bits(const uint8_t* data, int64_t bytes) : data_(data), bytes_(bytes) {}

  uint64_t take(int width) {  // 0 to 48
    int64_t byte = position_ >> 3;
    uint64_t word = 0;
    if (byte + 8 <= bytes_)
      word = load<uint64_t>(data_ + byte);
    else if (byte < bytes_)
      std::memcpy(&word, data_ + byte, bytes_ - byte);
    word >>= position_ & 7;
    position_ += width;
    return word & ((uint64_t(1) << width) - 1);
  }
  bool over() const { return position_ > 8 * bytes_; }
  // True if less than a byte is left, all zeros.
  bool at_end() {
    int64_t left = 8 * bytes_ - position_;
    return left >= 0 && left < 8 && take(int(left)) == 0;
  }
  // The error code of a stream that must hold exactly `total` bits.
  int error_for(int64_t total) const {
    if (bytes_ != (total + 7) / 8) return MGS_BITS_LENGTH;
    return total % 8 && data_[bytes_ - 1] >> total % 8 ? MGS_BITS_END : MGS_VALID;
  }

 private:
  const uint8_t* data_;
  int64_t bytes_, position_ = 0;
};

// Symbols and frequencies by the low bits of a state, for each context.
struct Tables {
  int contexts, alphabet;
  std::unique_ptr<uint16_t[]> symbols;  // [contexts][TOTAL]
  std::unique_ptr<uint32_t[]> spans;    // [contexts][alphabet], start << 15 | frequency

  // Zeros: frequency 0 marks an unused context.
  Tables(int contexts, int alphabet)
      : contexts(contexts),
        alphabet(alphabet),
        symbols(new (std::nothrow) uint16_t[size_t(contexts) * TOTAL]()),
        spans(new (std::nothrow) uint32_t[size_t(contexts) * alphabet]()) {}

  // Returns the code of the first error. Beyond the end all bits are zeros.
  int read(Bits bits) {
    if (!symbols || !spans) return MGS_NO_MEMORY;
    for (int context = 0; context < contexts; context++) {
      if (!bits.take(1)) continue;
      int error = read_context(bits, context);
      if (bits.over()) return MGS_TABLES_CUT;
      if (error) return error;
    }
    if (bits.over()) return MGS_TABLES_CUT;
    return bits.at_end() ? MGS_VALID : MGS_TABLES_LONG;
  }
  // True if context 0 is used, in which every lane starts.
  bool used_first() const { return spans[symbols[0]] != 0; }

 private:
  int read_context(Bits& bits, int context) {
    uint32_t* span = &spans[size_t(context) * alphabet];
    int last = -1;
    for (int symbol = 0; symbol < alphabet; symbol++)
      if ((span[symbol] = uint32_t(bits.take(1)))) last = symbol;
    int k = int(bits.take(4)), sum = 0;
    for (int symbol = 0; symbol < last; symbol++) {
      if (!span[symbol]) continue;
      int frequency = golomb(bits, k);
      if (!frequency) return MGS_TABLE_NUMBER;
      span[symbol] = uint32_t(frequency);
      sum += frequency;
    }
    if (last < 0 || sum >= TOTAL) return MGS_TABLE_SUM;
    span[last] = uint32_t(TOTAL - sum);
    for (int symbol = 0, start = 0; symbol <= last; symbol++) {
      int frequency = int(span[symbol]);
      if (!frequency) continue;
      span[symbol] = uint32_t(start << 15 | frequency);
      std::fill_n(&symbols[size_t(context) * TOTAL + start], frequency, uint16_t(symbol));
      start += frequency;
    }
    return MGS_VALID;
  }

  // Reads a frequency, at most 2^15 - 1; 0 is an error.
  static int golomb(Bits& bits, int k) {
    int64_t width = k;
    while (!bits.take(1)) {
      if (bits.over()) return 0;
      width++;
    }
    return width > PRECISION ? 0 : int(bits.take(int(width))) + (1 << width) - (1 << k) + 1;
  }
};

// The words of a stream and the lanes that read them in turn.
struct Lanes {
  const Tables& tables;
  const uint8_t *word, *end;
  uint32_t states[LANES_MAX];
  uint16_t before[LANES_MAX] = {};  // each lane's last symbol, its context
  int error = MGS_VALID;

  // Decodes a symbol for each of the first `active` lanes; false sets `error`. Without CHECKED there
  // must be at least `active` words.
  template <bool CHECKED, bool CONTEXTUAL>
  bool decode_round(int active, uint16_t* row) {
    const uint16_t* symbols = tables.symbols.get();
    const uint32_t* spans = tables.spans.get();
    const uint8_t* next_word = word;
    for (int lane = 0; lane < active; lane++) {
      uint32_t context = CONTEXTUAL ? before[lane] : 0;
      uint32_t state = states[lane], slot = state % TOTAL;
      uint16_t symbol = symbols[context * TOTAL + slot];
      uint32_t span = spans[context * tables.alphabet + symbol];
      if (CONTEXTUAL && span == 0) return fail(lane, active, next_word);
      uint32_t next = (span & 0x7FFF) * (state / TOTAL) + slot - (span >> 15);
      // One word is enough, since `next` is at least 4. A branch would be mispredicted half of the
      // time.
      uint32_t few = next < STATE_LOW;
      if (CHECKED && few > (next_word < end)) return fail(lane, active, next_word);
      uint32_t found = CHECKED && !few ? 0 : load<uint16_t>(next_word);
      states[lane] = next << 16 * few | (found & -few);
      next_word += 2 * few;
      row[lane] = symbol;
      if (CONTEXTUAL) before[lane] = symbol;
    }
    word = next_word;
    return true;
  }

  // A round fails at `lane`: words are missing for the rest of the lanes, or else its context is
  // unused.
  [[gnu::cold, gnu::noinline]] bool fail(int lane, int active, const uint8_t* next_word) {
    int64_t missing = 0;
    for (; lane < active; lane++) {
      uint32_t state = states[lane], slot = state % TOTAL, context = before[lane];
      uint16_t symbol = tables.symbols[context * TOTAL + slot];
      uint32_t span = tables.spans[context * tables.alphabet + symbol];
      missing += (span & 0x7FFF) * (state / TOTAL) + slot - (span >> 15) < STATE_LOW;
    }
    error = missing > (end - next_word) / 2 ? MGS_WORDS_CUT : MGS_STATE;
    return false;
  }

  template <bool CONTEXTUAL>
  bool next(int active, uint16_t* row) {
    return end - word < 2 * active ? decode_round<true, CONTEXTUAL>(active, row)
                                   : decode_round<false, CONTEXTUAL>(active, row);
  }
};

int lane_count(int64_t count) {
  int lanes = 1;
  while (lanes < LANES_MAX && 2 * lanes <= count / LANE_SYMBOLS) lanes *= 2;
  return lanes;
}

// Decodes a run of `rounds` symbols for each of `many` lanes, one more for the first `longer`.
template <bool CONTEXTUAL>
bool decode_lanes(Lanes& lanes, int many, int64_t rounds, int longer, uint16_t* symbols) {
  uint16_t rows[BLOCK][LANES_MAX];
  for (int64_t from = 0; from <= rounds; from += BLOCK) {
    int block = int(std::min<int64_t>(rounds + 1 - from, BLOCK));
    for (int t = 0; t < block; t++)
      if (!lanes.next<CONTEXTUAL>(from + t < rounds ? many : longer, rows[t])) return false;
    for (int lane = 0; lane < many; lane++) {
      uint16_t* out = symbols + lane * rounds + std::min(lane, longer) + from;
      int own = lane < longer ? block : int(std::min<int64_t>(rounds - from, block));
      for (int t = 0; t < own; t++) out[t] = rows[t][lane];
    }
  }
  return true;
}

// Gathers every third bit of a Morton code.
uint16_t gather_axis(uint64_t code) {
  code &= 0x9249249249249249;
  code = (code | code >> 2) & 0x30C30C30C30C30C3;
  code = (code | code >> 4) & 0xF00F00F00F00F00F;
  code = (code | code >> 8) & 0x00FF0000FF0000FF;
  code = (code | code >> 16) & 0xFFFF00000000FFFF;
  return uint16_t(code | code >> 32);
}

}  // namespace

int mgs_interface() { return MGS_INTERFACE; }

int mgs_decode_rans(const uint8_t* data, int64_t bytes, int64_t count, int32_t alphabet,
                    uint16_t* symbols) {
  if (bytes < HEADER || count < 0 || alphabet < 1 || alphabet > ALPHABET_MAX) return MGS_HEADER;
  int contexts = load<uint16_t>(data + 2), lanes = lane_count(count);
  int64_t table_bytes = load<uint32_t>(data + 4), words = load<uint32_t>(data + 8);
  if (load<uint16_t>(data) != alphabet) return MGS_HEADER;
  if ((contexts != 1 && contexts != alphabet) || contexts > CONTEXTS_MAX) return MGS_HEADER;
  if (bytes != HEADER + table_bytes + 4 * lanes + 2 * words) return MGS_HEADER;

  Tables tables(contexts, alphabet);
  if (int error = tables.read(Bits(data + HEADER, table_bytes))) return error;
  const uint8_t* start = data + HEADER + table_bytes;
  Lanes decoder{tables, start + 4 * lanes, data + bytes, {}};
  for (int lane = 0; lane < lanes; lane++) {
    decoder.states[lane] = load<uint32_t>(start + 4 * lane);
    if (decoder.states[lane] < STATE_LOW) return MGS_FIRST_STATE;
  }
  if (count > 0 && !tables.used_first()) return words < lanes ? MGS_WORDS_CUT : MGS_STATE;
  auto run = contexts > 1 ? decode_lanes<true> : decode_lanes<false>;
  if (!run(decoder, lanes, count / lanes, int(count % lanes), symbols)) return decoder.error;
  auto at_start = [](uint32_t state) { return state == STATE_LOW; };
  bool complete = std::all_of(decoder.states, decoder.states + lanes, at_start);
  return complete && decoder.word == decoder.end ? MGS_VALID : MGS_END;
}

int64_t mgs_encode_rans(int64_t count, const int32_t* entries, const uint32_t* frequencies,
                        const uint32_t* starts, uint16_t* words, uint32_t* states) {
  int lanes = lane_count(count);
  std::fill_n(states, lanes, STATE_LOW);
  uint16_t* word = words + count;
  for (int64_t round = (count - 1) / lanes; round >= 0; round--) {
    const int32_t* row = entries + round * lanes;
    for (int lane = int(std::min<int64_t>(lanes, count - round * lanes)) - 1; lane >= 0; lane--) {
      uint32_t x = states[lane], frequency = frequencies[row[lane]];
      if (x >= uint64_t(frequency) << (32 - PRECISION)) *--word = uint16_t(x), x >>= 16;
      states[lane] = (x / frequency << PRECISION) + x % frequency + starts[row[lane]];
    }
  }
  return words + count - word;
}

void mgs_join_columns(int64_t count, int32_t many, const uint16_t* const* columns,
                      const int32_t* least, int32_t* out) {
  for (int64_t from = 0; from < count; from += ROWS) {
    int64_t to = std::min(count, from + ROWS);
    for (int32_t column = 0; column < many; column++)
      for (int64_t i = from; i < to; i++) out[i * many + column] = columns[column][i] + least[column];
  }
}

int mgs_unpack_short(const uint8_t* data, int64_t bytes, const uint8_t* widths, int64_t count,
                     uint16_t* numbers) {
  int64_t total = 0;
  for (int64_t i = 0; i < count; i++) {
    if (widths[i] > SHORT_MAX) return MGS_HEADER;
    total += widths[i];
  }
  Bits bits(data, bytes);
  if (int error = bits.error_for(total)) return error;
  for (int64_t i = 0; i < count; i++) numbers[i] = uint16_t(bits.take(widths[i]));
  return MGS_VALID;
}

int mgs_decode_positions(const uint8_t* data, int64_t bytes, int64_t count, uint16_t* out) {
  if (bytes < 4 || count < 0 || load<uint32_t>(data) > bytes - 4) return MGS_HEADER;
  int64_t coded = load<uint32_t>(data);
  // Classes fill the last third of the output: each is read just before it is overwritten.
  const uint16_t* classes = out + 2 * count;
  if (int error = mgs_decode_rans(data + 4, coded, count, CLASSES, out + 2 * count)) return error;
  int64_t total = 0;
  for (int64_t i = 0; i < count; i++) total += std::max(classes[i] - 1, 0);
  Bits bits(data + 4 + coded, bytes - 4 - coded);
  if (int error = bits.error_for(total)) return error;

  uint64_t code = 0;
  bool finite = true;
  for (int64_t i = 0; i < count; i++) {
    int width = classes[i] - 1;
    if (width >= 0) code += uint64_t(1) << width | bits.take(width);
    if (code >> 3 * AXIS_BITS) return MGS_GRID;
    for (int axis = 0; axis < 3; axis++) {
      uint16_t number = gather_axis(code >> axis);
      uint16_t half = number & 0x8000 ? number & 0x7FFF : ~number;
      finite &= (half & 0x7C00) != 0x7C00;  // neither infinite nor NaN
      out[3 * i + axis] = half;
    }
  }
  return finite ? MGS_VALID : MGS_NOT_FINITE;
}

void mgs_refinement_bits(const int32_t* codes, int64_t count, float step_size,
                         const uint8_t* table, int32_t most, uint8_t* bits) {
  for (int64_t i = 0; i < 3 * count; i += 3) {
    float a = float(codes[i]) * step_size, b = float(codes[i + 1]) * step_size;
    float c = float(codes[i + 2]) * step_size;
    float apart[3] = {b - c, a - c, a - b};
    for (int axis = 0; axis < 3; axis++)
      bits[i + axis] = table[int32_t(std::min(std::fabs(apart[axis]) * 256.0f, float(most)))];
  }
}
