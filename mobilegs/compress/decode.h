// Decoders of a .mgs file's streams (docs/format.md, sections 4 and 5), which trust no byte.
//
// Each returns 0 if the stream is whole and sound; anything else means that it is damaged, or that
// there was no memory for its tables, and what has been written so far is of no use. The caller
// owns all memory: `data` has `bytes` bytes and may lie anywhere, outputs have exactly the sizes
// given. Beside them a decoder takes at most 3 MiB, whatever the stream says.
#pragma once
#include <stdint.h>

#define MGS_EXPORT __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

// `rans`: `count` symbols below `alphabet` (1 to 4096) into symbols[count].
MGS_EXPORT int mgs_decode_rans(const uint8_t* data, int64_t bytes, int64_t count, int32_t alphabet,
                               uint16_t* symbols);

// Numbers of widths[i] bits each (0 to 48) one after the other, into numbers[count].
MGS_EXPORT int mgs_unpack_bits(const uint8_t* data, int64_t bytes, const uint8_t* widths,
                               int64_t count, uint64_t* numbers);

// `morton-class`: the bits of `count` positions, x, y, z each, into halves[3 * count].
MGS_EXPORT int mgs_decode_positions(const uint8_t* data, int64_t bytes, int64_t count,
                                    uint16_t* halves);

#ifdef __cplusplus
}
#endif
