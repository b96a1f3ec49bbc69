/** Half-precision numbers, and the streams that hold rows of them. docs/format.md, section 4. */

import { view } from "./bits.js";
import { SceneError } from "./error.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./envelope.js").Stream} Stream */

/** What a last digit is worth, by exponent. */
const DIGIT = Float64Array.from({ length: 31 }, (_, exponent) => 2 ** (Math.max(exponent, 1) - 25));

/** Whether the bits of a half are those of infinity or NaN. @param {number} bits */
export function notFinite(bits) {
  return (bits & 0x7c00) === 0x7c00;
}

/** The value of a finite half's bits, exactly. @param {number} bits */
export function fromHalf(bits) {
  const exponent = (bits >> 10) & 31;
  const digits = (bits & 1023) + (exponent > 0 ? 1024 : 0);
  return (bits & 0x8000 ? -digits : digits) * DIGIT[exponent];
}

/**
 * The `count` numbers in a stream of halves; all must be finite.
 *
 * @param {Stream} stream
 * @param {number} count
 * @returns {Float32Array}
 */
export function decodeHalves(stream, count) {
  const bits = decodeBits(stream, count);
  if (bits.some(notFinite)) {
    throw new SceneError(
      `the stream '${stream.name}' of the .mgs file has numbers that are not finite`,
    );
  }
  return Float32Array.from(bits, fromHalf);
}

/**
 * @param {Stream} stream
 * @param {number} count
 */
function decodeBits({ name, codec, data }, count) {
  const wrong = new SceneError(`the stream '${name}' of the .mgs file has a wrong length`);
  if (codec === "raw") {
    if (data.length !== 2 * count) throw wrong;
    return Uint16Array.from({ length: count }, (_, i) => data[2 * i] | (data[2 * i + 1] << 8));
  }
  if (data.length < 4) throw wrong;
  const lower = 4 + view(data).getUint32(0, true);
  if (data.length !== lower + count) throw wrong;
  const upper = decodeRans(data.subarray(4, lower), count, 256);
  return upper.map((byte, i) => (byte << 8) | data[lower + i]);
}
