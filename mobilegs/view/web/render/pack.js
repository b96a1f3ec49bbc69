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

/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/scene.js").Gaussians} Gaussians */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {Uint32Array<ArrayBuffer>} Words */
/** @typedef {Record<Part, Words>} PackedRows */

const WEIGHTINGS = ["mobile_gs", "no_depth", "no_scale", "sort_free_gs"];
// logit of an opacity that nothing brings back
const INVISIBLE = -1e4;
/** Gaussians in a first picture, at most: one of all keeps a slow device from decoding them. */
export const FIRST = 65536;
// of log-scales
const STEPS = [2047, 2047, 1023];
/** What a scale's byte stands for. */
const SCALES = Float32Array.from({ length: 258 }, (_, byte) => 2 ** (byte / 8 - 16));
const SCALE_BITS = new Int32Array(SCALES.buffer);
/** From a number to its byte, by the byte of its scale. */
const GROWTHS = Float64Array.from(SCALES, (scale) => 127 / scale);
// no smaller part of a unit quaternion is above that root
const TURN = 511 / Math.SQRT1_2;

/**
 * A scene whose Gaussians differ by nothing but their place; of many only some are to be seen.
 *
 * @param {Header} header
 * @param {Uint16Array} positions
 * @param {Gaussians} one of them
 * @param {number} [room] Gaussians that there is room for: more than positions, and they are zeros
 * @returns {SceneData & PackedRows}
 */
export function packAlike(header, positions, one, room = positions.length / 3) {
  const scene = emptyScene(header, room, one);
  const { shapes, lobes } = scene;
  const count = positions.length / 3;
  const words = packRows(one);
  for (const part of /** @type {Part[]} */ (["shapes", "colors", "lobes"])) {
    fillRows(scene[part].subarray(0, words[part].length * count), words[part]);
  }
  const [stride, apart] = [words.lobes.length, Math.ceil(count / FIRST)];
  for (let i = 0; i < count; i++) {
    if (i % apart) lobes[i * stride] = toHalf(INVISIBLE) | (words.lobes[0] & 0xffff0000);
  }
  for (let i = 0, at = 0; i < positions.length; i += 3, at += 4) {
    shapes[at] = positions[i] | (positions[i + 1] << 16);
    shapes[at + 1] = positions[i + 2] | (shapes[at + 1] & 0xffff0000);
  }
  return scene;
}

/**
 * A scene without its numbers, which `packRows` gives.
 *
 * @param {Header} header
 * @param {number} count
 * @param {Gaussians} like its degree, and the range of its log-scales
 * @returns {SceneData & PackedRows}
 */
export function emptyScene({ sorted, weighting, background, frame }, count, { lobeDegree, logScaleRange }) {
  return {
    count,
    packing: {
      center: /** @type {[number, number, number]} */ (Array.from(frame.center)),
      unit: frame.radius * 2 ** frame.exponent,
      leastLogScale: logScaleRange[0],
      logScaleSpan: logScaleRange[1] - logScaleRange[0],
    },
    shapes: new Uint32Array(4 * count),
    colors: new Uint32Array(4 * count),
    shSize: 4,
    lobes: new Uint32Array(lobeStride(lobeDegree) * count),
    lobeSize: (lobeDegree + 1) ** 2,
    sorted,
    weighting: {
      index: WEIGHTINGS.indexOf(weighting.name),
      exponentMax: weighting.exponent_max,
      sigma: weighting.sigma,
      backgroundWeight: weighting.background_weight,
      alphaMin: weighting.alpha_min,
    },
    background: /** @type {[number, number, number]} */ (Array.from(background)),
  };
}

/**
 * Packs Gaussians.
 *
 * @param {Gaussians} gaussians
 * @returns {PackedRows}
 */
export function packRows({ count, positions, logScales, quats, sh, lobes, lobeDegree, logScaleRange }) {
  const [least, largest] = logScaleRange;
  const grow = largest > least ? 1 / (largest - least) : 0;
  const size = 2 * (lobeDegree + 1) ** 2;
  const stride = lobeStride(lobeDegree);
  const [shBits, lobeBits] = [sh, lobes].map(bitsOf);
  const packed = {
    shapes: new Uint32Array(4 * count),
    colors: new Uint32Array(4 * count),
    lobes: new Uint32Array(stride * count),
  };
  for (let i = 0; i < count; i++) {
    const scales = packLobes(lobes, lobeBits, i, count, size, packed.lobes, stride * i);
    packColor(sh, shBits, i, count, packed.colors, 4 * i);
    let logs = 0;
    for (let axis = 2; axis >= 0; axis--) {
      const share = Math.min(Math.max((logScales[3 * i + axis] - least) * grow, 0), 1);
      logs = (logs << 11) | (STEPS[axis] * share + 0.5);
    }
    const q = 4 * i;
    packed.shapes[q] = positions[3 * i] | (positions[3 * i + 1] << 16);
    packed.shapes[q + 1] = positions[3 * i + 2] | (scales << 16);
    packed.shapes[q + 2] = logs;
    packed.shapes[q + 3] = rotationWord(quats, q);
    if (quats[q] || quats[q + 1] || quats[q + 2] || quats[q + 3]) continue;
    // no rotation
    packed.lobes[stride * i] = toHalf(INVISIBLE) | (packed.lobes[stride * i] & 0xffff0000);
  }
  return packed;
}

/** Words of a Gaussian's lobes. @param {number} degree */
const lobeStride = (degree) => ((degree + 1) ** 2 + 2) >> 1;

/** @param {Float32Array} quats @param {number} at */
function rotationWord(quats, at) {
  let largest = 0;
  for (let i = 1; i < 4; i++) {
    if (Math.abs(quats[at + i]) > Math.abs(quats[at + largest])) largest = i;
  }
  // a quaternion and its negative are one turn
  const sign = quats[at + largest] < 0 ? -TURN : TURN;
  let word = largest;
  for (let i = 0; i < 4; i++) {
    if (i !== largest) word = (word << 10) | ((sign * quats[at + i] + 1024.5) & 1023);
  }
  return word;
}

/**
 * @param {Float32Array} sh
 * @param {Int32Array} bits
 * @param {number} i
 * @param {number} count from one column to the next
 * @param {Words} words
 * @param {number} at
 */
function packColor(sh, bits, i, count, words, at) {
  const scale = scaleOf(bits, i + 3 * count, sh.length, count);
  const grow = GROWTHS[scale];
  words[at] = toHalf(sh[i]) | (toHalf(sh[i + count]) << 16);
  words[at + 1] = toHalf(sh[i + 2 * count]) | (scale << 16) | (rounded(grow * sh[i + 3 * count]) << 24);
  for (let k = i + 4 * count, word = at + 2; word < at + 4; k += 4 * count, word++) {
    words[word] =
      rounded(grow * sh[k]) |
      (rounded(grow * sh[k + count]) << 8) |
      (rounded(grow * sh[k + 2 * count]) << 16) |
      (rounded(grow * sh[k + 3 * count]) << 24);
  }
}

/**
 * @param {Float32Array} lobes
 * @param {Int32Array} bits
 * @param {number} i
 * @param {number} count from one column to the next
 * @param {number} size columns
 * @param {Words} words
 * @param {number} at
 * @returns {number} both bytes of scales
 */
function packLobes(lobes, bits, i, count, size, words, at) {
  const end = size * count;
  const logit = scaleOf(bits, i + 2 * count, end, 2 * count);
  const phi = scaleOf(bits, i + 3 * count, end, 2 * count);
  const logits = GROWTHS[logit];
  const phis = GROWTHS[phi];
  words[at] = toHalf(lobes[i]) | (toHalf(lobes[i + count]) << 16);
  for (let k = i + 2 * count, word = at + 1; k < end; k += 4 * count, word++) {
    const pair = rounded(logits * lobes[k]) | (rounded(phis * lobes[k + count]) << 8);
    const l = k + 2 * count;
    const next = l < end ? rounded(logits * lobes[l]) | (rounded(phis * lobes[l + count]) << 8) : 0;
    words[word] = pair | (next << 16);
  }
  return logit | (phi << 8);
}

/** @param {Float32Array} numbers */
function bitsOf({ buffer, byteOffset, length }) {
  return new Int32Array(buffer, byteOffset, length);
}

/** The nearest whole number's byte; `Math.round` takes three times as long. @param {number} value above -512 */
function rounded(value) {
  return (value + 512.5) & 255;
}

/**
 * The byte of the least scale that reaches some numbers: eight steps an octave, from 2^-16 on.
 *
 * Bits of positive floats grow with them; there are no branches that nobody can guess.
 *
 * @param {Int32Array} bits
 * @param {number} from
 * @param {number} to
 * @param {number} step
 */
function scaleOf(bits, from, to, step) {
  let most = 0;
  for (let k = from; k < to; k += step) {
    const more = (bits[k] & 0x7fffffff) - most;
    most += more & ~(more >> 31);
  }
  // exponent and three digits: the logarithm is up to 0.7 above them
  let byte = Math.min(Math.max((most >>> 20) - 8 * (127 - 16), 0), 255);
  byte += (SCALE_BITS[byte] - most) >>> 31;
  byte += (SCALE_BITS[byte] - most) >>> 31;
  return Math.min(byte, 255);
}
