/** Lobes, which tell opacity and weight by direction. docs/format.md, section 8. */

import { lookUp } from "./codebooks.js";
import { BLOCK, applyLayer, makeBlock, makeLayer, rectify } from "./dense.js";
import { STATICS } from "./weights.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Attributes what hidden layers look at
 * @property {Float32Array} sh
 * @property {Float32Array} logScales
 * @property {Float32Array} quats of length 1, or 0
 */

export const C0 = 0.28209479177387814; // the constant harmonic
const LENGTH_MIN = 1e-12;

/** Evaluates a file's lobes, without the base opacity. */
export class LobeDecoder {
  #outputs;
  #layers;
  #blocks;
  #width;
  #last;
  #result;

  /**
   * @param {LobeShape} shape
   * @param {Weights} weights
   */
  constructor({ degree, latents, hidden }, weights) {
    this.#outputs = 2 * (degree + 1) ** 2;
    const inputs = [STATICS + latents, ...hidden];
    this.#layers = hidden.map((_, i) =>
      makeLayer(weights[`weights.${i}`], inputs[i], weights[`offsets.${i}`]),
    );
    const strides = [STATICS, ...hidden].map((width) => Math.ceil(width / 4) * 4 + latents);
    this.#blocks = strides.map(makeBlock); // what goes into each layer
    this.#width = hidden.at(-1) ?? 0;
    const heads = weights[`weights.${hidden.length}`]; // missing if nothing is hidden
    const matrix = joined(heads, this.#width, weights.basis, latents, this.#outputs);
    this.#last = makeLayer(matrix, this.#width + latents, weights.bias);
    this.#result = makeBlock(this.#last.outputs);
  }

  /**
   * Writes the lobes of Gaussians `from` to `to` into `lobes`.
   *
   * @param {Attributes} attributes
   * @param {Codes | null} codes latents, if there are any
   * @param {number} from
   * @param {number} to
   * @param {Float32Array} lobes
   */
  decode(attributes, codes, from, to, lobes) {
    for (let start = from; start < to; start += BLOCK) {
      const rows = Math.min(BLOCK, to - start);
      const block = this.#hide(attributes, codes, start, rows);
      if (codes) lookUp(codes, start, start + rows, block.values, this.#width, block.stride);
      applyLayer(this.#last, block, this.#result, rows);
      const { values, stride } = this.#result;
      for (let row = 0; row < rows; row++) {
        const place = (start + row) * this.#outputs;
        for (let i = 0; i < this.#outputs; i++) lobes[place + i] = values[row * stride + i];
      }
    }
  }

  /**
   * What the hidden layers make of a block of Gaussians, with room for the latents behind it.
   *
   * @param {Attributes} attributes
   * @param {Codes | null} codes
   * @param {number} start
   * @param {number} rows
   */
  #hide(attributes, codes, start, rows) {
    let block = this.#blocks[0];
    if (this.#layers.length === 0) return block;
    for (let row = 0; row < rows; row++) {
      writeStatics(attributes, start + row, block.values, row * block.stride);
    }
    if (codes) lookUp(codes, start, start + rows, block.values, STATICS, block.stride);
    this.#layers.forEach((layer, i) => {
      const next = this.#blocks[i + 1];
      applyLayer(layer, block, next, rows);
      rectify(next, layer.outputs, 0);
      block = next;
    });
    return block;
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
 * @param {Float64Array} out
 * @param {number} start
 */
function writeStatics({ sh, logScales, quats }, row, out, start) {
  for (let i = 0; i < 12; i++) out[start + i] = sh[12 * row + i];
  for (let i = 0; i < 3; i++) out[start + 12 + i] = Math.exp(logScales[3 * row + i]);
  shorten(out, start, 12);
  shorten(out, start + 12, 3);
  for (let i = 0; i < 4; i++) out[start + 15 + i] = quats[4 * row + i];
}

/**
 * @param {Float64Array} values
 * @param {number} start
 * @param {number} count
 */
function shorten(values, start, count) {
  let square = 0;
  for (let i = start; i < start + count; i++) square += values[i] * values[i];
  const length = Math.max(Math.sqrt(square), LENGTH_MIN);
  for (let i = start; i < start + count; i++) values[i] /= length;
}
