/** Rotations as three angles, each as fine as its Gaussian needs. docs/reference/format.md, section 6. */

import { BitReader, exactBits } from "./bits.js";
import { BLOCK } from "./block_memory.js";

/** @typedef {import("./header.js").Scalar} Scalar */

/** Differences of log-scales from which on an angle has one more bit, in 256ths. */
const LIMITS = [53, 210, 405, 600, 787, 970, 1151, 1329];
/** Number of refinement bits by the difference of log-scales in 256ths. */
const FINER = Uint8Array.from({ length: 1330 }, (_, apart) => LIMITS.filter((limit) => limit <= apart).length);
/** Position of an angle in its cell, by its refinement bits below a leading one: the middle is 0. */
const PLACES = Float64Array.from({ length: 512 }, (_, bits) => (bits + 0.5) / 2 ** (31 - Math.clz32(bits)) - 1.5);
/** The squared half angle up to which the series below are exact to 1e-9. */
const SERIES_MAX = 2.5;

/** @param {number} a @param {number} b log-scales, float32 values */
const refinementBits = (a, b) => FINER[Math.min(256 * Math.abs(Math.fround(a - b)), 1329) | 0];

/**
 * Decode the refinement bits of all angles, each below a leading one, in a column per axis.
 *
 * @param {Uint8Array} data
 * @param {Float32Array[]} books of log-scales
 * @param {Uint16Array[]} columns of their codes
 * @returns {Uint16Array[]}
 */
export function decodeRefinements(data, books, columns) {
  const [first, second, third] = columns;
  const count = first.length;
  const found = [new Uint16Array(count), new Uint16Array(count), new Uint16Array(count)];
  const [x, y, z] = found;
  const [a, b, c] = books;
  const bits = new BitReader(data);
  let total = 0;
  for (let i = 0; i < count; i++) {
    const u = a[first[i]];
    const v = b[second[i]];
    const w = c[third[i]];
    const p = refinementBits(v, w);
    const q = refinementBits(u, w);
    const r = refinementBits(u, v);
    // at most 24 bits; zeros after the end
    const all = bits.take(p + q + r);
    x[i] = (1 << p) | (all & ((1 << p) - 1));
    y[i] = (1 << q) | ((all >>> p) & ((1 << q) - 1));
    z[i] = (1 << r) | (all >>> (p + q));
    total += p + q + r;
  }
  exactBits(data, total);
  return found;
}

/**
 * Unit quaternions (w, x, y, z) from rotation vectors, for at most a block of Gaussians.
 *
 * @param {Scalar} scalar
 * @param {Uint16Array[]} columns three of cells, then three of refinement bits
 * @param {number} from the first of them in the columns
 * @param {number} to
 * @param {Float32Array} quats in columns
 */
export function decodeQuaternions({ step, columns: [{ least: a }, { least: b }, { least: c }] }, columns, from, to, quats) {
  const [cellsX, cellsY, cellsZ, finerX, finerY, finerZ] = columns;
  for (let i = from, row = 0; i < to; i++, row++) {
    const x = step * (cellsX[i] + a + PLACES[finerX[i]]);
    const y = step * (cellsY[i] + b + PLACES[finerY[i]]);
    const z = step * (cellsZ[i] + c + PLACES[finerZ[i]]);
    // s: the squared half angle; its cosine; its sine divided by the angle
    const s = (x * x + y * y + z * z) / 4;
    let cosine = 1 + s * (-1 / 2 + s * (1 / 24 + s * (-1 / 720 + s * (1 / 40320 + s * (-1 / 3628800 + s * (1 / 479001600 - s / 87178291200))))));
    let share = 1 / 2 + s * (-1 / 12 + s * (1 / 240 + s * (-1 / 10080 + s * (1 / 725760 + s * (-1 / 79833600 + s / 12454041600)))));
    if (s > SERIES_MAX) {
      const half = Math.sqrt(s);
      cosine = Math.cos(half);
      share = Math.sin(half) / (2 * half);
    }
    quats[row] = cosine;
    quats[row + BLOCK] = share * x;
    quats[row + 2 * BLOCK] = share * y;
    quats[row + 3 * BLOCK] = share * z;
  }
}
