/** Layers of networks for a block of Gaussians: where opening a file spends its time. */

import { simdIn } from "./simd.js";

/** Gaussians in a block: what the widest layer reads and writes then stays in a 32 KiB cache. */
export const BLOCK = 32;

/**
 * @typedef {object} Layer `outputs = matrix * inputs + offsets`
 * @property {number} inputs
 * @property {number} outputs a multiple of 4; rows that were added are 0
 * @property {Float32Array} weights of four outputs together, input by input
 * @property {Float32Array} offsets
 */
/** @typedef {Float32Array} Block values of `BLOCK` Gaussians: first those of one input, then the next */

/**
 * @param {Float32Array} matrix row by row
 * @param {number} inputs columns of the matrix
 * @param {Float32Array} [offsets] none: zeros
 * @returns {Layer}
 */
export function makeLayer(matrix, inputs, offsets) {
  const rows = offsets ? offsets.length : matrix.length / inputs;
  const outputs = Math.ceil(rows / 4) * 4;
  const layer = {
    inputs,
    outputs,
    weights: new Float32Array(outputs * inputs),
    offsets: new Float32Array(outputs),
  };
  for (let row = 0; row < rows; row++) {
    const place = (row - (row % 4)) * inputs + (row % 4);
    for (let i = 0; i < inputs; i++) layer.weights[place + 4 * i] = matrix[row * inputs + i];
  }
  if (offsets) layer.offsets.set(offsets);
  return layer;
}

/**
 * What a layer does, then `x` where that is above 0, else `slope * x`.
 *
 * @param {Layer} layer
 * @param {Block} input
 * @param {Block} output
 * @param {number} slope 1: nothing is done to it
 */
export function defined({ inputs, outputs, weights, offsets }, input, output, slope) {
  for (let o = 0; o < outputs; o++) {
    const first = (o - (o % 4)) * inputs + (o % 4);
    for (let row = 0; row < BLOCK; row++) {
      let sum = offsets[o];
      for (let i = 0; i < inputs; i++) sum += weights[first + 4 * i] * input[i * BLOCK + row];
      output[o * BLOCK + row] = Math.max(sum, slope * sum);
    }
  }
}

/**
 * Writes the first rows of a block into columns.
 *
 * @param {Block} block
 * @param {number} columns
 * @param {number} rows
 * @param {Float32Array} out
 * @param {number} at the first place
 * @param {number} apart from one column to the next
 */
export function writeColumns(block, columns, rows, out, at, apart) {
  for (let i = 0; i < columns; i++, at += apart) out.set(block.subarray(i * BLOCK, i * BLOCK + rows), at);
}

/** Layers and blocks in the memory that SIMD works on, where there is SIMD. */
export class Network {
  /** @type {Layer[]} */
  layers;
  /** @type {Block[]} */
  blocks;
  #simd;

  /**
   * @param {Layer[]} layers
   * @param {number[]} widths values per Gaussian of each block that is needed
   * @param {boolean} [plain] without SIMD
   */
  constructor(layers, widths, plain = false) {
    const sizes = layers.flatMap(({ weights, offsets }) => [weights.length, offsets.length]);
    const blocks = widths.map((width) => BLOCK * width);
    const total = [...sizes, ...blocks].reduce((a, b) => a + b, 0);
    // pages of 64 KiB
    const memory = new WebAssembly.Memory({ initial: Math.ceil(total / 2 ** 14) });
    let start = 0;
    const take = (/** @type {number} */ length) => {
      const taken = new Float32Array(memory.buffer, 4 * start, length);
      start += length;
      return taken;
    };
    const moved = (/** @type {Float32Array} */ numbers) => {
      const place = take(numbers.length);
      place.set(numbers);
      return place;
    };
    this.layers = layers.map((layer) => ({
      ...layer,
      weights: moved(layer.weights),
      offsets: moved(layer.offsets),
    }));
    this.blocks = blocks.map(take);
    this.#simd = plain ? null : simdIn(BLOCK, memory);
  }

  /**
   * Applies a layer to a block, as `defined` does.
   *
   * @param {Layer} layer one of its own
   * @param {Block} input
   * @param {Block} output
   * @param {number} slope
   */
  apply(layer, input, output, slope) {
    const { weights: w, offsets: b, inputs, outputs } = layer;
    if (this.#simd === null || inputs === 0) {
      // without inputs, nothing but offsets
      defined(layer, input, output, slope);
      return;
    }
    const { byteOffset: y } = output;
    this.#simd(w.byteOffset, b.byteOffset, input.byteOffset, y, inputs, outputs, slope);
  }
}
