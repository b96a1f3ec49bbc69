/** Codebooks and the indices into them. docs/reference/format.md, sections 4 and 6. */

import { exactBits } from "./bits.js";
import { SceneError } from "./error.js";
import { BLOCK } from "./block_memory.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./container.js").Stream} Stream */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Cut} Cut */
/** @typedef {import("./header.js").Scalar} Scalar */
/**
 * @typedef {object} Books of an attribute
 * @property {number} length numbers per entry
 * @property {Float32Array[]} books
 * @property {number[]} [middles] the neutral entry of each book; if undefined, the mean of the book
 */
/** @typedef {Books & {columns: Uint16Array[]}} Codes per book, the entry of every Gaussian */

// its exponential is finite in float32
const LOG_SCALE_MAX = 80;

/** Count of numbers in all codebooks. @param {Map<Attribute, Cut>} cuts */
export function bookNumbers(cuts) {
  let total = 0;
  for (const { count, size, length } of cuts.values()) total += count * size * length;
  return total;
}

/**
 * Split numbers into the codebooks of each attribute.
 *
 * @param {Float32Array} numbers
 * @param {Map<Attribute, Cut>} cuts
 * @returns {Map<Attribute, Books>}
 */
export function splitBooks(numbers, cuts) {
  let start = 0;
  /** @type {Map<Attribute, Books>} */
  const all = new Map();
  for (const [name, { count, size, length }] of cuts) {
    const take = () => numbers.subarray(start, (start += size * length));
    all.set(name, { length, books: Array.from({ length: count }, take) });
  }
  if (all.get("scale")?.books.some((book) => book.some((value) => value > LOG_SCALE_MAX))) {
    throw new SceneError("the codebooks of the .mgs file hold scales that are out of range");
  }
  return all;
}

/**
 * Codebooks of uniformly quantized attributes: the multiples of the step size.
 *
 * @param {Map<Attribute, Scalar>} scalars
 * @returns {Map<Attribute, Books>}
 */
export function scalarBooks(scalars) {
  return new Map(
    [...scalars].map(([name, { step, columns }]) => {
      const books = columns.map(({ least, size }) => Float32Array.from({ length: size }, (_, i) => (least + i) * step));
      return [name, { length: 1, books, middles: columns.map(({ least, middle }) => middle - least) }];
    }),
  );
}

/**
 * Decode the indices of a stream, each below `size`.
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
 * Codes that give a block of Gaussians the neutral entry of each book, until their own codes arrive.
 *
 * @param {Books} books
 * @returns {Codes}
 */
export function meanCodes({ length, books, middles }) {
  const column = new Uint16Array(BLOCK);
  return {
    length,
    books: books.map((book, i) => (middles ? book.subarray(middles[i], middles[i] + 1) : meanEntry(book, length))),
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
 * Look up the values of some Gaussians and write them in columns.
 *
 * @param {Codes} codes
 * @param {Float32Array} out
 * @param {number} step from one column to the next
 * @param {number} from the first of the Gaussians
 * @param {number} to
 */
export function lookUp({ length, books, columns }, out, step, from, to) {
  for (let j = 0; j < books.length; j++) {
    const book = books[j];
    const column = columns[j];
    let place = j * length * step;
    if (length === 1) {
      for (let i = from; i < to; i++) out[place++] = book[column[i]];
      continue;
    }
    for (let e = 0; e < length; e++, place = (j * length + e) * step) {
      for (let i = from; i < to; i++) out[place++] = book[column[i] * length + e];
    }
  }
}
