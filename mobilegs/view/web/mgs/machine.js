/**
 * Blocks of Gaussians, and what is done to all of a block: where opening a file spends its time.
 *
 * Numbers lie in columns, in memory that SIMD works on where there is SIMD.
 */

import { memoryOf } from "./assembler.js";
import { simdIn } from "./simd.js";

/** Gaussians in a block: what our own files need of it then stays in the second cache, and calls cost nothing. */
export const BLOCK = 128;

/** What no length is below, where something is divided by it. */
export const LENGTH_MIN = 1e-12;

/** @typedef {{at: number, width: number, numbers: Float32Array}} Block columns, from a place in bytes on */
/**
 * @typedef {object} Layer `outputs = matrix * inputs + offsets`
 * @property {number} inputs
 * @property {number} outputs a multiple of 4; rows that were added are 0
 * @property {Block} weights of four outputs together, input by input
 * @property {Block} offsets
 */

const NOTHING = new Float32Array(0);

/** Places are given out first; numbers have theirs when all have been, which `settle` says. */
export class Machine {
  /** Where all blocks lie; null where there is no WebAssembly. @type {WebAssembly.Memory | null} */
  memory = null;
  /** @type {[Block, Float32Array | null, number][]} with what is to be in it, and its length */
  #given = [];
  #bytes = 0;
  #simd = /** @type {import("./simd.js").Simd | null} */ (null);
  #plain;

  /** @param {boolean} [plain] without SIMD */
  constructor(plain = false) {
    this.#plain = plain;
  }

  /** Room for columns. @param {number} width */
  block(width) {
    return this.#give(width, BLOCK * width, null);
  }

  /** Some of the columns of a block. @param {Block} block @param {number} from @param {number} width */
  part({ at }, from, width) {
    const part = { at: at + 4 * BLOCK * from, width, numbers: NOTHING };
    this.#given.push([part, null, BLOCK * width]);
    return part;
  }

  /**
   * @param {Float32Array} matrix row by row
   * @param {number} inputs columns of the matrix
   * @param {Float32Array} [offsets] none: zeros
   * @returns {Layer}
   */
  layer(matrix, inputs, offsets) {
    const rows = offsets ? offsets.length : matrix.length / inputs;
    const outputs = Math.ceil(rows / 4) * 4;
    const weights = new Float32Array(outputs * inputs);
    for (let row = 0; row < rows; row++) {
      const place = (row - (row % 4)) * inputs + (row % 4);
      for (let i = 0; i < inputs; i++) weights[place + 4 * i] = matrix[row * inputs + i];
    }
    const all = new Float32Array(outputs);
    if (offsets) all.set(offsets);
    const put = (/** @type {Float32Array} */ numbers) => this.#give(0, numbers.length, numbers);
    return { inputs, outputs, weights: put(weights), offsets: put(all) };
  }

  /** @param {number} width @param {number} length @param {Float32Array | null} numbers */
  #give(width, length, numbers) {
    const block = { at: this.#bytes, width, numbers: NOTHING };
    this.#given.push([block, numbers, length]);
    this.#bytes += 16 * Math.ceil(length / 4);
    return block;
  }

  /** Gives all blocks their numbers. */
  settle() {
    this.memory = memoryOf(this.#bytes);
    const buffer = this.memory?.buffer ?? new ArrayBuffer(this.#bytes);
    for (const [block, numbers, length] of this.#given.splice(0)) {
      block.numbers = new Float32Array(buffer, block.at, length);
      if (numbers) block.numbers.set(numbers);
    }
    this.#simd = this.#plain || !this.memory ? null : simdIn(BLOCK, LENGTH_MIN, this.memory);
  }

  /**
   * What a layer does, then `x` where that is above 0, else `slope * x`.
   *
   * @param {Layer} layer
   * @param {Block} input
   * @param {Block} output with room for all outputs
   * @param {number} slope 1: nothing is done to it
   */
  apply({ inputs, outputs, weights, offsets }, input, output, slope) {
    if (this.#simd && inputs > 0) {
      this.#simd.layer(weights.at, offsets.at, input.at, output.at, inputs, outputs, slope);
      return;
    }
    const [x, y, w, b] = [input, output, weights, offsets].map(({ numbers }) => numbers);
    for (let o = 0; o < outputs; o++) {
      const first = (o - (o % 4)) * inputs + (o % 4);
      for (let row = 0; row < BLOCK; row++) {
        let sum = b[o];
        for (let i = 0; i < inputs; i++) sum += w[first + 4 * i] * x[i * BLOCK + row];
        y[o * BLOCK + row] = Math.max(sum, slope * sum);
      }
    }
  }

  /**
   * Divides what each Gaussian has by its length; what has none stays 0.
   *
   * @param {Block} input
   * @param {Block} output of the same width
   */
  units({ at, width, numbers: x }, { at: to, numbers: y }) {
    if (this.#simd) {
      this.#simd.units(at, to, width);
      return;
    }
    for (let row = 0; row < BLOCK; row++) {
      let square = 0;
      for (let k = row; k < BLOCK * width; k += BLOCK) square += x[k] * x[k];
      const grow = 1 / Math.max(Math.sqrt(square), LENGTH_MIN);
      for (let k = row; k < BLOCK * width; k += BLOCK) y[k] = x[k] * grow;
    }
  }
}
