/** What a renderer takes: typed arrays that fill up while a file arrives. */

import { SceneError } from "./error.js";

/** @typedef {import("./header.js").Header} Header */
/** @typedef {"means" | "logScales" | "quats" | "sh" | "lobes"} Part */

/**
 * @typedef {object} Scene
 * @property {number} count number of Gaussians
 * @property {Uint16Array} positions the bits of the centres as the file holds them, 3 halves each
 * @property {Float32Array} means centres in world space, 3 each
 * @property {[number, number]} logScaleRange what no logarithm of a standard deviation lies outside of
 * @property {Float32Array} logScales logarithms of the standard deviations, world units, 3 each
 * @property {Float32Array} quats wxyz, 4 each, of length 1, or 0: then it is not to be drawn
 * @property {Float32Array} sh harmonics of the colour, 4 coefficients of r, g, b each
 * @property {Float32Array} lobes harmonics for the opacity's logit and for phi, in pairs,
 *     `(lobeDegree + 1)^2` of them each
 * @property {number} lobeDegree 0 to 3; 0 if the file has no lobes: then they are constant
 * @property {Record<string, Float32Array> | null} network weights of the paper's network, which
 *     must be asked for each view; the lobes then hold nothing but the base opacity
 */

/**
 * A scene of Gaussians that have nothing but a place.
 *
 * @param {Header} header
 * @param {Uint16Array} positions
 * @param {Float32Array} means
 * @param {[number, number]} logScaleRange
 * @param {Record<string, Float32Array> | null} network
 * @returns {Scene}
 */
export function makeScene({ count, lobes }, positions, means, logScaleRange, network) {
  const lobeDegree = lobes === null ? 0 : lobes.degree;
  try {
    return {
      count,
      positions,
      means,
      logScaleRange,
      logScales: new Float32Array(3 * count),
      quats: new Float32Array(4 * count),
      sh: new Float32Array(12 * count),
      lobes: new Float32Array(2 * (lobeDegree + 1) ** 2 * count),
      lobeDegree,
      network,
    };
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
    throw new SceneError(`the scene's ${count} Gaussians do not fit into the memory there is here`);
  }
}

/**
 * Divides each quaternion by its length; what has none stays 0.
 *
 * @param {Float32Array} quats
 * @param {number} from
 * @param {number} to
 */
export function normaliseQuats(quats, from, to) {
  for (let i = 4 * from; i < 4 * to; i += 4) {
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
 * Gives every Gaussian the same numbers.
 *
 * @param {Float32Array | Uint32Array} array
 * @param {ArrayLike<number>} numbers
 */
export function fillRows(array, numbers) {
  array.set(numbers);
  // what is filled doubles until it is all
  for (let filled = numbers.length; filled < array.length; filled *= 2) {
    array.copyWithin(filled, 0, filled);
  }
}
