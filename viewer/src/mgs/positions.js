/** Decodes positions: float16 in a grid, as differences of Morton codes. docs/reference/format.md, section 5. */

import { exactBits, view } from "./bits.js";
import { SceneError } from "./error.js";
import { fromFloat16, isNotFinite } from "./float16.js";
import { decodeRans } from "./rans.js";

/** @typedef {import("./header.js").PositionGrid} PositionGrid */
/**
 * Means of Gaussians: world units, 3 each, or as stored in a file.
 *
 * @typedef {Float32Array<ArrayBuffer> | {stored: Uint16Array<ArrayBuffer>, grid: PositionGrid}} StoredMeans
 */

const CLASSES = 49;
// bits of each of a code's two digits: JavaScript's bit operations cannot hold all 48
const DIGITS = 24;
/** Of 12 bits those of each axis moved together: four of the first axis, 10 means on those of the others. */
const THIRDS = Uint32Array.from({ length: 4096 }, (_, code) => {
  let found = 0;
  for (let bit = 0; bit < 12; bit++) found |= ((code >>> bit) & 1) << (10 * (bit % 3) + Math.floor(bit / 3));
  return found;
});

/**
 * Decode the stored positions, three float16 bit patterns per Gaussian.
 *
 * @param {Uint8Array} data
 * @param {number} count
 * @returns {Uint16Array}
 */
export function decodePositions(data, count) {
  const coded = data.length < 4 ? Infinity : 4 + view(data).getUint32(0, true);
  if (coded > data.length) {
    throw new SceneError("the stream of positions is too short to hold what its header says");
  }
  const classes = decodeRans(data.subarray(4, coded), count, CLASSES);
  let total = 0;
  for (let i = 0; i < count; i++) total += Math.max(classes[i] - 1, 0);
  const bits = exactBits(data.subarray(coded), total);
  const stored = new Uint16Array(3 * count);
  let low = 0;
  let high = 0;
  for (let i = 0; i < count; i++) {
    // bits below the leading one
    const width = classes[i] - 1;
    if (width >= DIGITS) {
      low += bits.take(DIGITS);
      high += (1 << (width - DIGITS)) + bits.take(width - DIGITS);
    } else if (width >= 0) {
      low += (1 << width) + bits.take(width);
    }
    high += low >>> DIGITS;
    low &= (1 << DIGITS) - 1;
    if (high >>> DIGITS) throw new SceneError("the stream of positions leaves its 48-bit grid");
    // of each axis eight bits
    const lower = THIRDS[low & 0xfff] | (THIRDS[low >>> 12] << 4);
    const upper = THIRDS[high & 0xfff] | (THIRDS[high >>> 12] << 4);
    for (let axis = 0, from = 0; axis < 3; axis++, from += 10) {
      const ordered = ((lower >>> from) & 255) | (((upper >>> from) & 255) << 8);
      const half = ordered & 0x8000 ? ordered & 0x7fff : ordered ^ 0xffff;
      if (isNotFinite(half)) {
        throw new SceneError("the stream of positions holds numbers that are not finite");
      }
      stored[3 * i + axis] = half;
    }
  }
  return stored;
}

/** Every n-th position, so that there are at most `most`. @param {Uint16Array} positions @param {number} most */
export function subsampled(positions, most) {
  const apart = 3 * Math.ceil(positions.length / 3 / most);
  if (apart <= 3) return positions;
  const some = new Uint16Array(3 * Math.ceil(positions.length / apart));
  for (let i = 0, at = 0; i < positions.length; i += apart, at += 3) {
    some.set(positions.subarray(i, i + 3), at);
  }
  return some;
}

/**
 * World positions of stored ones: in units of the radius exact, then one rounded product and one
 * rounded sum.
 *
 * @param {Uint16Array} stored
 * @param {PositionGrid} grid
 */
export function toWorld(stored, { center, radius, exponent }) {
  const means = new Float32Array(stored.length);
  // exact, as is its product with a half in float64
  const unit = radius * 2 ** exponent;
  for (let i = 0; i < stored.length; i++) {
    means[i] = center[i % 3] + Math.fround(unit * fromFloat16(stored[i]));
  }
  return means;
}

/** The means in world units. @param {StoredMeans} means */
export function worldMeans(means) {
  return "stored" in means ? toWorld(means.stored, means.grid) : means;
}
