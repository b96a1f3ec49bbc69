/** The upward direction of a scene: axes by name, and the direction that cameras share; as mobilegs/up.py. */

import { cross, dot, minus, plus, unit } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */

const TRUST = 0.02; // weight of the cameras' mean upward direction
const NUMBER = /^-?\d{1,9}(\.\d{1,9})?$/;

/** In the order in which the viewer tries them: COLMAP's, that of nerfstudio and Blender, OpenGL's. @type {Map<string, Vector>} */
export const AXES = new Map([
  ["-y", [0, -1, 0]],
  ["z", [0, 0, 1]],
  ["y", [0, 1, 0]],
  ["-z", [0, 0, -1]],
  ["x", [1, 0, 0]],
  ["-x", [-1, 0, 0]],
]);

/** The upward direction of scenes whose file names none. @type {Vector} */
export const USUAL = [0, -1, 0];

/**
 * The upward direction that cameras share: they are held level, so it is perpendicular to their right axes.
 * Where all look the same way, the mean upward direction decides.
 *
 * @param {{right: Vector, down: Vector}[]} axes
 * @returns {Vector}
 */
export function upOfCameras(axes) {
  const mean = unit(axes.reduce((sum, { down }) => minus(sum, down), /** @type {Vector} */ ([0, 0, 0])));
  let up = mean;
  // power iteration: the largest eigenvector of `(1 + TRUST) - mean of r r^T + TRUST mean mean^T`
  for (let step = 0; step < 200; step++) {
    /** @type {Vector} */
    let next = plus([0, 0, 0], up, 1 + TRUST);
    for (const { right } of axes) next = plus(next, right, -dot(right, up) / axes.length);
    up = unit(plus(next, mean, TRUST * dot(mean, up)));
  }
  return up;
}

/**
 * A vector after the smallest rotation that takes `USUAL` to `up`; half a turn around x for its opposite.
 *
 * @param {Vector} vector
 * @param {Vector} up length 1
 * @returns {Vector}
 */
export function turnedFromUsual(vector, up) {
  const cosine = dot(USUAL, up);
  if (cosine < 1e-9 - 1) return [vector[0], -vector[1], -vector[2]];
  const axis = cross(USUAL, up);
  const once = cross(axis, vector);
  return plus(plus(vector, once), cross(axis, once), 1 / (1 + cosine));
}

/**
 * The direction of a text `X Y Z`, as files hold it, at length 1; null for anything else.
 *
 * @param {unknown} text
 * @returns {Vector | null}
 */
export function parsedUp(text) {
  const words = typeof text === "string" ? text.trim().split(/\s+/) : [];
  if (words.length !== 3 || !words.every((word) => NUMBER.test(word))) return null;
  const given = /** @type {Vector} */ (words.map(Number));
  return given.some((number) => number !== 0) ? unit(given) : null;
}

/**
 * The next name of an axis to point up, after `now`; null is the scene's own direction, which comes first.
 *
 * @param {string | null} now
 * @param {Vector} own direction of the scene
 * @returns {string | null}
 */
export function nextAxis(now, own) {
  const names = [...AXES.keys()];
  const along = (/** @type {string} */ name) => dot(AXES.get(name) ?? USUAL, own);
  const nearest = names.reduce((best, name) => (along(name) > along(best) ? name : best));
  const steps = [null, ...names.filter((name) => name !== nearest)];
  return steps[(steps.indexOf(now === nearest ? null : now) + 1) % steps.length];
}
