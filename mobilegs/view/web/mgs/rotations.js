/** Rotations as three angles, each as fine as its Gaussian needs. docs/format.md, section 6. */

import { exactBits } from "./bits.js";
import { BLOCK } from "./machine.js";

/** @typedef {import("./header.js").Scalar} Scalar */

/** Differences of log-scales from which on an angle has one more bit. */
const LIMITS = Float64Array.of(53, 210, 405, 600, 787, 970, 1151, 1329).map((limit) => limit / 256);

/** @param {number} a @param {number} b log-scales, float32 values */
function finerBits(a, b) {
  const apart = Math.abs(Math.fround(a - b));
  let bits = 0;
  while (bits < 8 && LIMITS[bits] <= apart) bits++;
  return bits;
}

/**
 * The finer bits of all angles, a column for each axis.
 *
 * @param {Uint8Array} data
 * @param {Float32Array[]} books of log-scales
 * @param {Uint16Array[]} columns of their codes
 * @returns {Uint16Array[]}
 */
export function decodeFiner(data, books, columns) {
  const [first, second, third] = columns;
  const count = first.length;
  const widths = new Uint8Array(3 * count);
  let total = 0;
  for (let i = 0; i < count; i++) {
    const a = books[0][first[i]];
    const b = books[1][second[i]];
    const c = books[2][third[i]];
    widths[3 * i] = finerBits(b, c);
    widths[3 * i + 1] = finerBits(a, c);
    widths[3 * i + 2] = finerBits(a, b);
    total += widths[3 * i] + widths[3 * i + 1] + widths[3 * i + 2];
  }
  const bits = exactBits(data, total);
  const found = [new Uint16Array(count), new Uint16Array(count), new Uint16Array(count)];
  for (let i = 0; i < count; i++) {
    for (let axis = 0; axis < 3; axis++) found[axis][i] = bits.take(widths[3 * i + axis]);
  }
  return found;
}

/**
 * Unit quaternions (w, x, y, z) of axis times angle, of at most a block of Gaussians.
 *
 * @param {Scalar} scalar
 * @param {Uint16Array[]} columns three of cells, then three of finer bits
 * @param {number} from the first of them in the columns
 * @param {number} to
 * @param {Float32Array} logScales in columns
 * @param {Float32Array} quats in columns
 */
export function turn({ step, columns: cells }, columns, from, to, logScales, quats) {
  const angle = (/** @type {number} */ axis, /** @type {number} */ i, /** @type {number} */ bits) =>
    step * (columns[axis][i] + cells[axis].least - 0.5 + (columns[3 + axis][i] + 0.5) / (1 << bits));
  for (let i = from, row = 0; i < to; i++, row++) {
    const a = logScales[row];
    const b = logScales[row + BLOCK];
    const c = logScales[row + 2 * BLOCK];
    const x = angle(0, i, finerBits(b, c));
    const y = angle(1, i, finerBits(a, c));
    const z = angle(2, i, finerBits(a, b));
    const whole = Math.sqrt(x * x + y * y + z * z);
    const share = whole > 1e-9 ? Math.sin(whole / 2) / whole : 0.5;
    quats[row] = Math.cos(whole / 2);
    quats[row + BLOCK] = share * x;
    quats[row + 2 * BLOCK] = share * y;
    quats[row + 3 * BLOCK] = share * z;
  }
}
