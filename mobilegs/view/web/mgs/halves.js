/** Streams of half-precision numbers. docs/format.md, section 4. */

import { view } from "./bits.js";
import { SceneError } from "./error.js";
import { fromHalf, notFinite } from "./half.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./envelope.js").Stream} Stream */

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
  const start = 4 + view(data).getUint32(0, true);
  if (start > data.length || (codec === "halves" && data.length !== start + count)) throw wrong;
  const upper = decodeRans(data.subarray(4, start), count, 256);
  const rest = data.subarray(start);
  const lower = codec === "planes" ? decodeRans(rest, count, 256) : rest;
  return upper.map((byte, i) => (byte << 8) | lower[i]);
}
