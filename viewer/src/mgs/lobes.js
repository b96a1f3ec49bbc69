/** Decodes lobes: opacity and weight as functions of the direction. docs/reference/format.md, section 8. */

import { lookUp } from "./codebooks.js";
import { BLOCK } from "./block_memory.js";
import { STATICS, Statics } from "./statics.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {import("./block_memory.js").Block} Block */
/** @typedef {import("./block_memory.js").BlockMemory} BlockMemory */
/** @typedef {import("./statics.js").Attributes} Attributes */
/** @typedef {import("./weights.js").Weights} Weights */

// the constant harmonic
export const C0 = 0.28209479177387814;

/** Evaluates a file's lobes, without the base opacity. */
export class LobeDecoder {
  #memory;
  #layers;
  #lobes;
  #latents;
  /** Inputs of each layer. @type {Block[]} */
  #inputs;
  /** The parts of the inputs that hold latents: at the end of the first and of the last layer's input. @type {Block[]} */
  #behind;
  /** Inputs of the hidden layers; null without any. @type {Statics | null} */
  #statics;

  /**
   * @param {BlockMemory} memory
   * @param {Attributes} attributes inputs of the hidden layers
   * @param {Block} lobes the output
   * @param {LobeShape} shape
   * @param {Weights} weights
   */
  constructor(memory, attributes, lobes, { degree, latents, hidden }, weights) {
    const outputs = 2 * (degree + 1) ** 2;
    const width = hidden.at(-1) ?? 0;
    const inputs = [STATICS + latents, ...hidden];
    this.#memory = memory;
    this.#lobes = lobes;
    this.#layers = hidden.map((_, i) => memory.layer(weights[`weights.${i}`], inputs[i], weights[`offsets.${i}`]));
    // undefined without hidden layers
    const heads = weights[`weights.${hidden.length}`];
    const matrix = joined(heads, width, weights.basis, latents, outputs);
    this.#layers.push(memory.layer(matrix, width + latents, weights.bias));
    this.#latents = memory.block(latents);
    const widths = hidden.length ? [STATICS, ...hidden] : [0];
    this.#inputs = widths.map((width) => memory.block(Math.ceil(width / 4) * 4 + latents));
    this.#behind = [0, widths.length - 1].map((i) => memory.part(this.#inputs[i], widths[i], latents));
    this.#statics = hidden.length ? new Statics(memory, attributes, this.#inputs[0]) : null;
  }

  /**
   * Decode the lobes of at most a block of Gaussians.
   *
   * @param {Codes | null} codes latents; null without any
   * @param {number} from the first of them in the codes
   * @param {number} to
   */
  decode(codes, from, to) {
    const [memory, inputs, last] = [this.#memory, this.#inputs, this.#layers.length - 1];
    this.#statics?.write();
    if (codes) lookUp(codes, this.#latents.numbers, BLOCK, from, to);
    this.#behind[0].numbers.set(this.#latents.numbers);
    for (let i = 0; i < last; i++) memory.apply(this.#layers[i], inputs[i], inputs[i + 1], 0);
    this.#behind[1].numbers.set(this.#latents.numbers);
    memory.apply(this.#layers[last], inputs[last], this.#lobes, 1);
  }
}

/**
 * Join the last layer's matrix and the basis of the latents, whose products are summed.
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
