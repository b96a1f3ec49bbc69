/** Static interleaved rANS, decoded by table look-ups. docs/reference/format.md, section 4. */

import { BitReader, view } from "./bits.js";
import { SceneError } from "./error.js";
import { pullFast } from "./rans_wasm.js";

const PRECISION = 14;
const TOTAL = 1 << PRECISION;
const STATE_LOW = 1 << 16;
const CONTEXTS_MAX = 64;
const LANES_MAX = 256;
const LANE_SYMBOLS = 2048;
// bytes
const HEADER = 12;
/** In the place of words that are left: a context was needed that is not used. */
const UNUSED = -Infinity;

/**
 * The `count` symbols below `alphabet` in a stream.
 *
 * @param {Uint8Array} data
 * @param {number} count
 * @param {number} alphabet
 * @param {boolean} [plain] without WebAssembly
 * @returns {Uint16Array}
 */
export function decodeRans(data, count, alphabet, plain = false) {
  if (data.length < HEADER) throw new SceneError("a rANS stream is too short to hold its header");
  const numbers = view(data);
  const found = numbers.getUint16(0, true);
  const contexts = numbers.getUint16(2, true);
  const tableBytes = numbers.getUint32(4, true);
  const words = numbers.getUint32(8, true);
  if (found !== alphabet) {
    throw new SceneError(`a rANS stream of ${found} symbols stands where ${alphabet} belong`);
  }
  if ((contexts !== 1 && contexts !== alphabet) || contexts > CONTEXTS_MAX) {
    throw new SceneError(`a rANS stream has ${contexts} contexts`);
  }
  const lanes = laneCount(count);
  if (data.length !== HEADER + tableBytes + 4 * lanes + 2 * words) {
    throw new SceneError("a rANS stream is longer or shorter than its header says");
  }
  const start = HEADER + tableBytes;
  const tables = readTables(data.subarray(HEADER, start), contexts, alphabet);
  const states = new Uint32Array(lanes).map((_, i) => numbers.getUint32(start + 4 * i, true));
  if (states.some((state) => state < STATE_LOW)) {
    throw new SceneError("a rANS stream starts in an impossible state");
  }
  const short = Math.floor(count / lanes);
  const longer = count % lanes;
  const first = states.map((_, lane) => lane * short + Math.min(lane, longer));
  const parts = /** @type {const} */ ([tables, states, first, data.subarray(start + 4 * lanes), count]);
  const pulled = (plain ? undefined : pullFast(...parts)) ?? pull(...parts);
  if (pulled.left === UNUSED) {
    throw new SceneError("a rANS stream leads to a context that is not used: it is damaged");
  }
  if (pulled.left < 0) throw new SceneError("a rANS stream ends early: the file is damaged");
  if (pulled.left > 0 || pulled.states.some((state) => state !== STATE_LOW)) {
    throw new SceneError("a rANS stream does not end where it should: the file is damaged");
  }
  return pulled.decoded;
}

/** Lanes of a stream of `count` symbols: a power of two. @param {number} count */
export function laneCount(count) {
  const full = Math.max(1, Math.floor(count / LANE_SYMBOLS));
  return Math.min(LANES_MAX, 1 << (31 - Math.clz32(full)));
}

/**
 * @typedef {object} Tables
 * @property {number} contexts
 * @property {number} alphabet
 * @property {Uint16Array} symbols of every slot, 16384 per context
 * @property {Uint32Array} spans per context and symbol, start * 2^15 + frequency; a frequency of 0
 *     marks contexts that are not used
 */

/**
 * @typedef {object} Pulled
 * @property {Uint16Array} decoded
 * @property {number} left words that were not taken; less than 0: there are too few; UNUSED
 * @property {Uint32Array} states in the end
 */

/**
 * @param {Tables} tables
 * @param {Uint32Array} states
 * @param {Uint32Array} first place of each lane
 * @param {Uint8Array} words
 * @param {number} count
 * @returns {Pulled}
 */
function pull({ contexts, alphabet, symbols, spans }, states, first, words, count) {
  const lanes = states.length;
  const short = Math.floor(count / lanes);
  // the first lanes have one symbol more
  const longer = count % lanes;
  const decoded = new Uint16Array(count);
  const total = words.length / 2;
  // one more, which is read but not taken
  const all = new Uint16Array(total + 1);
  // every device with a browser is little-endian
  new Uint8Array(all.buffer).set(words);
  let word = 0;
  for (let step = 0; step <= short; step++) {
    const active = step < short ? lanes : longer;
    const contextual = contexts > 1 && step > 0;
    for (let lane = 0; lane < active; lane++) {
      const place = first[lane] + step;
      const context = contextual ? decoded[place - 1] : 0;
      const state = states[lane];
      const slot = state & (TOTAL - 1);
      const symbol = symbols[(context << PRECISION) | slot];
      const span = spans[context * alphabet + symbol];
      if (span === 0) return { decoded, left: UNUSED, states };
      const next = (Math.imul(span & 0x7fff, state >>> PRECISION) + slot - (span >>> 15)) | 0;
      // Below 2^16 it takes a word, and as it is at least 4, one is enough. Not by a branch, which
      // would be guessed wrong every other time: that took 1.7 times as long.
      const few = ((next >>> 16) - 1) >>> 31;
      states[lane] = (next << (16 * few)) | (all[word] & -few);
      word += few;
      decoded[place] = symbol;
    }
  }
  return { decoded, left: total - word, states };
}

/**
 * @param {Uint8Array} data
 * @param {number} contexts
 * @param {number} alphabet
 * @returns {Tables}
 */
function readTables(data, contexts, alphabet) {
  const bits = new BitReader(data);
  const symbols = new Uint16Array(contexts * TOTAL);
  const spans = new Uint32Array(contexts * alphabet);
  for (let context = 0; context < contexts; context++) {
    if (!take(bits, 1)) continue;
    const frequencies = readFrequencies(bits, alphabet);
    let start = context * TOTAL;
    for (let symbol = 0; symbol < alphabet; symbol++) {
      const frequency = frequencies[symbol];
      if (frequency === 0) continue;
      spans[context * alphabet + symbol] = ((start % TOTAL) << 15) | frequency;
      symbols.fill(symbol, start, start + frequency);
      start += frequency;
    }
  }
  if (!bits.atEnd()) {
    throw new SceneError("a rANS stream's frequency tables are longer than they should be");
  }
  return { contexts, alphabet, symbols, spans };
}

/**
 * The frequencies of one context, which sum to 2^14.
 *
 * @param {BitReader} bits
 * @param {number} alphabet
 */
function readFrequencies(bits, alphabet) {
  const frequencies = new Uint16Array(alphabet);
  const occurs = [];
  for (let symbol = 0; symbol < alphabet; symbol++) if (take(bits, 1)) occurs.push(symbol);
  const k = take(bits, 4);
  const last = occurs.pop();
  let rest = TOTAL;
  for (const symbol of occurs) {
    let width = k;
    while (!take(bits, 1)) width++;
    if (width > PRECISION) {
      throw new SceneError("a rANS stream's frequency table holds a number out of range");
    }
    frequencies[symbol] = take(bits, width) + (1 << width) - (1 << k) + 1;
    rest -= frequencies[symbol];
  }
  if (last === undefined || rest < 1) {
    throw new SceneError("a rANS stream's frequencies do not sum to 16384");
  }
  frequencies[last] = rest;
  return frequencies;
}

/**
 * @param {BitReader} bits
 * @param {number} width
 */
function take(bits, width) {
  if (width > bits.left) throw new SceneError("a rANS stream's frequency tables end early");
  return bits.take(width);
}
