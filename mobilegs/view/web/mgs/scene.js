/** What a renderer takes: attributes of Gaussians, of all of a scene or of some in a row. */

/**
 * @typedef {object} Gaussians
 * @property {number} count how many
 * @property {Uint16Array} positions the bits of the centres as the file holds them, 3 halves each
 * @property {[number, number]} logScaleRange what no logarithm of a standard deviation lies outside of
 * @property {Float32Array} logScales logarithms of the standard deviations, world units, 3 each
 * @property {Float32Array} scales standard deviations, world units, 3 each
 * @property {Float32Array} quats wxyz, 4 each, of length 1, or 0: then it is not to be drawn
 * @property {Float32Array} sh harmonics of the colour: 12 columns, 4 coefficients of r, g, b each
 * @property {Float32Array} lobes harmonics for the opacity's logit and for phi, in pairs of columns,
 *     `(lobeDegree + 1)^2` of them
 * @property {number} lobeDegree 0 to 3; 0 if the file has no lobes: then they are constant
 */

/**
 * Gaussians that have nothing but a place.
 *
 * @param {Uint16Array} positions
 * @param {number} lobeDegree
 * @param {[number, number]} logScaleRange
 * @returns {Gaussians}
 */
export function makeGaussians(positions, lobeDegree, logScaleRange) {
  const count = positions.length / 3;
  return {
    count,
    positions,
    logScaleRange,
    logScales: new Float32Array(3 * count),
    scales: new Float32Array(3 * count),
    quats: new Float32Array(4 * count),
    sh: new Float32Array(12 * count),
    lobes: new Float32Array(2 * (lobeDegree + 1) ** 2 * count),
    lobeDegree,
  };
}

/**
 * Divides each quaternion by its length; what has none stays 0.
 *
 * @param {Float32Array} quats
 */
export function normaliseQuats(quats) {
  for (let i = 0; i < quats.length; i += 4) {
    const w = quats[i];
    const x = quats[i + 1];
    const y = quats[i + 2];
    const z = quats[i + 3];
    const length = Math.sqrt(w * w + x * x + y * y + z * z) || 1;
    quats[i] = w / length;
    quats[i + 1] = x / length;
    quats[i + 2] = y / length;
    quats[i + 3] = z / length;
  }
}

/**
 * Gives every Gaussian the same numbers, each in a column of its own.
 *
 * @param {Float32Array} array
 * @param {Float32Array} numbers
 */
export function fillColumns(array, numbers) {
  const count = array.length / numbers.length;
  for (let i = 0; i < numbers.length; i++) array.fill(numbers[i], i * count, (i + 1) * count);
}

/**
 * Gives every Gaussian the same numbers.
 *
 * @param {Float32Array | Uint32Array} array
 * @param {ArrayLike<number>} numbers
 */
export function fillRows(array, numbers) {
  if (array.length === 0) return;
  array.set(numbers);
  // what is filled doubles until it is all
  for (let filled = numbers.length; filled < array.length; filled *= 2) {
    array.copyWithin(filled, 0, filled);
  }
}
