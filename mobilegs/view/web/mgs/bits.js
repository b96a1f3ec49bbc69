/** Whole numbers packed into bits, lowest bit first. docs/format.md, section 4. */

import { SceneError } from "./error.js";

/** A view for reading little-endian numbers. @param {Uint8Array} data */
export function view(data) {
  return new DataView(data.buffer, data.byteOffset, data.byteLength);
}

/** Reads numbers of up to 24 bits, one after the other. */
export class BitReader {
  #data;
  #byte = 0;
  // bits read from the data and not yet taken
  #kept = 0;
  // how many these are, below 8 between two numbers
  #bits = 0;

  /** @param {Uint8Array} data */
  constructor(data) {
    this.#data = data;
  }

  /** Bits that have not been taken. */
  get left() {
    return 8 * (this.#data.length - this.#byte) + this.#bits;
  }

  /** The next `width` bits; the caller has seen that they are there. @param {number} width */
  take(width) {
    let kept = this.#kept;
    let bits = this.#bits;
    while (bits < width) {
      kept |= this.#data[this.#byte++] << bits;
      bits += 8;
    }
    this.#kept = kept >>> width;
    this.#bits = bits - width;
    return kept & ((1 << width) - 1);
  }

  /** Whether less than a byte is left, and nothing but zeros. */
  atEnd() {
    return this.left < 8 && this.#kept === 0;
  }
}

/**
 * A reader of exactly so many bits; what is left of the last byte must be 0.
 *
 * @param {Uint8Array} data
 * @param {number} total
 */
export function exactBits(data, total) {
  const bytes = Math.ceil(total / 8);
  if (data.length !== bytes) {
    throw new SceneError(`packed bits take ${data.length} bytes where ${bytes} belong`);
  }
  if (total % 8 && data[bytes - 1] >> total % 8) {
    throw new SceneError("packed bits end in bits that are not zero");
  }
  return new BitReader(data);
}
