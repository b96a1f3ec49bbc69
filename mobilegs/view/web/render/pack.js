/**
 * From what a `.mgs` file holds of each Gaussian to the words that packed.wgsl and packed.glsl read.
 *
 * shapes, 4 words: x, y | z, two scales of lobes | log-scales, 11 + 11 + 10 bits | rotation
 * colors, 4 words: constant r, g | constant b, a scale, first coefficient | eight more
 * lobes, 1 word and then 1 for two coefficients: constants | logit, phi, logit, phi ...
 *
 * Positions are the file's own halves, so are constants; the coefficients that depend on the
 * direction are bytes, 127 of which are a scale in eighths of octaves; a rotation is the three smaller
 * parts of its quaternion in 10 bits each, behind the number of the largest. With lobes of degree 2
 * that is 52 bytes.
 */

import { toHalf } from "../mgs/half.js";
import { fillRows } from "../mgs/scene.js";
import { strides } from "./types.js";

/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/scene.js").Part} ScenePart */
/** @typedef {import("../mgs/scene.js").Scene} Scene */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {Uint32Array<ArrayBuffer>} Words */

const WEIGHTINGS = ["mobile_gs", "no_depth", "no_scale", "sort_free_gs"];
const INVISIBLE = -1e4; // logit of an opacity that nothing brings back
const STEPS = [2047, 2047, 1023]; // of log-scales
/** What a scale's byte stands for. */
const SCALES = Float64Array.from({ length: 256 }, (_, byte) => 2 ** (byte / 8 - 16));
const TURN = 511 / Math.SQRT1_2; // no smaller part of a unit quaternion is above that root
/** Which packed parts a part of the scene goes into. @type {Record<ScenePart, Part[]>} */
const PACKED_OF = {
  means: ["shapes"],
  logScales: ["shapes"],
  quats: ["shapes", "lobes"],
  sh: ["colors"],
  lobes: ["shapes", "lobes"],
};

/**
 * A scene whose positions have just arrived, all the rest being the same for all Gaussians.
 *
 * @param {Header} header
 * @param {Scene} scene
 * @returns {SceneData}
 */
export function packScene({ weighting, background, frame }, scene) {
  const { count, logScaleRange } = scene;
  const facts = {
    count,
    packing: {
      center: /** @type {[number, number, number]} */ (Array.from(frame.center)),
      unit: frame.radius * 2 ** frame.exponent,
      leastLogScale: logScaleRange[0],
      logScaleSpan: logScaleRange[1] - logScaleRange[0],
    },
    shSize: 4,
    lobeSize: (scene.lobeDegree + 1) ** 2,
    sorted: false,
    weighting: {
      index: WEIGHTINGS.indexOf(weighting.name),
      exponentMax: weighting.exponent_max,
      sigma: weighting.sigma,
      backgroundWeight: weighting.background_weight,
    },
    background: /** @type {[number, number, number]} */ (Array.from(background)),
  };
  const nothing = new Uint32Array(0);
  const data = { ...facts, shapes: nothing, colors: nothing, lobes: nothing };
  data.shapes = packRows(scene, "shapes", 0, count);
  for (const part of /** @type {Part[]} */ (["colors", "lobes"])) {
    const words = new Uint32Array(strides(data)[part] * count);
    if (count > 0) fillRows(words, packRows(scene, part, 0, 1));
    data[part] = words;
  }
  return data;
}

/**
 * The packed parts that must be made anew when parts of the scene have changed.
 *
 * @param {ScenePart[]} changed
 * @returns {Part[]}
 */
export function packedParts(changed) {
  return [...new Set(changed.flatMap((part) => PACKED_OF[part]))];
}

/**
 * One packed part of the Gaussians from `from` up to, but without, `to`.
 *
 * @param {Scene} scene
 * @param {Part} part
 * @param {number} from
 * @param {number} to
 * @returns {Words}
 */
export function packRows(scene, part, from, to) {
  if (part === "shapes") return packShapes(scene, from, to);
  if (part === "colors") return packColors(scene, from, to);
  return packLobes(scene, from, to);
}

/** @param {Scene} scene @param {number} from @param {number} to */
function packShapes(scene, from, to) {
  const { positions, logScales, quats, lobes, count, logScaleRange } = scene;
  const [least, largest] = logScaleRange;
  const grow = largest > least ? 1 / (largest - least) : 0;
  const stride = lobes.length / count;
  const words = new Uint32Array(4 * (to - from));
  for (let i = from, at = 0; i < to; i++, at += 4) {
    const scales = scaleByte(lobes, stride * i, stride, 0) | (scaleByte(lobes, stride * i, stride, 1) << 8);
    words[at] = positions[3 * i] | (positions[3 * i + 1] << 16);
    words[at + 1] = positions[3 * i + 2] | (scales << 16);
    let logs = 0;
    for (let axis = 2; axis >= 0; axis--) {
      const share = Math.min(Math.max((logScales[3 * i + axis] - least) * grow, 0), 1);
      logs = (logs << 11) | Math.round(STEPS[axis] * share);
    }
    words[at + 2] = logs;
    words[at + 3] = rotationWord(quats, 4 * i);
  }
  return words;
}

/** @param {Float32Array} quats @param {number} at */
function rotationWord(quats, at) {
  let largest = 0;
  for (let i = 1; i < 4; i++) {
    if (Math.abs(quats[at + i]) > Math.abs(quats[at + largest])) largest = i;
  }
  const sign = quats[at + largest] < 0 ? -TURN : TURN; // a quaternion and its negative are one turn
  let word = largest;
  for (let i = 0; i < 4; i++) {
    if (i !== largest) word = (word << 10) | (Math.round(sign * quats[at + i]) & 1023);
  }
  return word;
}

/** @param {Scene} scene @param {number} from @param {number} to */
function packColors({ sh }, from, to) {
  const words = new Uint32Array(4 * (to - from));
  for (let i = from, at = 0; i < to; i++, at += 4) {
    const place = 12 * i;
    let most = 0;
    for (let k = 3; k < 12; k++) most = Math.max(most, Math.abs(sh[place + k]));
    const scale = byteOf(most);
    const grow = 127 / SCALES[scale];
    const byte = (/** @type {number} */ k) => Math.round(grow * sh[place + k]) & 255;
    words[at] = toHalf(sh[place]) | (toHalf(sh[place + 1]) << 16);
    words[at + 1] = toHalf(sh[place + 2]) | (scale << 16) | (byte(3) << 24);
    words[at + 2] = byte(4) | (byte(5) << 8) | (byte(6) << 16) | (byte(7) << 24);
    words[at + 3] = byte(8) | (byte(9) << 8) | (byte(10) << 16) | (byte(11) << 24);
  }
  return words;
}

/** @param {Scene} scene @param {number} from @param {number} to */
function packLobes({ lobes, quats, count }, from, to) {
  const size = lobes.length / count;
  const stride = (size / 2 + 2) >> 1;
  const words = new Uint32Array(stride * (to - from));
  for (let i = from, at = 0; i < to; i++, at += stride) {
    const place = size * i;
    const q = 4 * i; // a rotation that is none
    const hidden = !(quats[q] || quats[q + 1] || quats[q + 2] || quats[q + 3]);
    words[at] = toHalf(hidden ? INVISIBLE : lobes[place]) | (toHalf(lobes[place + 1]) << 16);
    const logits = 127 / SCALES[scaleByte(lobes, place, size, 0)];
    const phis = 127 / SCALES[scaleByte(lobes, place, size, 1)];
    for (let k = 2; k < size; k += 2) {
      const pair =
        (Math.round(logits * lobes[place + k]) & 255) |
        ((Math.round(phis * lobes[place + k + 1]) & 255) << 8);
      words[at + ((k + 2) >> 2)] |= pair << (k % 4 === 2 ? 0 : 16);
    }
  }
  return words;
}

/** The byte of the largest coefficient that depends on the direction. @param {Float32Array} lobes @param {number} place @param {number} size @param {0 | 1} which */
function scaleByte(lobes, place, size, which) {
  let most = 0;
  for (let k = 2 + which; k < size; k += 2) most = Math.max(most, Math.abs(lobes[place + k]));
  return byteOf(most);
}

/** The least scale that reaches a value: eight steps an octave, from 2^-16 on. @param {number} most */
function byteOf(most) {
  if (!(most > SCALES[0])) return 0;
  // the logarithm may be off by a rounding
  let byte = Math.min(255, Math.trunc(8 * Math.log2(most)) + 127);
  while (byte < 255 && SCALES[byte] < most) byte++;
  return byte;
}
