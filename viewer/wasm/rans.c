/* The lanes of a rANS stream: rans.js has the reference. */

#include "kernels.h"

/* log2 of the sum of a context's frequencies; PRECISION of rans.js. */
enum { PRECISION = 14 };

typedef struct {
  uint32_t state;
  uint16_t *before; /* the place before the lane's first symbol */
} Lane;

/*
 * Decodes a symbol of each of `count` lanes, `length` times, then one more of the first `longer`.
 *
 * Returns the first word that was not taken, or null where a context occurs that the file does not
 * use. It stops after the step that takes a word from `end` or beyond: callers leave room there for
 * a word of each lane and one more.
 */
INLINE const uint16_t *decode(Lane *lanes, const uint16_t *symbols, const uint32_t *spans, uint32_t alphabet,
                              const uint16_t *word, const uint16_t *end, uint32_t count, uint32_t length,
                              uint32_t longer, int contextual) {
  uint32_t mask = 0; /* the first symbol of a lane has none before it: its context is 0 */
  for (uint32_t step = 0; step <= length; step++) {
    Lane *last = lanes + (step < length ? count : longer);
    for (Lane *lane = lanes; lane < last; lane++) {
      uint32_t state = lane->state;
      uint16_t *before = lane->before + step;
      uint32_t context = contextual ? *before & mask : 0;
      uint32_t slot = state & ((1 << PRECISION) - 1);
      uint32_t symbol = symbols[context << PRECISION | slot];
      uint32_t span = spans[context * alphabet + symbol];
      if (span == 0) return 0;
      uint32_t next = (span & 0x7fff) * (state >> PRECISION) + slot - (span >> 15);
      /* below 2^16 a state takes a word; a branch would be predicted wrong every other time */
      uint32_t takes = next >> 16 == 0;
      lane->state = next << (takes << 4) | (*word & -takes);
      word += takes;
      before[1] = symbol;
    }
    if (word > end) break;
    mask = -1;
  }
  return word;
}

/* For streams with one context. */
const uint16_t *pull_plain(Lane *lanes, const uint16_t *symbols, const uint32_t *spans, uint32_t alphabet,
                           const uint16_t *word, const uint16_t *end, uint32_t count, uint32_t length,
                           uint32_t longer) {
  return decode(lanes, symbols, spans, alphabet, word, end, count, length, longer, 0);
}

/* For streams where the symbol before is the context. */
const uint16_t *pull_contextual(Lane *lanes, const uint16_t *symbols, const uint32_t *spans, uint32_t alphabet,
                                const uint16_t *word, const uint16_t *end, uint32_t count, uint32_t length,
                                uint32_t longer) {
  return decode(lanes, symbols, spans, alphabet, word, end, count, length, longer, 1);
}
