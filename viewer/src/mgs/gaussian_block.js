/** A block of decoded Gaussians. */

import { BLOCK } from "./block_memory.js";

/**
 * @typedef {object} Gaussians in columns of `BLOCK` numbers
 * @property {number} count how many
 * @property {Uint16Array} positions 3 float16 bit patterns each, as in the file
 * @property {[number, number]} scaleRange minimum and maximum of the standard deviations
 * @property {Float32Array} logScales logarithms of the standard deviations, world units, 3 columns
 * @property {Float32Array} scales standard deviations, world units, 3 columns
 * @property {Float32Array} quats wxyz, 4 columns, of length 1, or 0: then the Gaussian is invisible
 * @property {Float32Array} sh harmonics of the colour: 12 columns, 4 coefficients of r, g, b each
 * @property {Float32Array} lobes harmonics for the opacity's logit and for phi, in pairs of columns,
 *     `(lobeDegree + 1)^2` of them, and two columns of zeros
 * @property {Float32Array} statics inputs of the view network that do not depend on the view, at most 1 in size:
 *     19 columns, as the lobe decoder's; none if the file has no network
 * @property {Float32Array} words output of packing, 18 columns
 * @property {number} lobeDegree 0 to 3; 0 if the file has no lobes: then they are constant
 * @property {WebAssembly.Memory | null} memory where all columns lie, for WebAssembly
 */

/**
 * Fill each column with one number.
 *
 * @param {Float32Array} columns
 * @param {ArrayLike<number>} numbers
 */
export function fill(columns, numbers) {
  for (let i = 0; i < numbers.length; i++) columns.fill(numbers[i], i * BLOCK, (i + 1) * BLOCK);
}
