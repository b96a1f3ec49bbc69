// Decoders of a .mgs file's streams (docs/format.md, sections 4 and 5), which trust no byte.
//
// Each returns 0 if the stream is whole and sound, or what is wrong with it: the first thing that
// its definition finds. What has been written so far is then of no use. The caller owns all
// memory: `data` has `bytes` bytes and may lie anywhere, outputs have exactly the sizes given.
// Beside them a decoder takes at most 3 MiB, whatever the stream says.
#pragma once
#include <stdint.h>

// native.py has the sentences.
enum {
  MGS_SOUND = 0,
  MGS_HEADER = 1,  // lengths and sizes do not fit; the caller says it better
  MGS_TABLES_CUT = 2,
  MGS_TABLE_NUMBER = 3,
  MGS_TABLE_SUM = 4,
  MGS_TABLES_LONG = 5,
  MGS_FIRST_STATE = 6,
  MGS_WORDS_CUT = 7,
  MGS_STATE = 8,
  MGS_END = 9,
  MGS_BITS_LENGTH = 10,
  MGS_BITS_END = 11,
  MGS_GRID = 12,
  MGS_NOT_FINITE = 13,
  MGS_NO_MEMORY = 14,
};

#define MGS_EXPORT __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

// `rans`: `count` symbols below `alphabet` (1 to 4096) into symbols[count].
MGS_EXPORT int mgs_decode_rans(const uint8_t* data, int64_t bytes, int64_t count, int32_t alphabet,
                               uint16_t* symbols);

// scalar_streams.py's join: columns[many] of `count` symbols each, and what the least of a column
// stands for, into out[count][many].
MGS_EXPORT void mgs_join(int64_t count, int32_t many, const uint16_t* const* columns,
                         const int32_t* least, int32_t* out);

// `bits`: numbers of widths[i] bits each (0 to 16) one after the other, into numbers[count].
MGS_EXPORT int mgs_unpack_short(const uint8_t* data, int64_t bytes, const uint8_t* widths,
                                int64_t count, uint16_t* numbers);

// `morton-class`: the bits of `count` positions, x, y, z each, into halves[3 * count].
MGS_EXPORT int mgs_decode_positions(const uint8_t* data, int64_t bytes, int64_t count,
                                    uint16_t* halves);

// rotations.py's finer_bits_of: for each axis of codes[count][3], times `step`, the entry of
// table[most + 1] at 256 times the difference of the two others.
MGS_EXPORT void mgs_finer_bits(const int32_t* codes, int64_t count, float step,
                               const uint8_t* table, int32_t most, uint8_t* bits);

#ifdef __cplusplus
}
#endif
