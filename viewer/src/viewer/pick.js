/** Picking: the point of the scene under a pixel. */

import { meanLogit } from "../render/types.js";

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../render/types.js").Numbers} Numbers */
/** @typedef {import("./vector.js").Vector} Vector */

const NEARBY = 12; // pixels around the pointer

/**
 * The nearest mean within 12 pixels of a pixel, among Gaussians with an opacity of at least 1/2.
 *
 * @param {Float32Array} means 3 each
 * @param {Float32Array} logits of the mean opacity, at least as many
 * @param {Camera} camera
 * @param {number} x pixels
 * @param {number} y pixels
 * @returns {Vector | null}
 */
export function pointUnder(means, logits, camera, x, y) {
  const { viewmat: m, fx, fy, cx, cy, near } = camera;
  let best = -1;
  let nearest = Infinity;
  for (let i = 0; 3 * i < means.length; i++) {
    if (logits[i] < 0) continue;
    const [a, b, c] = [means[3 * i], means[3 * i + 1], means[3 * i + 2]];
    const z = m[8] * a + m[9] * b + m[10] * c + m[11];
    if (z <= near || z >= nearest) continue;
    const dx = (fx * (m[0] * a + m[1] * b + m[2] * c + m[3])) / z + cx - x;
    const dy = (fy * (m[4] * a + m[5] * b + m[6] * c + m[7])) / z + cy - y;
    if (dx * dx + dy * dy > NEARBY * NEARBY) continue;
    nearest = z;
    best = i;
  }
  return best < 0 ? null : [means[3 * best], means[3 * best + 1], means[3 * best + 2]];
}

/**
 * Record the mean opacities of some Gaussians.
 *
 * @param {Float32Array} logits
 * @param {number} stride numbers per Gaussian
 * @param {number} from the first of them
 * @param {Numbers} lobes
 */
export function recordLogits(logits, stride, from, lobes) {
  const packed = lobes instanceof Uint32Array;
  for (let i = 0; i * stride < lobes.length; i++) {
    logits[from + i] = packed ? meanLogit(lobes[i * stride]) : lobes[i * stride];
  }
}
