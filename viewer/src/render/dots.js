/**
 * The first picture of a scene: dots where some of its Gaussians are, when no more than that is known.
 *
 * It has shaders of its own, which a device compiles far sooner than those of a scene.
 */

/** @typedef {import("./types.js").Camera} Camera */
/**
 * @typedef {object} Dots
 * @property {Float32Array<ArrayBuffer>} means x, y, z of each, world units
 * @property {[number, number, number]} color of all, sRGB in [0, 1]
 * @property {number} side of each, world units
 * @property {[number, number, number]} background sRGB in [0, 1]; read for every frame
 */

export const DOT_BYTES = 80;
const VERTICES = 6; // of a dot
const LEAST = 1 / 500; // sides of far dots, in heights of the picture

/**
 * The struct of dots.wgsl, which dots.glsl has as vectors.
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

/** Each centre once for every vertex. @param {Dots} dots */
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
