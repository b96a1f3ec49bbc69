/** The weights of the paper's network in the order of network.wgsl. */

/** @typedef {import("../mgs/weights.js").Weights} Weights */

/** Gaussians of a work group, as in network.wgsl. */
export const GAUSSIANS = 32;
/** Inputs of a Gaussian that do not depend on the view, in words. */
export const INPUT_WORDS = 10;
const MATRICES = 2497;

/**
 * Return matrices that take four inputs to four outputs: 16 numbers each, the inputs of an output together.
 *
 * The 64-wide layer has no activation, so the two heads and it are one layer. Same order: `network_matrices` in
 * mobilegs/view/wgpu_renderer.py.
 *
 * @param {Weights} weights by the names of the file
 * @returns {Float32Array<ArrayBuffer>}
 */
export function networkMatrices(weights) {
  const [first, second, third] = [1, 2, 3].map((i) => weights[`hidden${i}.weight`]);
  const heads = ["opacity", "phi"].map((name) => ({
    weights: columnsTimes(weights[`${name}.weight`], third, 128),
    offset: weights[`${name}.weight`].reduce(
      (sum, weight, i) => sum + weight * weights["hidden3.bias"][i],
      weights[`${name}.bias`][0],
    ),
  }));
  const found = new Float32Array(16 * MATRICES);
  let at = 0;
  /** @type {(output: number, input: number, value: (output: number, input: number) => number) => void} */
  const put = (output, input, value) => {
    for (let o = output; o < output + 4; o++) {
      for (let i = input; i < input + 4; i++) found[at++] = value(o, i);
    }
  };
  for (let output = 0; output < 256; output += 4) {
    for (let input = 0; input < 24; input += 4) {
      // the offset is the weight of an input that is 1
      put(output, input, (o, i) => (i < 22 ? first[22 * o + i] : i === 22 ? weights["hidden1.bias"][o] : 0));
    }
  }
  for (let output = 0; output < 128; output += 4) {
    put(output, 0, (o, i) => (i === 0 ? weights["hidden2.bias"][o] : 0));
  }
  for (let input = 0; input < 256; input += 4) {
    for (let output = 0; output < 128; output += 4) put(output, input, (o, i) => second[256 * o + i]);
  }
  for (let input = 0; input < 128; input += 4) put(0, input, (o, i) => heads[o]?.weights[i] ?? 0);
  put(0, 0, (o, i) => (i === 0 ? (heads[o]?.offset ?? 0) : 0));
  return found;
}

/**
 * The product of a row with a matrix.
 *
 * @param {Float32Array} row
 * @param {Float32Array} matrix row by row
 * @param {number} columns
 */
function columnsTimes(row, matrix, columns) {
  return Array.from({ length: columns }, (_, column) =>
    row.reduce((sum, weight, i) => sum + weight * matrix[columns * i + column], 0),
  );
}
