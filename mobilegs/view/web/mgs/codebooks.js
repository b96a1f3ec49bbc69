/** Indices, and the codebooks that they point into. docs/format.md, sections 4 and 6. */

import { exactBits } from "./bits.js";
import { SceneError } from "./error.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./envelope.js").Stream} Stream */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Cut} Cut */
/**
 * @typedef {object} Codes an attribute as it is stored
 * @property {number} length numbers per entry
 * @property {Float32Array[]} books entries one after the other
 * @property {Uint16Array[]} columns per book, the entry of every Gaussian
 */

const LOG_SCALE_MAX = 80; // its exponential is finite in float32

/** Numbers in all codebooks. @param {Map<Attribute, Cut>} cuts */
export function bookNumbers(cuts) {
  let total = 0;
  for (const { count, size, length } of cuts.values()) total += count * size * length;
  return total;
}

/**
 * The codebooks of every attribute, out of one row of numbers.
 *
 * @param {Float32Array} numbers
 * @param {Map<Attribute, Cut>} cuts
 * @returns {Map<Attribute, Float32Array[]>}
 */
export function splitBooks(numbers, cuts) {
  let start = 0;
  /** @type {Map<Attribute, Float32Array[]>} */
  const books = new Map();
  for (const [name, { count, size, length }] of cuts) {
    const take = () => numbers.subarray(start, (start += size * length));
    books.set(name, Array.from({ length: count }, take));
  }
  if (books.get("scale")?.some((book) => book.some((value) => value > LOG_SCALE_MAX))) {
    throw new SceneError("the codebooks of the .mgs file hold scales that are out of range");
  }
  return books;
}

/**
 * The indices in a stream, each below `size`.
 *
 * @param {Stream} stream
 * @param {number} count
 * @param {number} size
 * @returns {Uint16Array}
 */
export function decodeIndices({ name, codec, data }, count, size) {
  if (codec === "rans") return decodeRans(data, count, size);
  const width = 32 - Math.clz32(size - 1);
  const bits = exactBits(data, width * count);
  const indices = new Uint16Array(count);
  for (let i = 0; i < count; i++) {
    const index = bits.take(width);
    if (index >= size) throw new SceneError(`the stream '${name}' points outside of its codebook`);
    indices[i] = index;
  }
  return indices;
}

/**
 * Codes that give `count` Gaussians the mean of each book: what is drawn until their own come.
 *
 * @param {Codes} codes
 * @param {number} count
 * @returns {Codes}
 */
export function meanCodes({ length, books }, count) {
  const column = new Uint16Array(count);
  return {
    length,
    books: books.map((book) => meanEntry(book, length)),
    columns: books.map(() => column),
  };
}

/**
 * @param {Float32Array} book
 * @param {number} length
 */
function meanEntry(book, length) {
  const mean = new Float64Array(length);
  for (let i = 0; i < book.length; i++) mean[i % length] += (book[i] * length) / book.length;
  return Float32Array.from(mean);
}

/**
 * Writes the vectors of Gaussians `from` to `to`, one per `stride` numbers of `out` from `start`,
 * with `step` from one of their numbers to the next.
 *
 * @param {Codes} codes
 * @param {number} from
 * @param {number} to
 * @param {Float32Array} out
 * @param {number} start
 * @param {number} stride
 * @param {number} [step]
 */
export function lookUp({ length, books, columns }, from, to, out, start, stride, step = 1) {
  for (let j = 0; j < books.length; j++) {
    const book = books[j];
    const column = columns[j];
    for (let e = 0; e < length; e++) {
      let place = start + (j * length + e) * step;
      for (let i = from; i < to; i++, place += stride) out[place] = book[column[i] * length + e];
    }
  }
}
