/** A layer of a network for a block of Gaussians: where opening a file spends its time. */

/** Gaussians in a block: inputs of the widest layer then stay in a 32 KiB cache. */
export const BLOCK = 32;

/**
 * @typedef {object} Layer `outputs = matrix * inputs + offsets`
 * @property {number} inputs
 * @property {number} outputs a multiple of 4; rows that were added are 0
 * @property {Float64Array} weights of four outputs together, input by input
 * @property {Float64Array} offsets
 */

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
    weights: new Float64Array(outputs * inputs),
    offsets: new Float64Array(outputs),
  };
  for (let row = 0; row < rows; row++) {
    const place = (row - (row % 4)) * inputs + (row % 4);
    for (let i = 0; i < inputs; i++) layer.weights[place + 4 * i] = matrix[row * inputs + i];
  }
  if (offsets) layer.offsets.set(offsets);
  return layer;
}

/** Room for the values of one block. @param {number} stride values per Gaussian */
export function makeBlock(stride) {
  return { stride, values: new Float64Array(BLOCK * stride) };
}

/** @typedef {ReturnType<typeof makeBlock>} Block */

/**
 * Applies a layer to the first `rows` Gaussians of a block, rounded up to an even number.
 *
 * Two Gaussians and four outputs at a time: each number that is loaded is used two or four
 * times. Sums are float64, which costs no more here and leaves one rounding, that of the result.
 *
 * @param {Layer} layer
 * @param {Block} input
 * @param {Block} output
 * @param {number} rows
 */
export function applyLayer({ inputs, outputs, weights, offsets }, input, output, rows) {
  const x = input.values;
  const y = output.values;
  for (let o = 0; o < outputs; o += 4) {
    const first = o * inputs;
    const last = first + 4 * inputs;
    for (let row = 0; row < rows; row += 2) {
      let p = row * input.stride;
      let q = p + input.stride;
      let a0 = offsets[o];
      let a1 = offsets[o + 1];
      let a2 = offsets[o + 2];
      let a3 = offsets[o + 3];
      let b0 = a0;
      let b1 = a1;
      let b2 = a2;
      let b3 = a3;
      for (let w = first; w < last; w += 4) {
        const u = x[p++];
        const v = x[q++];
        const w0 = weights[w];
        const w1 = weights[w + 1];
        const w2 = weights[w + 2];
        const w3 = weights[w + 3];
        a0 += w0 * u;
        a1 += w1 * u;
        a2 += w2 * u;
        a3 += w3 * u;
        b0 += w0 * v;
        b1 += w1 * v;
        b2 += w2 * v;
        b3 += w3 * v;
      }
      p = row * output.stride + o;
      q = p + output.stride;
      y[p] = a0;
      y[p + 1] = a1;
      y[p + 2] = a2;
      y[p + 3] = a3;
      y[q] = b0;
      y[q + 1] = b1;
      y[q + 2] = b2;
      y[q + 3] = b3;
    }
  }
}

/**
 * `x` where it is above 0, else `slope * x`, for the first `width` values of each Gaussian.
 *
 * @param {Block} block
 * @param {number} width
 * @param {number} slope
 */
export function rectify({ values, stride }, width, slope) {
  for (let start = 0; start < values.length; start += stride) {
    for (let i = start; i < start + width; i++) if (!(values[i] > 0)) values[i] *= slope;
  }
}
