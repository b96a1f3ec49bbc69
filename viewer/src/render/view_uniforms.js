/** The uniform buffer of a frame: `View` of view.wgsl and view.glsl. */

import { CLASSIC } from "../mgs/header.js";
import { levelPlaces, levelSizes } from "./levels.js";

/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").SceneData} SceneData */

export const VIEW_BYTES = 368;
/**
 * The factor of weights that keeps sums in the range of float16. A depth pass multiplies them by up to exp(8).
 *
 * @param {boolean} depthPass
 */
export const float16Scale = (depthPass) => (depthPass ? 2 ** -10 : 2 ** -6);
/** Depths of a scene: `WORLD_MIN` and `WORLD_MAX` of mobilegs/mgs/limits.py. */
const DEPTHS = [1e-20, 1e20];
const JACOBIAN_MARGIN = 0.3; // as in project.py

/**
 * The same view with n x n pixels in place of each; the resolve pass averages them
 * (mobilegs/render/supersampling.py).
 *
 * @param {Camera} camera
 * @param {number} n
 * @returns {Camera}
 */
export function magnified(camera, n) {
  const { fx, fy, cx, cy, width, height } = camera;
  return { ...camera, fx: n * fx, fy: n * fy, cx: n * cx, cy: n * cy, width: n * width, height: n * height };
}

/**
 * The uniform buffer of a frame.
 *
 * @param {SceneData} scene
 * @param {Camera} camera
 * @param {number} weightScale factor of weights; it cancels in the resolve pass
 * @param {number} levelSigma of the levels, as `level_sigma` of mobilegs; 0: all at full size
 * @param {number} supersampling of the camera's pixels: `magnified`
 * @returns {Float32Array<ArrayBuffer>}
 */
export function viewUniforms(scene, camera, weightScale, levelSigma, supersampling) {
  const { viewmat, fx, fy, cx, cy, width, height, near } = camera;
  const { background, weighting, packing, footprint = CLASSIC } = scene;
  const marginX = (JACOBIAN_MARGIN * 0.5 * width) / fx;
  const marginY = (JACOBIAN_MARGIN * 0.5 * height) / fy;
  const position = [0, 1, 2].map(
    (i) => -(viewmat[i] * viewmat[3] + viewmat[4 + i] * viewmat[7] + viewmat[8 + i] * viewmat[11]),
  );
  const floats = new Float32Array(VIEW_BYTES / 4);
  floats.set([
    ...Array.from(viewmat).slice(0, 12),
    ...[...position, near],
    ...[fx, fy, cx, cy],
    ...[-cx / fx - marginX, (width - cx) / fx + marginX],
    ...[-cy / fy - marginY, (height - cy) / fy + marginY],
    ...[...background, weighting.exponentMax],
    ...[width, height, Math.min(Math.max(weighting.sigma, DEPTHS[0]), DEPTHS[1]), weighting.backgroundWeight],
    weightScale,
  ]);
  const integers = [scene.count, scene.shSize, scene.lobeSize, weighting.index];
  new Int32Array(floats.buffer).set(integers, 33);
  if (packing) {
    const { center, unit, leastScaleBits, scaleBitsSpan } = packing;
    floats.set([...center, unit, leastScaleBits, scaleBitsSpan], 40);
  }
  floats[46] = (!scene.sorted && weighting.alphaMin) || 1 / 255;
  floats[47] = footprint.blur;
  new Int32Array(floats.buffer).set([Number(footprint.antialiased), Number(footprint.soft_edge && !scene.sorted)], 48);
  floats[50] = levelSigma;
  new Int32Array(floats.buffer)[51] = supersampling;
  const sizes = levelSizes(width, height);
  const { places, size } = levelPlaces(width, height);
  const regions = places.flatMap(([x, y], level) => [x, y, x + sizes[level][0], y + sizes[level][1]]);
  floats.set([...regions, ...size], 52);
  return floats;
}
