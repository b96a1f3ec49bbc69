/** The Gaussians that an edit removes: regions of space, lassos, counts of cameras; with undo. */

import { dot, minus } from "../viewer/vector.js";

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../viewer/vector.js").Vector} Vector */
/** @typedef {Uint8Array<ArrayBuffer>} Mask 1 for each selected Gaussian */
/**
 * @typedef {object} Box
 * @property {Vector} center
 * @property {Vector} half sizes along its axes
 * @property {[Vector, Vector, Vector]} axes of length 1, perpendicular
 */

/** @param {Float32Array} means 3 each @param {(point: Vector) => boolean} test @returns {Mask} */
function selected(means, test) {
  const mask = new Uint8Array(means.length / 3);
  for (let i = 0; i < mask.length; i++) {
    if (test([means[3 * i], means[3 * i + 1], means[3 * i + 2]])) mask[i] = 1;
  }
  return mask;
}

/** @param {Float32Array} means @param {Box} box */
export const inBox = (means, { center, half, axes }) =>
  selected(means, (point) => {
    const from = minus(point, center);
    return axes.every((axis, k) => Math.abs(dot(from, axis)) <= half[k]);
  });

/** @param {Float32Array} means @param {Vector} center @param {number} radius */
export const inSphere = (means, center, radius) =>
  selected(means, (point) => Math.hypot(...minus(point, center)) <= radius);

/** @param {Float32Array} means @param {Vector} normal @param {number} offset */
export const below = (means, normal, offset) => selected(means, (point) => dot(point, normal) < offset);

/**
 * Gaussians whose centres lie in a polygon of the picture, at any depth.
 *
 * @param {Float32Array} means
 * @param {Camera} camera
 * @param {[number, number][]} polygon pixels of the camera
 */
export function inLasso(means, { viewmat: m, fx, fy, cx, cy, near }, polygon) {
  return selected(means, ([a, b, c]) => {
    const z = m[8] * a + m[9] * b + m[10] * c + m[11];
    if (z <= near) return false;
    const x = (fx * (m[0] * a + m[1] * b + m[2] * c + m[3])) / z + cx;
    const y = (fy * (m[4] * a + m[5] * b + m[6] * c + m[7])) / z + cy;
    let inside = false;
    polygon.forEach(([x1, y1], i) => {
      const [x2, y2] = polygon.at(i - 1) ?? [0, 0];
      if (y1 > y !== y2 > y && x < x1 + ((y - y1) / (y2 - y1)) * (x2 - x1)) inside = !inside;
    });
    return inside;
  });
}

/** @param {Uint16Array} seen cameras per Gaussian @param {number} least */
export const seenByFewer = (seen, least) => Uint8Array.from(seen, (count) => Number(count < least));

/** @param {Mask} mask @returns {Mask} the others */
export const inverted = (mask) => mask.map((value) => 1 - value);

/** Gaussians that are removed, in steps that can be undone. */
export class History {
  /** @type {Mask} */
  hidden;
  /** Rows that each step removed. @type {number[][]} */
  #done = [];
  /** @type {number[][]} */
  #undone = [];

  /** @param {number} count Gaussians */
  constructor(count) {
    this.hidden = new Uint8Array(count);
  }

  get removed() {
    return this.#done.reduce((sum, rows) => sum + rows.length, 0);
  }

  get canUndo() {
    return this.#done.length > 0;
  }

  get canRedo() {
    return this.#undone.length > 0;
  }

  /** Remove more. @param {Mask} mask @returns {number} how many */
  remove(mask) {
    /** @type {number[]} */
    const rows = [];
    mask.forEach((value, i) => value && !this.hidden[i] && rows.push(i));
    if (!rows.length) return 0;
    this.#mark(rows, 1);
    this.#done.push(rows);
    this.#undone = [];
    return rows.length;
  }

  undo() {
    const rows = this.#done.pop();
    if (!rows) return;
    this.#mark(rows, 0);
    this.#undone.push(rows);
  }

  redo() {
    const rows = this.#undone.pop();
    if (!rows) return;
    this.#mark(rows, 1);
    this.#done.push(rows);
  }

  /** The Gaussians that are removed together with those of a mask. @param {Mask} mask @returns {Mask} */
  with(mask) {
    return this.hidden.map((value, i) => value | mask[i]);
  }

  /** One bit per Gaussian, lowest first, as base64. */
  get bits() {
    const bytes = new Uint8Array(Math.ceil(this.hidden.length / 8));
    this.hidden.forEach((value, i) => (bytes[i >> 3] |= value << (i & 7)));
    let text = "";
    for (let from = 0; from < bytes.length; from += 0x8000) {
      text += String.fromCharCode(...bytes.subarray(from, from + 0x8000));
    }
    return btoa(text);
  }

  /** @param {number[]} rows @param {0 | 1} value */
  #mark(rows, value) {
    for (const row of rows) this.hidden[row] = value;
  }
}
