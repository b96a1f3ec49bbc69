/** The lanes of a rANS stream in WebAssembly, in half the time of the reference in rans.js. */

import { kernelsIn, newMemory } from "./wasm.js";

/** Offset of the tables in bytes, after a state and a pointer for each of at most 256 lanes. */
const TABLES = 2048;

/** Kept for the next stream. @type {WebAssembly.Memory | null | undefined} */
let memory;

/**
 * The symbols of a stream, as rans.js returns them.
 *
 * @param {import("./rans.js").Tables} tables
 * @param {Uint32Array} states
 * @param {Uint32Array} first place of each lane
 * @param {Uint8Array} words
 * @param {number} count
 * @returns {import("./rans.js").Pulled | undefined} undefined where WebAssembly cannot run
 */
export function pullFast({ contexts, alphabet, symbols, spans }, states, first, words, count) {
  if (memory === undefined) memory = newMemory(1);
  const kernels = kernelsIn(memory);
  if (memory === null || kernels === null) return undefined;
  const lanes = states.length;
  const spansAt = TABLES + 2 * symbols.length;
  const wordsAt = spansAt + 4 * spans.length;
  const end = wordsAt + words.length;
  // the kernel reads a word of each lane and one more behind the words, and a place before the first symbol
  const decodedAt = end + 2 * lanes + 2;
  const pages = Math.ceil((decodedAt + 2 * count + 2) / 2 ** 16) - memory.buffer.byteLength / 2 ** 16;
  if (pages > 0) memory.grow(pages);
  const { buffer } = memory;
  // a state and a pointer to the place before the first symbol
  const table = new Uint32Array(buffer, 0, 2 * lanes);
  states.forEach((state, lane) => table.set([state, decodedAt - 2 + 2 * first[lane]], 2 * lane));
  new Uint16Array(buffer, TABLES, symbols.length).set(symbols);
  new Uint32Array(buffer, spansAt, spans.length).set(spans);
  new Uint8Array(buffer, wordsAt, words.length).set(words);
  const pull = contexts > 1 ? kernels.pull_contextual : kernels.pull_plain;
  const word = pull(0, TABLES, spansAt, alphabet, wordsAt, end, lanes, Math.floor(count / lanes), count % lanes);
  return {
    decoded: new Uint16Array(buffer, decodedAt, count).slice(),
    left: word ? (end - word) / 2 : -Infinity,
    states: table.filter((_, i) => i % 2 === 0),
  };
}
