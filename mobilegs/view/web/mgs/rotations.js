/** Rotations as three angles, each as fine as its Gaussian needs. docs/format.md, section 6. */

import { exactBits } from "./bits.js";

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
  const count = columns[0].length;
  const widths = new Uint8Array(3 * count);
  let total = 0;
  for (let i = 0; i < count; i++) {
    const [a, b, c] = [books[0][columns[0][i]], books[1][columns[1][i]], books[2][columns[2][i]]];
    widths[3 * i] = finerBits(b, c);
    widths[3 * i + 1] = finerBits(a, c);
    widths[3 * i + 2] = finerBits(a, b);
    total += widths[3 * i] + widths[3 * i + 1] + widths[3 * i + 2];
  }
  const bits = exactBits(data, total);
  const found = [new Uint16Array(count), new Uint16Array(count), new Uint16Array(count)];
  for (let i = 0; i < widths.length; i++) found[i % 3][Math.floor(i / 3)] = bits.take(widths[i]);
  return found;
}

/**
 * Unit quaternions (w, x, y, z) of axis times angle.
 *
 * @param {Scalar} scalar
 * @param {Uint16Array[]} columns three of cells, then three of finer bits
 * @param {Float32Array} logScales
 * @param {Float32Array} quats
 */
export function turn({ step, columns: cells }, columns, logScales, quats) {
  const count = columns[0].length;
  const angles = new Float64Array(3);
  for (let i = 0; i < count; i++) {
    const [a, b, c] = logScales.subarray(3 * i, 3 * i + 3);
    for (let axis = 0; axis < 3; axis++) {
      const parts = 1 << finerBits(axis === 0 ? b : a, axis === 2 ? b : c);
      const cell = columns[axis][i] + cells[axis].least;
      angles[axis] = step * (cell - 0.5 + (columns[3 + axis][i] + 0.5) / parts);
    }
    const angle = Math.hypot(angles[0], angles[1], angles[2]);
    const share = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
    quats[4 * i] = Math.cos(angle / 2);
    for (let axis = 0; axis < 3; axis++) quats[4 * i + 1 + axis] = share * angles[axis];
  }
}
