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
  // bits of that byte that have been taken, below 8
  #bit = 0;

  /** @param {Uint8Array} data */
  constructor(data) {
    this.#data = data;
  }

  /** Bits that have not been taken. */
  get left() {
    return 8 * (this.#data.length - this.#byte) - this.#bit;
  }

  /** The next `width` bits; the caller has seen that they are there. @param {number} width */
  take(width) {
    const data = this.#data;
    const at = this.#byte;
    // what lies behind the end counts as 0
    const four = data[at] | (data[at + 1] << 8) | (data[at + 2] << 16) | (data[at + 3] << 24);
    const end = this.#bit + width;
    const found = (four >>> this.#bit) & ((1 << width) - 1);
    this.#byte = at + (end >>> 3);
    this.#bit = end & 7;
    return found;
  }

  /** Whether less than a byte is left, and nothing but zeros. */
  atEnd() {
    return this.left < 8 && this.#data[this.#byte] >>> this.#bit === 0;
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
