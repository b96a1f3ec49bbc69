/**
 * Packs decoded Gaussians of a `.mgs` into the words that packed.wgsl and packed.glsl read.
 *
 * shapes, 4 words: x, y | z, two scales of lobes | sizes, 11 + 11 + 10 bits | rotation
 * colors, 4 words: constant r, g | constant b, a scale, first coefficient | eight more
 * lobes, 1 word and then 1 for two coefficients: constants | logit, phi, logit, phi ...
 * with a view network, 10 words: base opacity, first of its inputs | the other 18, two per word
 *
 * Positions and constant coefficients are float16. Coefficients that depend on the direction are signed bytes
 * in units of scale / 127; scales have eight values per octave. A rotation is the index of the largest
 * component of its quaternion and the other three in 10 bits each. Inputs of a network are multiples of 1 / 32767.
 * With lobes of degree 2 a Gaussian takes 52 bytes.
 */

import { toFloat16 } from "../mgs/float16.js";
import { BLOCK } from "../mgs/block_memory.js";
import { kernelsIn } from "../mgs/wasm.js";
import { INPUT_WORDS, networkMatrices } from "./view_network.js";

/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/gaussian_decoder.js").GaussianDecoder} GaussianDecoder */
/** @typedef {import("../mgs/gaussian_decoder.js").QuantizedRows} QuantizedRows */
/** @typedef {import("../mgs/gaussian_block.js").Gaussians} Gaussians */
/** @typedef {import("./types.js").Part} Part */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {import("../mgs/weights.js").Weights} Weights */
/** @typedef {Uint32Array<ArrayBuffer>} Words */
/** @typedef {Record<Part, Words>} PackedRows */

const { fround } = Math;
const WEIGHTINGS = ["mobile_gs", "no_depth", "no_scale", "sort_free_gs", "depth_pass"];
// an opacity logit that no lobe can make visible
export const INVISIBLE = toFloat16(-1e4);
// quantization levels of the standard deviations
const STEPS = [2047, 2047, 1023];
// the smaller components of a unit quaternion are at most sqrt(1/2)
const TURN = fround(511 / Math.SQRT1_2);
/** The byte of a scale is its exponent and three mantissa bits, minus those of the smallest scale, 2^-16. */
const LEAST_SCALE = 8 * (127 - 16);
const BITS = new Uint32Array(1);
const FLOAT = new Float32Array(BITS.buffer);

/** The buffers of a scene or of its rows, to be transferred. @param {Pick<SceneData, Part>} data */
export const buffersOf = ({ shapes, colors, lobes }) => [shapes.buffer, colors.buffer, lobes.buffer];

/**
 * An empty packed scene for the results of `packRows`.
 *
 * @param {Header} header
 * @param {number} count
 * @param {[number, number]} scaleRange of standard deviations
 * @param {Weights | null} [network] weights of the view network
 * @returns {SceneData & PackedRows}
 */
export function emptyScene({ sorted, weighting, footprint, background, grid, lobes }, count, scaleRange, network = null) {
  const degree = lobes?.degree ?? 0;
  const [least, span] = bitsOf(scaleRange);
  return {
    count,
    packing: {
      center: /** @type {[number, number, number]} */ (Array.from(grid.center)),
      unit: grid.radius * 2 ** grid.exponent,
      leastScaleBits: least,
      scaleBitsSpan: span,
    },
    ...emptyRows(network ? INPUT_WORDS : lobeStride(degree), count),
    network: network && networkMatrices(network),
    shSize: 4,
    lobeSize: (degree + 1) ** 2,
    sorted,
    weighting: {
      index: WEIGHTINGS.indexOf(weighting.name),
      exponentMax: weighting.exponent_max,
      sigma: weighting.sigma,
      backgroundWeight: weighting.background_weight,
      alphaMin: weighting.alpha_min,
    },
    footprint,
    background: /** @type {[number, number, number]} */ (Array.from(background)),
  };
}

/**
 * Decode and pack Gaussians.
 *
 * @param {GaussianDecoder} decoder
 * @param {QuantizedRows} rows
 * @param {PackedRows} [packed] the output
 * @returns {PackedRows}
 */
export function packRows(decoder, rows, packed = emptyRows(strideOf(decoder), rows.positions.length / 3)) {
  const count = rows.positions.length / 3;
  const stride = strideOf(decoder);
  const size = 4 * BLOCK;
  let pack;
  for (let from = 0; from < count; from += BLOCK) {
    const block = decoder.decode(rows, from);
    pack ??= packer(block); // it is the same block every time
    const words = pack();
    packed.shapes.set(words.subarray(0, 4 * block.count), 4 * from);
    packed.colors.set(words.subarray(size, size + 4 * block.count), 4 * from);
    packed.lobes.set(words.subarray(2 * size, 2 * size + stride * block.count), stride * from);
  }
  return packed;
}

/** @param {number} stride words per Gaussian for its lobes @param {number} count @returns {PackedRows} */
const emptyRows = (stride, count) => ({
  shapes: new Uint32Array(4 * count),
  colors: new Uint32Array(4 * count),
  lobes: new Uint32Array(stride * count),
});

/** The bits of the smallest float of a range and the span of the bits, as floats. @param {[number, number]} range */
function bitsOf(range) {
  const [least, largest] = range.map((value) => ((FLOAT[0] = value), fround(BITS[0])));
  return [least, largest - least];
}

/** Words per Gaussian for its lobes. @param {number} degree */
const lobeStride = (degree) => ((degree + 1) ** 2 + 2) >> 1;

/** Words per Gaussian for its lobes, or for the inputs of the network. @param {{network: boolean, lobeDegree: number}} decoder */
const strideOf = ({ network, lobeDegree }) => (network ? INPUT_WORDS : lobeStride(lobeDegree));

/**
 * Return a function that packs the current content of a block: shapes, then colours, then lobes.
 *
 * @param {Gaussians} block
 * @param {boolean} [plain] without WebAssembly
 * @returns {() => Words}
 */
export function packer(block, plain = false) {
  const { scales, quats, sh, lobes, lobeDegree, statics, scaleRange, memory } = block;
  const { buffer, byteOffset, length } = block.words;
  const words = new Uint32Array(/** @type {ArrayBuffer} */ (buffer), byteOffset, length);
  const [least, span] = bitsOf(scaleRange);
  const grow = span > 0 ? fround(1 / span) : 0;
  const kernels = plain ? null : kernelsIn(memory);
  const [at0, at1, at2, at3] = [scales, quats, sh, lobes].map(({ byteOffset }) => byteOffset);
  const network = statics.length > 0;
  const [pairs, stride] = [(lobeDegree + 1) ** 2 - 1, strideOf({ network, lobeDegree })];
  return () => {
    if (kernels) kernels.pack(at0, at1, at2, at3, byteOffset, pairs, stride, least, grow);
    else packReference(block, words, stride, least, grow);
    if (network) packInputs(statics, words);
    const { count, positions } = block;
    for (let i = 0, at = 0; i < count; i++, at += 4) {
      words[at] = positions[3 * i] | (positions[3 * i + 1] << 16);
      words[at + 1] |= positions[3 * i + 2];
    }
    return words;
  };
}

/**
 * The reference in JavaScript: all words of a block except positions.
 *
 * @param {Gaussians} block
 * @param {Uint32Array} words
 * @param {number} stride words per Gaussian for its lobes
 * @param {number} least of scales' bits
 * @param {number} grow
 */
function packReference({ scales: sizes, quats, sh, lobes, lobeDegree }, words, stride, least, grow) {
  const size = 2 * (lobeDegree + 1) ** 2;
  for (let i = 0; i < BLOCK; i++) {
    const at = 8 * BLOCK + stride * i;
    const scales = packLobes(lobes, i, size, words, at);
    packColor(sh, i, words, 4 * (BLOCK + i));
    words[4 * i + 1] = scales << 16;
    let all = 0;
    for (let axis = 2; axis >= 0; axis--) {
      FLOAT[0] = sizes[axis * BLOCK + i];
      const share = fround(fround(fround(BITS[0]) - least) * grow);
      all = (all << 11) | fround(fround(STEPS[axis] * Math.min(Math.max(share, 0), 1)) + 0.5);
    }
    words[4 * i + 2] = all;
    const q = [0, 1, 2, 3].map((k) => quats[k * BLOCK + i]);
    words[4 * i + 3] = rotationWord(q);
    // not a rotation
    if (!q.some(Boolean)) words[at] = INVISIBLE | (words[at] & 0xffff0000);
  }
}

/**
 * Write the inputs of the view network behind the base opacity, in the place of phi.
 *
 * @param {Float32Array} statics in columns, at most 1 in size
 * @param {Uint32Array} words
 */
function packInputs(statics, words) {
  for (let i = 0; i < BLOCK; i++) {
    const at = 8 * BLOCK + INPUT_WORDS * i;
    words[at] = (words[at] & 0xffff) | (Math.round(32767 * statics[i]) << 16);
    for (let word = 1; word < INPUT_WORDS; word++) {
      const [low, high] = [2 * word - 1, 2 * word].map((k) => Math.round(32767 * statics[k * BLOCK + i]));
      words[at + word] = (low & 0xffff) | (high << 16);
    }
  }
}

/** @param {number[]} quat */
function rotationWord(quat) {
  let largest = 0;
  for (let i = 1; i < 4; i++) {
    if (Math.abs(quat[i]) > Math.abs(quat[largest])) largest = i;
  }
  // a quaternion and its negative are the same rotation
  const sign = quat[largest] < 0 ? -TURN : TURN;
  let word = largest;
  for (let i = 0; i < 4; i++) {
    if (i !== largest) word = (word << 10) | (fround(fround(sign * quat[i]) + 1024.5) & 1023);
  }
  return word;
}

/**
 * @param {Float32Array} sh
 * @param {number} i
 * @param {Uint32Array} words
 * @param {number} at
 */
function packColor(sh, i, words, at) {
  const value = (/** @type {number} */ column) => sh[column * BLOCK + i];
  const others = Array.from({ length: 9 }, (_, k) => value(3 + k));
  const scale = scaleOf(others);
  const bytes = others.map((number) => rounded(scale, number));
  words[at] = toFloat16(value(0)) | (toFloat16(value(1)) << 16);
  words[at + 1] = toFloat16(value(2)) | (scale << 16) | (bytes[0] << 24);
  for (const first of [1, 5]) words[at + 1 + ((first + 3) >> 2)] = four(bytes, first);
}

/**
 * @param {Float32Array} lobes
 * @param {number} i
 * @param {number} size columns
 * @param {Uint32Array} words
 * @param {number} at
 * @returns {number} the bytes of both scales
 */
function packLobes(lobes, i, size, words, at) {
  const value = (/** @type {number} */ column) => lobes[column * BLOCK + i];
  const others = Array.from({ length: size - 2 }, (_, k) => value(2 + k));
  const [logit, phi] = [0, 1].map((of) => scaleOf(others.filter((_, k) => k % 2 === of)));
  const bytes = others.map((number, k) => rounded(k % 2 ? phi : logit, number));
  words[at] = toFloat16(value(0)) | (toFloat16(value(1)) << 16);
  for (let k = 0, word = at + 1; k < bytes.length; k += 4, word++) words[word] = four(bytes, k);
  return logit | (phi << 8);
}

/** @param {number[]} bytes @param {number} at */
const four = (bytes, at) => bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);

/** The byte of a number, in units of scale / 127. @param {number} scale @param {number} value */
function rounded(scale, value) {
  BITS[0] = (scale + LEAST_SCALE) << 20;
  const large = fround(fround(127 / FLOAT[0]) * value);
  return fround(Math.min(Math.max(large, -127), 127) + 512.5) & 255;
}

/** The byte of the smallest scale that covers all numbers: eight per octave, from 2^-16 on. @param {number[]} numbers */
function scaleOf(numbers) {
  FLOAT[0] = Math.max(0, ...numbers.map(Math.abs));
  return Math.min(Math.max(((BITS[0] + 0xfffff) >> 20) - LEAST_SCALE, 0), 255);
}
