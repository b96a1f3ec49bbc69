// libFuzzer target for decode.h: any bytes, into outputs of exactly the sizes that it names.
//
// An input is a byte `way`, a u32 `count`, a u16 `alphabet`, then the stream. The highest bit of `way`
// corrects the lengths in a rANS stream, so that the code after them runs. The bit `WIDE` allows counts
// large enough for every number of lanes.
#include <cstring>
#include <vector>

#include "../../mobilegs/csrc/decode.h"
#include "input.h"

namespace {

constexpr int HEAD = 7, RANS_HEAD = 12, LANES_MAX = 256;
constexpr uint32_t COUNT_MAX = 1 << 14, COUNT_MAX_WIDE = 2048 * (LANES_MAX + 16), WIDE = 32;
enum Way { RANS, BITS, POSITIONS };

// Makes the header of the stream at `rans` agree with its length.
void fit(std::vector<uint8_t>& bytes, size_t rans, uint32_t count, uint16_t alphabet) {
  if (bytes.size() < rans + RANS_HEAD + 4) return;
  uint32_t lanes = 1;
  while (lanes < LANES_MAX && 2 * lanes <= count / 2048) lanes *= 2;
  uint32_t tables, room = uint32_t(bytes.size() - rans - RANS_HEAD);
  std::memcpy(&tables, &bytes[rans + 4], 4);
  if (room < 4 * lanes) return;
  room -= 4 * lanes;
  if (tables > room) tables %= room + 1;
  if ((room - tables) % 2) tables ^= 1;
  if (tables > room) return;
  uint32_t words = (room - tables) / 2;
  uint16_t contexts;
  std::memcpy(&contexts, &bytes[rans + 2], 2);
  if (contexts != 1) contexts = alphabet;
  std::memcpy(&bytes[rans], &alphabet, 2);
  std::memcpy(&bytes[rans + 2], &contexts, 2);
  std::memcpy(&bytes[rans + 4], &tables, 4);
  std::memcpy(&bytes[rans + 8], &words, 4);
  for (uint32_t lane = 0; lane < lanes; lane++)  // no state below 2^16
    bytes[rans + RANS_HEAD + tables + 4 * lane + 2] |= 1;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < HEAD) return 0;
  uint32_t count;
  uint16_t alphabet;
  std::memcpy(&count, data + 1, 4);
  std::memcpy(&alphabet, data + 5, 2);
  count %= data[0] & WIDE ? COUNT_MAX_WIDE : COUNT_MAX;
  std::vector<uint8_t> bytes(data + HEAD, data + size);
  Way way = Way((data[0] & 127) % 3);
  if (data[0] & 128 && way == RANS) fit(bytes, 0, count, alphabet);
  Exact<uint8_t> stream(bytes.size());
  if (!bytes.empty()) std::memcpy(stream.data, bytes.data(), bytes.size());

  if (way == RANS) {
    Exact<uint16_t> symbols(count);
    if (!mgs_decode_rans(stream.data, bytes.size(), count, alphabet, symbols.data))
      for (uint32_t i = 0; i < count; i++)
        if (symbols.data[i] >= alphabet) std::abort();
  } else if (way == BITS) {
    Exact<uint8_t> widths(count);  // of one width, or of those that the stream begins with
    for (uint32_t i = 0; i < count; i++)
      widths.data[i] = data[0] & 64 && i < bytes.size() ? bytes[i] % 32 : uint8_t(alphabet);
    Exact<uint16_t> numbers(count);
    if (!mgs_unpack_short(stream.data, bytes.size(), widths.data, count, numbers.data))
      for (uint32_t i = 0; i < count; i++)
        if (numbers.data[i] >> widths.data[i]) std::abort();
  } else {
    if (data[0] & 128 && bytes.size() > 4) {
      std::vector<uint8_t> coded(bytes.begin() + 4, bytes.end());
      uint32_t length;
      std::memcpy(&length, bytes.data(), 4);
      length %= uint32_t(coded.size()) + 1;
      coded.resize(length);
      fit(coded, 0, count, 49);
      std::memcpy(stream.data, &length, 4);
      if (length) std::memcpy(stream.data + 4, coded.data(), length);
    }
    Exact<uint16_t> halves(3 * size_t(count));
    if (!mgs_decode_positions(stream.data, bytes.size(), count, halves.data))
      for (size_t i = 0; i < 3 * size_t(count); i++)
        if ((halves.data[i] & 0x7C00) == 0x7C00) std::abort();
  }
  return 0;
}
