/** The lanes of a rANS stream, by WebAssembly: what `pull` of rans.js does, in half the time. */

import {
  ABOVE, AND, BELOW, I32, MINUS, NOT_BELOW, OR, PLUS, SHIFT_LEFT, SHIFT_RIGHT, TIMES, advance, assembled, get, loop,
  memoryOf, number, set, unsigned,
} from "./assembler.js"; // prettier-ignore

/** Where places are, behind the states, in bytes. */
const PLACES = 1024;
const TABLES = 2048;
/** Symbols of a context in its table, as a power of two. */
const PRECISION = 14;
const load = (/** @type {number} */ offset) => [0x28, 0, ...unsigned(offset)];
const loadShort = (/** @type {number} */ offset) => [0x2f, 0, ...unsigned(offset)];
const store = (/** @type {number} */ offset) => [0x36, 0, ...unsigned(offset)];
const storeShort = (/** @type {number} */ offset) => [0x3b, 0, ...unsigned(offset)];
const SELECT = 0x1b;
const RETURN = 0x0f;
const NONE = 0x45; // whether a number is 0
const when = (/** @type {number[]} */ test, /** @type {number[]} */ body) => [...test, 0x04, 0x40, ...body, 0x0b];

/**
 * `plain(symbols, spans, words, end, lanes, short, longer, alphabet)`: places in bytes, and numbers as
 * in `pull`. Returns where the words are that were not taken, or 0 if a context is not used; it stops
 * as soon as more words were taken than there are. `contextual` has several contexts.
 *
 * @param {boolean} contextual
 */
function body(contextual) {
  const [symbols, spans, word, end, lanes, short, longer, alphabet] = [0, 1, 2, 3, 4, 5, 6, 7];
  const [step, lane, last, mask, state, slot, context, symbol, span, next, few, place] = Array.from(Array(12), (_, i) => 8 + i);
  const only = (/** @type {number[]} */ ...code) => (contextual ? code : []);
  const one = [
    ...get(lane), ...load(PLACES), ...get(step), ...number(1), SHIFT_LEFT, PLUS, ...set(place),
    ...only(...get(place), ...loadShort(0), ...get(mask), AND, ...set(context)),
    ...get(lane), ...load(0), ...set(state),
    ...get(state), ...number((1 << PRECISION) - 1), AND, ...set(slot),
    ...only(...get(context), ...number(PRECISION), SHIFT_LEFT), ...get(slot), ...only(OR), ...number(1), SHIFT_LEFT,
    ...get(symbols), PLUS, ...loadShort(0), ...set(symbol),
    ...only(...get(context), ...get(alphabet), TIMES), ...get(symbol), ...only(PLUS), ...number(2), SHIFT_LEFT,
    ...get(spans), PLUS, ...load(0), ...set(span),
    ...when([...get(span), NONE], [...number(0), RETURN]),
    ...get(span), ...number(0x7fff), AND, ...get(state), ...number(PRECISION), SHIFT_RIGHT, TIMES,
    ...get(slot), PLUS, ...get(span), ...number(15), SHIFT_RIGHT, MINUS, ...set(next),
    ...get(next), ...number(16), SHIFT_RIGHT, NONE, ...set(few),
    ...get(lane),
    ...get(next), ...get(few), ...number(4), SHIFT_LEFT, SHIFT_LEFT,
    ...get(word), ...loadShort(0), ...number(0), ...get(few), MINUS, AND, OR,
    ...store(0),
    ...get(word), ...get(few), ...number(1), SHIFT_LEFT, PLUS, ...set(word),
    ...get(place), ...get(symbol), ...storeShort(2),
    ...advance(lane, 4),
  ];
  const row = [
    ...number(0), ...set(lane),
    ...get(lanes), ...get(longer), ...get(step), ...get(short), BELOW, SELECT, ...number(2), SHIFT_LEFT, ...set(last),
    ...when(get(last), loop(one, [...get(lane), ...get(last), BELOW])),
    ...when([...get(word), ...get(end), ABOVE], [...get(word), RETURN]),
    // only the first symbol of a lane has none before it
    ...number(0), ...number(1), MINUS, ...set(mask),
    ...advance(step, 1),
  ];
  return [1, 12, I32, ...loop(row, [...get(short), ...get(step), NOT_BELOW]), ...get(word), 0x0b];
}

/** @type {((memory: WebAssembly.Memory) => Record<string, Function> | null) | undefined} */
let make;
/** Kept for the next stream. @type {{memory: WebAssembly.Memory | null, run: Record<string, Function> | null} | undefined} */
let machine;

/**
 * What `pull` does.
 *
 * @param {import("./rans.js").Tables} tables
 * @param {Uint32Array} states
 * @param {Uint32Array} first place of each lane
 * @param {Uint8Array} words
 * @param {number} count
 * @returns {import("./rans.js").Pulled | undefined} undefined: there is no such thing here
 */
export function pullFast({ contexts, alphabet, symbols, spans }, states, first, words, count) {
  const [parameters, results] = [Array(8).fill(I32), [I32]];
  make ??= assembled({
    plain: { parameters, results, body: body(false) },
    contextual: { parameters, results, body: body(true) },
  });
  if (machine === undefined) {
    const memory = memoryOf(1);
    machine = { memory, run: memory && make(memory) };
  }
  const { memory, run } = machine;
  if (memory === null || run === null) return undefined;
  const lanes = states.length;
  const spansAt = TABLES + 2 * symbols.length;
  const wordsAt = spansAt + 4 * spans.length;
  // a step reads beyond the words before it notices, and a context is read before the first symbol
  const decodedAt = wordsAt + words.length + 2 * lanes + 2;
  const pages = Math.ceil((decodedAt + 2 * count + 2) / 2 ** 16) - memory.buffer.byteLength / 2 ** 16;
  if (pages > 0) memory.grow(pages);
  const { buffer } = memory;
  new Uint32Array(buffer, 0, lanes).set(states);
  // of what comes before a symbol, in bytes
  new Uint32Array(buffer, PLACES, lanes).set(first.map((place) => decodedAt - 2 + 2 * place));
  new Uint16Array(buffer, TABLES, symbols.length).set(symbols);
  new Uint32Array(buffer, spansAt, spans.length).set(spans);
  new Uint8Array(buffer, wordsAt, words.length).set(words);
  const [short, longer, end] = [Math.floor(count / lanes), count % lanes, wordsAt + words.length];
  const pull = contexts > 1 ? run.contextual : run.plain;
  const word = pull(TABLES, spansAt, wordsAt, end, lanes, short, longer, alphabet);
  return {
    decoded: new Uint16Array(buffer, decodedAt, count).slice(),
    left: word ? (end - word) / 2 : -Infinity,
    states: new Uint32Array(buffer, 0, lanes).slice(),
  };
}
