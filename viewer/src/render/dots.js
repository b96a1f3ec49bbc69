/**
 * Preview of a scene: dots at the means of some Gaussians, before other attributes have arrived.
 *
 * Its small shaders compile much faster than those of a scene.
 */

/** @typedef {import("./types.js").Camera} Camera */
/**
 * @typedef {object} Dots
 * @property {Float32Array<ArrayBuffer>} means x, y, z of each, world units
 * @property {[number, number, number]} color of all, sRGB in [0, 1]
 * @property {number} side of each, world units
 * @property {[number, number, number]} background sRGB in [0, 1]; read in every frame
 */

export const DOT_BYTES = 80;
const VERTICES = 6; // per dot
const LEAST = 1 / 500; // smallest side, as a share of the image's height

/**
 * The uniforms of dots.wgsl and dots.glsl.
 *
 * @param {Dots} dots
 * @param {Camera} camera
 * @returns {Float32Array<ArrayBuffer>}
 */
export function packDots({ color, side }, { viewmat, fx, fy, cx, cy, width, height, near }) {
  const [x, y, z] = [0, 4, 8].map((at) => Array.from(viewmat).slice(at, at + 4));
  return Float32Array.of(
    ...x.map((value, i) => (2 * (fx * value + cx * z[i])) / width - z[i]),
    ...y.map((value, i) => z[i] - (2 * (fy * value + cy * z[i])) / height),
    ...z,
    ...color,
    near,
    (fy * side) / 2,
    (LEAST * height) / 2,
    2 / width,
    2 / height,
  );
}

/** Each mean, repeated for every vertex. @param {Dots} dots */
export function verticesOf({ means }) {
  const all = new Float32Array(VERTICES * means.length);
  for (let i = 0, at = 0; i < means.length; i += 3) {
    for (const end = at + 3 * VERTICES; at < end; at += 3) {
      all[at] = means[i];
      all[at + 1] = means[i + 1];
      all[at + 2] = means[i + 2];
    }
  }
  return all;
}
