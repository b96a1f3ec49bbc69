/** Lobes, which tell opacity and weight by direction. docs/format.md, section 8. */

import { lookUp } from "./codebooks.js";
import { BLOCK } from "./block_memory.js";
import { STATICS } from "./weights.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").LobeShape} LobeShape */
/** @typedef {import("./block_memory.js").Block} Block */
/** @typedef {import("./block_memory.js").BlockMemory} BlockMemory */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Attributes what hidden layers look at
 * @property {Block} sh 12 columns
 * @property {Block} scales standard deviations, 3 columns
 * @property {Block} quats 4 columns, of length 1, or 0
 */

// the constant harmonic
export const C0 = 0.28209479177387814;

/** Evaluates a file's lobes, without the base opacity. */
export class LobeDecoder {
  #memory;
  #layers;
  #lobes;
  #latents;
  /** What goes into each layer. @type {Block[]} */
  #inputs;
  /** Where latents go: behind everything that goes into the first layer, and the last one. @type {Block[]} */
  #behind;
  /** What of the attributes is divided by its length. @type {[Block, Block][]} */
  #lengths;
  #quats;

  /**
   * @param {BlockMemory} memory
   * @param {Attributes} attributes
   * @param {Block} lobes what it writes
   * @param {LobeShape} shape
   * @param {Weights} weights
   */
  constructor(memory, { sh, scales, quats }, lobes, { degree, latents, hidden }, weights) {
    const outputs = 2 * (degree + 1) ** 2;
    const width = hidden.at(-1) ?? 0;
    const inputs = [STATICS + latents, ...hidden];
    this.#memory = memory;
    this.#lobes = lobes;
    this.#layers = hidden.map((_, i) => memory.layer(weights[`weights.${i}`], inputs[i], weights[`offsets.${i}`]));
    // missing if nothing is hidden
    const heads = weights[`weights.${hidden.length}`];
    const matrix = joined(heads, width, weights.basis, latents, outputs);
    this.#layers.push(memory.layer(matrix, width + latents, weights.bias));
    this.#latents = memory.block(latents);
    const widths = hidden.length ? [STATICS, ...hidden] : [0];
    this.#inputs = widths.map((width) => memory.block(Math.ceil(width / 4) * 4 + latents));
    this.#behind = [0, widths.length - 1].map((i) => memory.part(this.#inputs[i], widths[i], latents));
    const statics = hidden.length ? this.#inputs[0] : memory.block(STATICS);
    this.#lengths = [[sh, memory.part(statics, 0, 12)], [scales, memory.part(statics, 12, 3)]];
    this.#quats = [quats, memory.part(statics, 15, 4)];
  }

  /**
   * Writes the lobes of some Gaussians, at most a block.
   *
   * @param {Codes | null} codes latents, if there are any
   * @param {number} from the first of them in the codes
   * @param {number} to
   */
  decode(codes, from, to) {
    const [memory, inputs, last] = [this.#memory, this.#inputs, this.#layers.length - 1];
    const [quats, copied] = this.#quats;
    if (last > 0) {
      for (const [attribute, unit] of this.#lengths) memory.units(attribute, unit);
      copied.numbers.set(quats.numbers);
    }
    if (codes) lookUp(codes, this.#latents.numbers, BLOCK, from, to);
    this.#behind[0].numbers.set(this.#latents.numbers);
    for (let i = 0; i < last; i++) memory.apply(this.#layers[i], inputs[i], inputs[i + 1], 0);
    this.#behind[1].numbers.set(this.#latents.numbers);
    memory.apply(this.#layers[last], inputs[last], this.#lobes, 1);
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
