/** Reads integers from packed bits, lowest bit first. docs/reference/format.md, section 4. */

import { SceneError } from "./error.js";

/** A DataView of the bytes. @param {Uint8Array} data */
export function view(data) {
  return new DataView(data.buffer, data.byteOffset, data.byteLength);
}

/** Reads integers of up to 24 bits. */
export class BitReader {
  #data;
  #byte = 0;
  // bits of that byte that have been read, below 8
  #bit = 0;

  /** @param {Uint8Array} data */
  constructor(data) {
    this.#data = data;
  }

  /** Bits that have not been read. */
  get left() {
    return 8 * (this.#data.length - this.#byte) - this.#bit;
  }

  /** The next `width` bits; the caller checks that they exist. @param {number} width */
  take(width) {
    const data = this.#data;
    const at = this.#byte;
    // bytes after the end count as 0
    const four = data[at] | (data[at + 1] << 8) | (data[at + 2] << 16) | (data[at + 3] << 24);
    const end = this.#bit + width;
    const found = (four >>> this.#bit) & ((1 << width) - 1);
    this.#byte = at + (end >>> 3);
    this.#bit = end & 7;
    return found;
  }

  /** True if less than a byte is left and its bits are zeros. */
  atEnd() {
    return this.left < 8 && this.#data[this.#byte] >>> this.#bit === 0;
  }
}

/**
 * A reader of exactly `total` bits; the rest of the last byte must be 0.
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
