/** Vectors of three numbers. */

/** @typedef {[number, number, number]} Vector */

/** @param {Vector} a @param {Vector} b @param {number} [scale] @returns {Vector} `a + scale b` */
export const plus = (a, b, scale = 1) => [
  a[0] + scale * b[0],
  a[1] + scale * b[1],
  a[2] + scale * b[2],
];

/** @param {Vector} a @param {Vector} b @returns {Vector} `a - b` */
export const minus = (a, b) => plus(a, b, -1);

/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {Vector} a @param {Vector} b @returns {Vector} */
export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** @param {Vector} a */
export const length = (a) => Math.hypot(...a);

/** @param {Vector} a @returns {Vector} of length 1, or the x axis for one of length 0 */
export function unit(a) {
  const size = length(a);
  return size > 0 ? [a[0] / size, a[1] / size, a[2] / size] : [1, 0, 0];
}

/**
 * @param {Vector} a
 * @param {Vector} axis of length 1
 * @param {number} angle radians, counterclockwise where the axis points at the eye
 * @returns {Vector}
 */
export function turned(a, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const along = dot(a, axis) * (1 - c);
  const across = cross(axis, a);
  return plus(plus([a[0] * c, a[1] * c, a[2] * c], across, s), axis, along);
}
