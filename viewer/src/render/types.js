/** Types that the renderers share. */

import { fromFloat16 } from "../mgs/float16.js";
import { INPUT_WORDS } from "./view_network.js";

/**
 * A scene in the layout of the shaders. All numbers are finite.
 *
 * Wide parts are float32. Packed parts are words (see pack.js): a quarter of the size, for `.mgs` scenes,
 * whose harmonics have degree 1.
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
 * @property {Float32Array<ArrayBuffer> | null} [network] matrices of the view network of a packed scene
 *     (view_network.js); then `lobes` holds its inputs that do not depend on the view (pack.js)
 * @property {boolean} sorted whether Gaussians are blended back to front, or as weighted sums
 * @property {Weighting} weighting of a sort-free scene
 * @property {Footprint} [footprint] how a Gaussian covers pixels; by default as 3DGS does
 * @property {import("../viewer/vector.js").Vector | null} [up] upward direction that the file names
 * @property {Record<string, string>} [notes] the first view that the file names, as the note `start`
 * @property {[number, number, number]} background sRGB in [0, 1]; read in every frame, so that
 *     the owner can change it
 */

/** @typedef {Float32Array<ArrayBuffer> | Uint32Array<ArrayBuffer>} Numbers */
/** @typedef {"shapes" | "colors" | "lobes"} Part */

/**
 * Constants that convert packed numbers to world units.
 *
 * @typedef {object} Packing
 * @property {[number, number, number]} center of positions, world units
 * @property {number} unit of positions, world units
 * @property {number} leastScaleBits of the least standard deviation, as a float
 * @property {number} scaleBitsSpan from there to the largest one's
 */

/**
 * The weight of a Gaussian, as in `render/sortfree.py`.
 *
 * @typedef {object} Weighting
 * @property {number} index of the formula: 0 mobile_gs, 1 no_depth, 2 no_scale, 3 sort_free_gs, 4 depth_pass
 * @property {number} exponentMax ceiling of the exponent
 * @property {number} sigma depth from which on the weight of sort_free_gs is 0, world units; with depth_pass, a depth near
 *     which its picture is most exact
 * @property {number} backgroundWeight of the background in the mean
 * @property {number} [alphaMin] contributions below are dropped; sorted scenes have no other than 1/255
 */

/** @typedef {import("../mgs/header.js").Footprint} Footprint */

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
 * Ways to render the same image; the fastest depends on the device.
 *
 * @typedef {object} Variant
 * @property {boolean} floats sums are float32, not float16
 * @property {boolean} strips one quad per instance, not 128
 */

/** Words or floats of a Gaussian in each part. @param {SceneData} scene @returns {Record<Part, number>} */
export function strides({ packing, shSize, lobeSize, network }) {
  if (packing) return { shapes: 4, colors: 4, lobes: network ? INPUT_WORDS : (lobeSize + 2) >> 1 };
  return { shapes: 12, colors: 3 * shSize, lobes: 2 * lobeSize };
}

/** True if a scene is drawn with a depth pass. @param {Pick<SceneData, "sorted" | "weighting">} scene */
export const hasDepthPass = ({ sorted, weighting }) => !sorted && weighting.index === 4;

/** The logit of the mean opacity, from the first packed word of the lobes. @param {number} word */
export function meanLogit(word) {
  return fromFloat16(word & 0xffff);
}

/** The variants of a device. @param {boolean} blendsFloats @returns {Variant[]} */
export const variantsOf = (blendsFloats) =>
  (blendsFloats ? [false, true] : [false]).flatMap((floats) => [
    { floats, strips: false },
    { floats, strips: true },
  ]);
