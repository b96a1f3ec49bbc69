/** Lobes, which tell opacity and weight by direction. docs/format.md, section 8. */

import { lookUp } from "./codebooks.js";
import { BLOCK, Network, makeLayer, writeColumns } from "./dense.js";
import { STATICS } from "./weights.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Attributes what hidden layers look at
 * @property {Float32Array} sh 12 columns
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
  #squares = new Float64Array(BLOCK);

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
   * Writes the lobes of some Gaussians into the columns of `lobes`, which have room for nothing more.
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
      writeColumns(result, outputs, rows, lobes, start, count);
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
    this.#writeStatics(attributes, start, rows);
    blocks[0].set(this.#latents, STATICS * BLOCK);
    for (let i = 0; i + 1 < layers.length; i++) {
      this.#network.apply(layers[i], blocks[i], blocks[i + 1], 0);
    }
    return blocks[layers.length - 1];
  }

  /**
   * Harmonics, standard deviations and rotation of some Gaussians, each divided by its length.
   *
   * @param {Attributes} attributes
   * @param {number} start
   * @param {number} rows
   */
  #writeStatics({ sh, scales, quats }, start, rows) {
    const [[out], squares] = [this.#network.blocks, this.#squares];
    const count = sh.length / 12;
    squares.fill(0);
    for (let i = 0; i < 12; i++) {
      for (let row = 0, from = i * count + start; row < rows; row++, from++) squares[row] += sh[from] * sh[from];
    }
    for (let row = 0; row < rows; row++) squares[row] = 1 / Math.max(Math.sqrt(squares[row]), LENGTH_MIN);
    for (let i = 0; i < 12; i++) {
      const at = i * BLOCK;
      for (let row = 0, from = i * count + start; row < rows; row++, from++) out[at + row] = sh[from] * squares[row];
    }
    for (let row = 0, from = start; row < rows; row++, from++) {
      const [x, y, z] = [scales[3 * from], scales[3 * from + 1], scales[3 * from + 2]];
      const grow = 1 / Math.max(Math.sqrt(x * x + y * y + z * z), LENGTH_MIN);
      out[12 * BLOCK + row] = x * grow;
      out[13 * BLOCK + row] = y * grow;
      out[14 * BLOCK + row] = z * grow;
      for (let i = 0; i < 4; i++) out[(15 + i) * BLOCK + row] = quats[4 * from + i];
    }
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
