/** Inputs of networks that come from a Gaussian's other attributes. docs/reference/format.md, section 8. */

/** @typedef {import("./block_memory.js").Block} Block */
/** @typedef {import("./block_memory.js").BlockMemory} BlockMemory */
/**
 * @typedef {object} Attributes
 * @property {Block} sh 12 columns
 * @property {Block} scales standard deviations, 3 columns
 * @property {Block} quats 4 columns, of length 1, or 0
 */

/** Columns of the inputs: harmonics, scales and rotation. */
export const STATICS = 19;

/** Writes harmonics, scales and rotation, each of length 1. */
export class Statics {
  #memory;
  /** Attributes to normalise, and the outputs. @type {[Block, Block][]} */
  #lengths;
  /** @type {[Block, Block]} */
  #quats;

  /**
   * @param {BlockMemory} memory
   * @param {Attributes} attributes
   * @param {Block} output its first columns
   */
  constructor(memory, { sh, scales, quats }, output) {
    this.#memory = memory;
    this.#lengths = [[sh, memory.part(output, 0, 12)], [scales, memory.part(output, 12, 3)]];
    this.#quats = [quats, memory.part(output, 15, 4)];
  }

  /** Write the inputs of the present block. */
  write() {
    const [quats, copied] = this.#quats;
    for (const [attribute, unit] of this.#lengths) this.#memory.units(attribute, unit);
    copied.numbers.set(quats.numbers);
  }
}
