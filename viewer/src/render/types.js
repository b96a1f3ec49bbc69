/** What the renderers of this folder share: what they are given, and how they draw. */

import { fromFloat16 } from "../mgs/float16.js";

/**
 * A scene as GPUs take it. All numbers are finite.
 *
 * Wide, parts are 32-bit floats. Packed, they are words that pack.js explains: a quarter of that,
 * for scenes that add up and have harmonics of degree 1.
 *
 * @typedef {object} SceneData
 * @property {number} count number of Gaussians, at least 0
 * @property {Packing | null} packing how parts are packed; null: they are wide
 * @property {Numbers} shapes wide, 12 each, three rows of four: the half axes at one standard
 *     deviation, in the world, and at each row's end x, y or z of the centre
 * @property {Numbers} colors wide, `3 shSize` each: harmonics, r, g, b inside
 * @property {number} shSize coefficients per colour: 1, 4, 9 or 16
 * @property {Numbers} lobes wide, `2 lobeSize` each: harmonics, inside first for the opacity's
 *     logit, then for phi before its ReLU
 * @property {number} lobeSize coefficients of opacity and phi: 1, 4, 9 or 16
 * @property {boolean} sorted whether Gaussians lie over one another, far ones first, or add up
 * @property {Weighting} weighting of a scene that adds up
 * @property {[number, number, number]} background sRGB in [0, 1]; read for every frame, so that
 *     whoever gave it can change it
 */

/** @typedef {Float32Array<ArrayBuffer> | Uint32Array<ArrayBuffer>} Numbers */
/** @typedef {"shapes" | "colors" | "lobes"} Part */

/**
 * What turns packed numbers into the world's.
 *
 * @typedef {object} Packing
 * @property {[number, number, number]} center of positions, world units
 * @property {number} unit of positions, world units
 * @property {number} leastScaleBits of the least standard deviation, as a float
 * @property {number} scaleBitsSpan from there to the largest one's
 */

/**
 * How much a Gaussian counts, as `render/sortfree.py` defines it.
 *
 * @typedef {object} Weighting
 * @property {number} index of the formula: 0 mobile_gs, 1 no_depth, 2 no_scale, 3 sort_free_gs
 * @property {number} exponentMax ceiling of the exponent
 * @property {number} sigma depth at which a Gaussian stops counting, world units
 * @property {number} backgroundWeight of the background in the mean
 * @property {number} [alphaMin] contributions below are dropped; sorted scenes have no other than 1/255
 */

/**
 * A pinhole camera. Pixels are measured from the picture's top left corner.
 *
 * @typedef {object} Camera
 * @property {ArrayLike<number>} viewmat 16 numbers, row by row: world to camera, OpenCV axes
 * @property {number} fx focal lengths in pixels
 * @property {number} fy
 * @property {number} cx principal point in pixels
 * @property {number} cy
 * @property {number} width pixels
 * @property {number} height
 * @property {number} near Gaussians whose centre has z <= near are not drawn, world units
 */

/**
 * Ways to the same picture; which one is faster depends on the device.
 *
 * @typedef {object} Variant
 * @property {boolean} floats sums are 32-bit floats, not halves
 * @property {boolean} strips quads are an instance each, not 128 of them
 */

/** Words or floats of a Gaussian in each part. @param {SceneData} scene @returns {Record<Part, number>} */
export function strides({ packing, shSize, lobeSize }) {
  if (packing) return { shapes: 4, colors: 4, lobes: (lobeSize + 2) >> 1 };
  return { shapes: 12, colors: 3 * shSize, lobes: 2 * lobeSize };
}

/** The logit of the opacity's mean over all directions in the first packed word of its lobes. @param {number} word */
export function meanLogit(word) {
  return fromFloat16(word & 0xffff);
}
