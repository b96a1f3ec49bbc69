// Decoders of a .mgs file's streams (docs/reference/format.md, sections 4 and 5) for untrusted input,
// and the loop that encodes `rans`.
//
// A decoder returns 0 for a valid stream, or the code of the first error that its reference finds; the
// output is then undefined. The caller owns all memory: `data` has `bytes` bytes of any alignment,
// outputs have exactly the sizes given. A decoder allocates at most 3 MiB for any input.
#pragma once
#include <stdint.h>

// The version of all functions of this library, which binding.py checks: increase it with every
// change of their names, arguments or structs.
#define MGS_INTERFACE 10

// binding.py has their messages.
enum {
  MGS_VALID = 0,
  MGS_HEADER = 1,  // lengths and sizes disagree; the caller has a better message
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

MGS_EXPORT int mgs_interface();

// `rans`: `count` symbols below `alphabet` (1 to 4096) into symbols[count].
MGS_EXPORT int mgs_decode_rans(const uint8_t* data, int64_t bytes, int64_t count, int32_t alphabet,
                               uint16_t* symbols);

// rans.py's encode_rounds: codes `count` symbols in lanes; entries[rounds][lanes] are their places in
// the tables. Returns the number of words, which lie at the end of words[count]; the lanes' states
// are in states[lanes].
MGS_EXPORT int64_t mgs_encode_rans(int64_t count, const int32_t* entries,
                                   const uint32_t* frequencies, const uint32_t* starts,
                                   uint16_t* words, uint32_t* states);

// uniform_streams.py's join_columns: columns[many] of `count` symbols each, plus least[many], into
// out[count][many].
MGS_EXPORT void mgs_join_columns(int64_t count, int32_t many, const uint16_t* const* columns,
                                 const int32_t* least, int32_t* out);

// `bits`: consecutive numbers of widths[i] bits each (0 to 16) into numbers[count].
MGS_EXPORT int mgs_unpack_short(const uint8_t* data, int64_t bytes, const uint8_t* widths,
                                int64_t count, uint16_t* numbers);

// `morton-class`: the float16 patterns of `count` positions, x, y, z each, into out[3 * count].
MGS_EXPORT int mgs_decode_positions(const uint8_t* data, int64_t bytes, int64_t count,
                                    uint16_t* out);

// rotations.py's refinement_bits_of: for each axis of codes[count][3] the entry of table[most + 1]
// at 256 times the difference of the two others, in units of `step_size`.
MGS_EXPORT void mgs_refinement_bits(const int32_t* codes, int64_t count, float step_size,
                                    const uint8_t* table, int32_t most, uint8_t* bits);

#ifdef __cplusplus
}
#endif
