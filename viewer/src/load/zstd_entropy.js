/** Zstandard's entropy codes (RFC 8878, section 4): FSE and Huffman. */

const DAMAGED = "the compressed data is damaged or cut off";
const HUFFMAN_MAX = 11; // bits of a code

/**
 * An FSE table: for each state its symbol, the number of bits to read, and the base of the next state.
 *
 * @typedef {object} Fse
 * @property {number} accuracy bits of the first state
 * @property {Uint8Array} symbols
 * @property {Uint8Array} bits
 * @property {Uint16Array} bases
 */
/**
 * What each pattern of bits begins with.
 *
 * @typedef {object} Huffman
 * @property {number} width bits of a pattern
 * @property {Uint8Array} symbols
 * @property {Uint8Array} bits that the code has
 */

/** Reads bits from the end of the bytes; before the beginning there are zeros. */
export class BackwardBits {
  /** Bits left; negative if more were read than exist. */
  left;
  #bytes;

  /** @param {Uint8Array} bytes the highest set bit of the last byte marks the end */
  constructor(bytes) {
    const last = bytes[bytes.length - 1];
    if (!last) throw new Error(DAMAGED);
    this.#bytes = bytes;
    this.left = 8 * bytes.length - 1 - Math.clz32(last) + 24;
  }

  /** @param {number} count at most 31 @returns {number} */
  take(count) {
    if (count > 24) return this.take(count - 16) * 65536 + this.take(16);
    this.left -= count;
    return this.#at(this.left, count);
  }

  /** Fill `symbols`, which must use all bits. @param {Uint8Array} symbols @param {Huffman} huffman */
  decode(symbols, { width, symbols: names, bits }) {
    for (let i = 0; i < symbols.length; i++) {
      const pattern = this.#at(this.left - width, width);
      symbols[i] = names[pattern];
      this.left -= bits[pattern];
    }
    if (this.left !== 0) throw new Error(DAMAGED);
  }

  /** @param {number} from bit @param {number} count at most 24 @returns {number} */
  #at(from, count) {
    const bytes = this.#bytes;
    if (from < 0) return from + count > 0 ? this.#at(0, from + count) << -from : 0;
    const at = from >> 3;
    const word = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);
    return (word >>> (from & 7)) & ((1 << count) - 1);
  }
}

/** The table of the one symbol that there is. @param {number} symbol @returns {Fse} */
export function onlySymbol(symbol) {
  const bits = new Uint8Array(1);
  return { accuracy: 0, symbols: Uint8Array.of(symbol), bits, bases: new Uint16Array(1) };
}

/**
 * @param {number} accuracy
 * @param {number[]} shares of the states that symbols have; -1: less than one
 * @returns {Fse}
 */
export function fseTable(accuracy, shares) {
  const size = 1 << accuracy;
  const table = {
    accuracy,
    symbols: new Uint8Array(size),
    bits: new Uint8Array(size),
    bases: new Uint16Array(size),
  };
  let high = size;
  for (const [symbol, share] of shares.entries()) if (share === -1) table.symbols[--high] = symbol;
  const step = (size >> 1) + (size >> 3) + 3;
  let place = 0;
  for (const [symbol, share] of shares.entries()) {
    for (let i = 0; i < share; i++) {
      table.symbols[place] = symbol;
      do place = (place + step) & (size - 1);
      while (place >= high);
    }
  }
  if (place !== 0) throw new Error(DAMAGED);
  const next = shares.map((share) => Math.abs(share));
  for (let state = 0; state < size; state++) {
    const count = next[table.symbols[state]]++;
    const bits = accuracy - (31 - Math.clz32(count));
    table.bits[state] = bits;
    table.bases[state] = (count << bits) - size;
  }
  return table;
}

/**
 * A table as it is written, its bits from the first byte on.
 *
 * @param {Uint8Array} bytes
 * @param {number} start
 * @param {number} accuracyMax
 * @param {number} symbolsMax
 * @returns {{table: Fse, end: number}}
 */
export function readFseTable(bytes, start, accuracyMax, symbolsMax) {
  let bit = 8 * start;
  const take = (/** @type {number} */ count) => {
    const at = bit >> 3;
    const word = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16);
    const value = (word >> (bit & 7)) & ((1 << count) - 1);
    bit += count;
    return value;
  };
  const accuracy = 5 + take(4);
  if (accuracy > accuracyMax) throw new Error(DAMAGED);
  const shares = [];
  for (let left = 1 << accuracy; left > 0; ) {
    const width = 32 - Math.clz32(left + 1);
    const spare = (1 << width) - 2 - left; // number of values that take one bit less
    let value = take(width - 1);
    if (value >= spare) {
      if (take(1)) value += (1 << (width - 1)) - spare;
    }
    const share = value - 1;
    left -= Math.abs(share);
    shares.push(share);
    for (let more = share === 0 ? 3 : 0; more === 3; ) {
      more = take(2);
      for (let i = 0; i < more; i++) shares.push(0);
    }
    if (left < 0 || shares.length > symbolsMax) throw new Error(DAMAGED);
  }
  const end = (bit + 7) >> 3;
  if (end > bytes.length) throw new Error(DAMAGED);
  return { table: fseTable(accuracy, shares), end };
}

/**
 * The weights of Huffman's code: 2^(weight - 1) of all patterns begin with a symbol.
 *
 * @param {Uint8Array} bytes
 * @param {number} at
 * @returns {{weights: number[], end: number}}
 */
export function readHuffman(bytes, at) {
  const head = bytes[at++];
  if (!(head < 128)) {
    const count = head - 127;
    const end = at + ((count + 1) >> 1);
    if (!(end <= bytes.length)) throw new Error(DAMAGED);
    const half = (/** @type {number} */ i) => (bytes[at + (i >> 1)] >> (i % 2 ? 0 : 4)) & 15;
    return { weights: Array.from({ length: count }, (_, i) => half(i)), end };
  }
  const end = at + head;
  if (end > bytes.length) throw new Error(DAMAGED);
  const { table, end: start } = readFseTable(bytes.subarray(0, end), at, 6, HUFFMAN_MAX + 2);
  const bits = new BackwardBits(bytes.subarray(start, end));
  const weights = [];
  // two states take turns until there are no bits for the next one
  const states = [bits.take(table.accuracy), bits.take(table.accuracy)];
  for (let i = 0; weights.length < 255; i ^= 1) {
    const state = states[i];
    weights.push(table.symbols[state]);
    states[i] = table.bases[state] + bits.take(table.bits[state]);
    if (bits.left < 0) {
      weights.push(table.symbols[states[i ^ 1]]);
      return { weights, end };
    }
  }
  throw new Error(DAMAGED);
}

/** @param {number[]} weights of all symbols but the last, which has what they leave @returns {Huffman} */
export function huffmanTable(weights) {
  const patterns = (/** @type {number} */ weight) => (weight > 0 ? 1 << (weight - 1) : 0);
  let used = 0;
  for (const weight of weights) used += patterns(weight);
  const width = 32 - Math.clz32(used);
  const left = (1 << width) - used;
  if (used === 0 || width > HUFFMAN_MAX || left & (left - 1)) throw new Error(DAMAGED);
  const all = [...weights, 32 - Math.clz32(left)];
  if (all.length > 256) throw new Error(DAMAGED);
  const table = { width, symbols: new Uint8Array(1 << width), bits: new Uint8Array(1 << width) };
  let at = 0;
  for (let weight = 1; weight <= width; weight++) {
    for (const [symbol, own] of all.entries()) {
      if (own !== weight) continue;
      const end = at + patterns(weight);
      table.symbols.fill(symbol, at, end);
      table.bits.fill(width + 1 - weight, at, end);
      at = end;
    }
  }
  return table;
}
