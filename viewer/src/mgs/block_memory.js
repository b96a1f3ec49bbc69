/**
 * Memory for blocks of Gaussians, and the dense layers and normalisation that work on all of a block: most of the
 * time to open a file goes there.
 *
 * Numbers lie in columns. The methods define what the kernels of viewer/wasm do, and run where there is no WebAssembly.
 */

import { kernelsIn, newMemory } from "./wasm.js";

/** Gaussians in a block: its numbers stay in the second-level cache, and the cost of calls is negligible. */
export const BLOCK = 128;

/** The least length that something is divided by. */
export const LENGTH_MIN = 1e-12;

/** @typedef {{at: number, width: number, numbers: Float32Array}} Block columns, from an offset in bytes on */
/**
 * @typedef {object} Layer `outputs = matrix * inputs + offsets`
 * @property {number} inputs
 * @property {number} outputs a multiple of 4; rows that were added are 0
 * @property {Block} weights four outputs together, input by input
 * @property {Block} offsets
 */

const NOTHING = new Float32Array(0);

/** Blocks are reserved first; `allocate` then gives all of them their numbers. */
export class BlockMemory {
  /** The memory of all blocks; null where there is no WebAssembly. @type {WebAssembly.Memory | null} */
  wasmMemory = null;
  /** Blocks, the numbers that they begin with, and their lengths. @type {[Block, Float32Array | null, number][]} */
  #reserved = [];
  #bytes = 0;
  #kernels = /** @type {import("./wasm.js").Kernels | null} */ (null);
  #plain;

  /** @param {boolean} [plain] without WebAssembly */
  constructor(plain = false) {
    this.#plain = plain;
  }

  /** Reserves columns. @param {number} width */
  block(width) {
    return this.#reserve(width, BLOCK * width, null);
  }

  /** Some of the columns of a block. @param {Block} block @param {number} from @param {number} width */
  part({ at }, from, width) {
    const part = { at: at + 4 * BLOCK * from, width, numbers: NOTHING };
    this.#reserved.push([part, null, BLOCK * width]);
    return part;
  }

  /**
   * @param {Float32Array} matrix row by row
   * @param {number} inputs columns of the matrix
   * @param {Float32Array} [offsets] zeros by default
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
    const put = (/** @type {Float32Array} */ numbers) => this.#reserve(0, numbers.length, numbers);
    return { inputs, outputs, weights: put(weights), offsets: put(all) };
  }

  /** @param {number} width @param {number} length @param {Float32Array | null} numbers */
  #reserve(width, length, numbers) {
    const block = { at: this.#bytes, width, numbers: NOTHING };
    this.#reserved.push([block, numbers, length]);
    this.#bytes += 16 * Math.ceil(length / 4);
    return block;
  }

  /** Allocates the memory, and gives all blocks their numbers. */
  allocate() {
    this.wasmMemory = newMemory(this.#bytes);
    const buffer = this.wasmMemory?.buffer ?? new ArrayBuffer(this.#bytes);
    for (const [block, numbers, length] of this.#reserved.splice(0)) {
      block.numbers = new Float32Array(buffer, block.at, length);
      if (numbers) block.numbers.set(numbers);
    }
    this.#kernels = this.#plain ? null : kernelsIn(this.wasmMemory);
  }

  /**
   * Evaluates a layer and its activation: `x` where `x > 0`, else `slope * x`.
   *
   * @param {Layer} layer
   * @param {Block} input
   * @param {Block} output with columns for all outputs
   * @param {number} slope 1 for no activation
   */
  apply({ inputs, outputs, weights, offsets }, input, output, slope) {
    if (this.#kernels) {
      this.#kernels.layer(weights.at, offsets.at, input.at, output.at, inputs, outputs, slope);
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
   * Divides the numbers of each Gaussian by their length; zeros stay zeros.
   *
   * @param {Block} input
   * @param {Block} output of the same width; may be the input
   */
  units({ at, width, numbers: x }, { at: to, numbers: y }) {
    if (this.#kernels) {
      this.#kernels.units(at, to, width);
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
