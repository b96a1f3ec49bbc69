/** Lobes, which tell opacity and weight by direction. docs/format.md, section 8. */

import { lookUp } from "./codebooks.js";
import { BLOCK, Network, makeLayer } from "./dense.js";
import { STATICS } from "./weights.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Attributes what hidden layers look at
 * @property {Float32Array} sh
 * @property {Float32Array} scales standard deviations
 * @property {Float32Array} quats of length 1, or 0
 */

// the constant harmonic
export const C0 = 0.28209479177387814;
const LENGTH_MIN = 1e-12;

/** Evaluates a file's lobes, without the base opacity. */
export class LobeDecoder {
  #outputs;
  #network;
  #width;
  #latents;

  /**
   * @param {LobeShape} shape
   * @param {Weights} weights
   */
  constructor({ degree, latents, hidden }, weights) {
    this.#outputs = 2 * (degree + 1) ** 2;
    this.#width = hidden.at(-1) ?? 0;
    this.#latents = new Float32Array(latents * BLOCK);
    const inputs = [STATICS + latents, ...hidden];
    const layers = hidden.map((_, i) =>
      makeLayer(weights[`weights.${i}`], inputs[i], weights[`offsets.${i}`]),
    );
    // missing if nothing is hidden
    const heads = weights[`weights.${hidden.length}`];
    const matrix = joined(heads, this.#width, weights.basis, latents, this.#outputs);
    layers.push(makeLayer(matrix, this.#width + latents, weights.bias));
    // what goes into each layer, latents behind it, and what comes out of the last one
    const widths = [STATICS, ...hidden].map((width) => Math.ceil(width / 4) * 4 + latents);
    this.#network = new Network(layers, [...widths, Math.ceil(this.#outputs / 4) * 4]);
  }

  /**
   * Writes the lobes of some Gaussians into `lobes`, which has room for nothing more.
   *
   * @param {Attributes} attributes
   * @param {Codes | null} codes latents, if there are any
   * @param {Float32Array} lobes
   */
  decode(attributes, codes, lobes) {
    const network = this.#network;
    const last = network.layers[network.layers.length - 1];
    const result = network.blocks[network.blocks.length - 1];
    const outputs = this.#outputs;
    const count = lobes.length / outputs;
    for (let start = 0; start < count; start += BLOCK) {
      const rows = Math.min(BLOCK, count - start);
      if (codes) lookUp(codes, this.#latents, 1, BLOCK, start, start + rows);
      const block = this.#hide(attributes, start, rows);
      block.set(this.#latents, this.#width * BLOCK);
      network.apply(last, block, result, 1);
      for (let row = 0, at = start * outputs; row < rows; row++) {
        for (let i = row; i < outputs * BLOCK; i += BLOCK) lobes[at++] = result[i];
      }
    }
  }

  /**
   * What the hidden layers make of a block of Gaussians, with room for the latents behind it.
   *
   * @param {Attributes} attributes
   * @param {number} start
   * @param {number} rows
   */
  #hide(attributes, start, rows) {
    const { layers, blocks } = this.#network;
    if (layers.length === 1) return blocks[0];
    for (let row = 0; row < rows; row++) writeStatics(attributes, start + row, blocks[0], row);
    blocks[0].set(this.#latents, STATICS * BLOCK);
    for (let i = 0; i + 1 < layers.length; i++) {
      this.#network.apply(layers[i], blocks[i], blocks[i + 1], 0);
    }
    return blocks[layers.length - 1];
  }
}

/**
 * The last layer's matrix and the latents' directions side by side: both are added up.
 *
 * @param {Float32Array} heads row by row
 * @param {number} width
 * @param {Float32Array} basis column by column
 * @param {number} latents
 * @param {number} rows
 */
function joined(heads, width, basis, latents, rows) {
  const columns = width + latents;
  const matrix = new Float32Array(rows * columns);
  for (let row = 0; row < rows; row++) {
    for (let i = 0; i < width; i++) matrix[row * columns + i] = heads[row * width + i];
    for (let i = 0; i < latents; i++) matrix[row * columns + width + i] = basis[i * rows + row];
  }
  return matrix;
}

/**
 * Harmonics, standard deviations and rotation of a Gaussian, each divided by its length.
 *
 * @param {Attributes} attributes
 * @param {number} row
 * @param {Float32Array} out
 * @param {number} start
 */
function writeStatics({ sh, scales, quats }, row, out, start) {
  writeShortened(sh, 12 * row, 12, out, start);
  writeShortened(scales, 3 * row, 3, out, start + 12 * BLOCK);
  for (let i = 0; i < 4; i++) out[start + (15 + i) * BLOCK] = quats[4 * row + i];
}

/**
 * @param {Float32Array} numbers
 * @param {number} from
 * @param {number} count
 * @param {Float32Array} out
 * @param {number} start
 */
function writeShortened(numbers, from, count, out, start) {
  let square = 0;
  for (let i = from; i < from + count; i++) square += numbers[i] * numbers[i];
  const grow = 1 / Math.max(Math.sqrt(square), LENGTH_MIN);
  for (let i = 0, at = start; i < count; i++, at += BLOCK) out[at] = numbers[from + i] * grow;
}
