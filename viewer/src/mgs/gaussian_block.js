/** What a renderer takes: attributes of Gaussians, of a block or the beginning of one. */

import { BLOCK } from "./block_memory.js";

/**
 * @typedef {object} Gaussians in columns of `BLOCK` numbers
 * @property {number} count how many
 * @property {Uint16Array} positions the bits of the centres as the file holds them, 3 halves each
 * @property {[number, number]} scaleRange what no standard deviation lies outside of, but for dots
 * @property {Float32Array} logScales logarithms of the standard deviations, world units, 3 columns
 * @property {Float32Array} scales standard deviations, world units, 3 columns
 * @property {Float32Array} quats wxyz, 4 columns, of length 1, or 0: then it is not to be drawn
 * @property {Float32Array} sh harmonics of the colour: 12 columns, 4 coefficients of r, g, b each
 * @property {Float32Array} lobes harmonics for the opacity's logit and for phi, in pairs of columns,
 *     `(lobeDegree + 1)^2` of them, and two columns of zeros
 * @property {Float32Array} words room for what is made of them, 18 columns
 * @property {number} lobeDegree 0 to 3; 0 if the file has no lobes: then they are constant
 * @property {WebAssembly.Memory | null} memory where all columns lie, for WebAssembly
 */

/**
 * Gives all Gaussians of a block the same numbers, each in a column of its own.
 *
 * @param {Float32Array} columns
 * @param {ArrayLike<number>} numbers
 */
export function fill(columns, numbers) {
  for (let i = 0; i < numbers.length; i++) columns.fill(numbers[i], i * BLOCK, (i + 1) * BLOCK);
}
