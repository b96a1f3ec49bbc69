/**
 * Decompresses Zstandard frames (RFC 8878) without dictionaries. Browsers cannot do that themselves.
 *
 * It never allocates more than the announced size and a block, and refuses damaged frames.
 */

import { BackwardBits, fseTable, huffmanTable, onlySymbol, readFseTable, readHuffman } from "./zstd_entropy.js";

/** @typedef {import("./zstd_entropy.js").Fse} Fse */
/** @typedef {import("./zstd_entropy.js").Huffman} Huffman */
/**
 * @typedef {object} Frame what state that blocks of a frame share
 * @property {Huffman | null} huffman
 * @property {(Fse | null)[]} tables of literal lengths, offsets, match lengths
 * @property {number[]} recent the last three offsets
 */

const MAGIC = 0xfd2fb528;
const SKIPPABLE = 0x184d2a5; // above the lowest four bits
const BLOCK_MAX = 1 << 17; // bytes that a block may become
const DAMAGED = "the compressed data is damaged or cut off";

/** A run of codes: how many bits follow each, and the value when they are all 0. @param {number} first @param {number[]} bits */
function codesOf(first, bits) {
  const bases = [];
  for (const count of bits) {
    bases.push(first);
    first += 2 ** count;
  }
  return { bits, bases };
}

const LITERALS = codesOf(0, [...Array(16).fill(0), 1, 1, 1, 1, 2, 2, 3, 3, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]); // prettier-ignore
const MATCHES = codesOf(3, [...Array(32).fill(0), 1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]); // prettier-ignore
/** Of literal lengths, offsets, match lengths: the largest accuracy and symbol, and a table that is not sent. */
const KINDS = [
  {
    accuracy: 9,
    symbols: 36,
    usual: fseTable(6, [
      4, 3, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 3, 2, 1, 1, 1, 1, 1,
      -1, -1, -1, -1,
    ]), // prettier-ignore
  },
  {
    accuracy: 8,
    symbols: 32,
    usual: fseTable(5, [
      1, 1, 1, 1, 1, 1, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1,
    ]), // prettier-ignore
  },
  {
    accuracy: 9,
    symbols: 53,
    usual: fseTable(6, [
      1, 4, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
      1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1,
    ]), // prettier-ignore
  },
];

/** An output buffer that grows with its content, so that a false size allocates little. */
class Output {
  length = 0;
  bytes;
  #limit;

  /** @param {number} limit */
  constructor(limit) {
    this.#limit = limit;
    this.bytes = new Uint8Array(Math.min(limit, BLOCK_MAX));
  }

  /** Reserve space for more bytes. @param {number} count */
  reserve(count) {
    const needed = this.length + count;
    if (needed > this.#limit) throw new Error("the compressed data is longer than announced");
    if (needed <= this.bytes.length) return;
    const larger = new Uint8Array(Math.min(this.#limit, Math.max(needed, 2 * this.bytes.length)));
    larger.set(this.bytes.subarray(0, this.length));
    this.bytes = larger;
  }

  /** @param {Uint8Array} bytes */
  append(bytes) {
    this.reserve(bytes.length);
    this.bytes.set(bytes, this.length);
    this.length += bytes.length;
  }

  /** @param {number} byte @param {number} count */
  fill(byte, count) {
    this.reserve(count);
    this.bytes.fill(byte, this.length, this.length + count);
    this.length += count;
  }

  /** Append earlier output; source and destination may overlap. @param {number} offset @param {number} count */
  repeat(offset, count) {
    if (!(offset > 0 && offset <= this.length)) throw new Error(DAMAGED);
    this.reserve(count);
    const { bytes } = this;
    const end = this.length + count;
    if (offset >= count) bytes.copyWithin(this.length, this.length - offset, end - offset);
    else for (let at = this.length; at < end; at++) bytes[at] = bytes[at - offset];
    this.length = end;
  }
}

/**
 * Decompress frames; checksums are ignored.
 *
 * @param {Uint8Array} bytes
 * @param {number} size the decompressed size, which must be exact
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function decompressZstd(bytes, size) {
  const output = new Output(size);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  while (at < bytes.length) {
    if (at + 8 > bytes.length) throw new Error(DAMAGED);
    const magic = view.getUint32(at, true);
    if (magic >>> 4 === SKIPPABLE) at += 8 + view.getUint32(at + 4, true);
    else if (magic === MAGIC) at = readFrame(bytes, at + 4, output);
    else throw new Error(DAMAGED);
  }
  if (at !== bytes.length || output.length !== size) throw new Error(DAMAGED);
  return output.bytes;
}

/** @param {Uint8Array} bytes @param {number} at @param {Output} output @returns {number} where it ends */
function readFrame(bytes, at, output) {
  const flags = bytes[at++];
  const single = (flags & 32) !== 0; // then no byte says how far offsets reach
  if (!single) at += 1;
  const name = bytes.subarray(at, (at += [0, 1, 2, 4][flags & 3]));
  if (name.some((byte) => byte)) {
    throw new Error("the compressed data needs a dictionary, which is missing");
  }
  at += [single ? 1 : 0, 2, 4, 8][flags >> 6]; // the size, which is known
  /** @type {Frame} */
  const frame = { huffman: null, tables: [null, null, null], recent: [1, 4, 8] };
  for (let last = false; !last; ) {
    if (at + 3 > bytes.length) throw new Error(DAMAGED);
    const header = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16);
    at += 3;
    last = (header & 1) === 1;
    const kind = (header >> 1) & 3;
    const size = header >> 3;
    const length = kind === 1 ? 1 : size;
    if (kind === 3 || size > BLOCK_MAX || at + length > bytes.length) throw new Error(DAMAGED);
    if (kind === 0) output.append(bytes.subarray(at, at + size));
    else if (kind === 1) output.fill(bytes[at], size);
    else readBlock(bytes.subarray(at, at + size), frame, output);
    at += length;
  }
  return at + (flags & 4 ? 4 : 0);
}

/** @param {Uint8Array} block @param {Frame} frame @param {Output} output */
function readBlock(block, frame, output) {
  const { literals, end } = readLiterals(block, frame);
  let at = end;
  let count = block[at++];
  if (count === undefined) throw new Error(DAMAGED);
  if (count === 255) {
    count = block[at] + (block[at + 1] << 8) + 0x7f00;
    at += 2;
  } else if (count > 127) count = ((count - 128) << 8) + block[at++];
  if (count === 0) {
    output.append(literals);
    return;
  }
  const modes = block[at++];
  if (!(count > 0) || modes === undefined || modes & 3) throw new Error(DAMAGED);
  for (const [i, { accuracy, symbols, usual }] of KINDS.entries()) {
    const mode = (modes >> (6 - 2 * i)) & 3;
    if (mode === 0) frame.tables[i] = usual;
    else if (mode === 1) {
      if (!(block[at] < symbols)) throw new Error(DAMAGED);
      frame.tables[i] = onlySymbol(block[at++]);
    } else if (mode === 2) {
      const { table, end } = readFseTable(block, at, accuracy, symbols);
      frame.tables[i] = table;
      at = end;
    }
  }
  copySequences(new BackwardBits(block.subarray(at)), count, literals, frame, output);
}

/** @param {BackwardBits} bits @param {number} count @param {Uint8Array} literals @param {Frame} frame @param {Output} output */
function copySequences(bits, count, literals, { tables, recent }, output) {
  const [byLiterals, byOffset, byMatch] = tables;
  if (!byLiterals || !byOffset || !byMatch) throw new Error(DAMAGED);
  let literalState = bits.take(byLiterals.accuracy);
  let offsetState = bits.take(byOffset.accuracy);
  let matchState = bits.take(byMatch.accuracy);
  let taken = 0;
  const ceiling = output.length + BLOCK_MAX;
  for (let left = count; left > 0; left--) {
    const offsetCode = byOffset.symbols[offsetState];
    const matchCode = byMatch.symbols[matchState];
    const literalCode = byLiterals.symbols[literalState];
    const offset = 2 ** offsetCode + bits.take(offsetCode);
    const match = MATCHES.bases[matchCode] + bits.take(MATCHES.bits[matchCode]);
    const run = LITERALS.bases[literalCode] + bits.take(LITERALS.bits[literalCode]);
    if (left > 1) {
      literalState = byLiterals.bases[literalState] + bits.take(byLiterals.bits[literalState]);
      matchState = byMatch.bases[matchState] + bits.take(byMatch.bits[matchState]);
      offsetState = byOffset.bases[offsetState] + bits.take(byOffset.bits[offsetState]);
    }
    if (bits.left < 0 || taken + run > literals.length) throw new Error(DAMAGED);
    output.append(literals.subarray(taken, taken + run));
    taken += run;
    output.repeat(trueOffset(offset, run, recent), match);
    if (output.length > ceiling) throw new Error(DAMAGED);
  }
  if (bits.left !== 0) throw new Error(DAMAGED);
  output.append(literals.subarray(taken));
}

/** An offset, which may stand for one of the last three; they are kept. @param {number} value @param {number} run @param {number[]} recent */
function trueOffset(value, run, recent) {
  if (value > 3) {
    recent.unshift(value - 3);
    recent.pop();
    return recent[0];
  }
  const which = run === 0 ? value : value - 1; // after no literals, the last one makes no sense
  const offset = which < 3 ? recent[which] : recent[0] - 1;
  if (which > 0) {
    recent.splice(Math.min(which, 2), 1);
    recent.unshift(offset);
  }
  return offset;
}

/** @param {Uint8Array} block @param {Frame} frame @returns {{literals: Uint8Array, end: number}} */
function readLiterals(block, frame) {
  const word = block[0] | (block[1] << 8) | (block[2] << 16);
  const kind = block[0] & 3;
  const format = (block[0] >> 2) & 3;
  if (kind < 2) {
    const head = [1, 2, 1, 3][format];
    const size = head === 1 ? block[0] >> 3 : (word & (head === 2 ? 0xffff : 0xffffff)) >> 4;
    const end = head + (kind === 0 ? size : 1);
    if (size > BLOCK_MAX || !(end <= block.length)) throw new Error(DAMAGED);
    if (kind === 0) return { literals: block.subarray(head, end), end };
    return { literals: new Uint8Array(size).fill(block[head]), end };
  }
  const head = [3, 3, 4, 5][format];
  const width = [10, 10, 14, 18][format];
  const whole = (word >>> 0) + (block[3] ?? 0) * 2 ** 24 + (block[4] ?? 0) * 2 ** 32;
  const size = Math.floor(whole / 16) % 2 ** width;
  const length = Math.floor(whole / 2 ** (4 + width)) % 2 ** width;
  const end = head + length;
  if (size > BLOCK_MAX || !(end <= block.length)) throw new Error(DAMAGED);
  let at = head;
  if (kind === 2) {
    const { weights, end: start } = readHuffman(block.subarray(0, end), at);
    frame.huffman = huffmanTable(weights);
    at = start;
  }
  if (frame.huffman === null) throw new Error(DAMAGED);
  return { literals: readStreams(block.subarray(at, end), size, format !== 0, frame.huffman), end };
}

/** @param {Uint8Array} bytes @param {number} size @param {boolean} four streams, not one @param {Huffman} huffman */
function readStreams(bytes, size, four, huffman) {
  const literals = new Uint8Array(size);
  if (!four) {
    new BackwardBits(bytes).decode(literals, huffman);
    return literals;
  }
  if (bytes.length < 6) throw new Error(DAMAGED);
  const part = (size + 3) >> 2;
  for (let i = 0, at = 6; i < 4; i++) {
    const length = i < 3 ? bytes[2 * i] | (bytes[2 * i + 1] << 8) : bytes.length - at;
    if (at + length > bytes.length) throw new Error(DAMAGED);
    const to = i < 3 ? (i + 1) * part : size;
    if (to > size) throw new Error(DAMAGED);
    new BackwardBits(bytes.subarray(at, at + length)).decode(literals.subarray(i * part, to), huffman);
    at += length;
  }
  return literals;
}
