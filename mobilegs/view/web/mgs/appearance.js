/** Colour from position and latents. docs/format.md, section 7. */

import { lookUp } from "./codebooks.js";
import { BLOCK, Network, makeLayer, writeColumns } from "./dense.js";
import { fromHalf } from "./half.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./weights.js").Weights} Weights */

const OCTAVES = 16;
const ENCODED = 6 * OCTAVES;
const HIDDEN = 64;
const CONTEXT = 13;
const SLOPE = 0.01;
const LATENTS = 6;
const { fround, sqrt } = Math;

/** Colours that are linear in their latents. */
export class LinearDecoder {
  #latents = new Float32Array(0);
  #rows;

  /** @param {Weights} weights */
  constructor({ static2, view2 }) {
    const row = (/** @type {number} */ first, /** @type {Float32Array} */ weights) => ({ first, weights });
    this.#rows = [
      ...split(static2, 3).map((weights) => row(0, weights)),
      ...split(view2, 9).map((weights) => row(3, weights)),
    ];
  }

  /**
   * Writes the harmonics of some Gaussians, 12 columns, into `sh`.
   *
   * @param {Uint16Array} positions only their number counts
   * @param {Codes} codes latents
   * @param {Float32Array} sh
   */
  decode(positions, codes, sh) {
    const count = positions.length / 3;
    const size = codes.length * codes.books.length * count;
    if (this.#latents.length < size) this.#latents = new Float32Array(size);
    const latents = this.#latents;
    lookUp(codes, latents, 1, count);
    for (const [row, { first, weights }] of this.#rows.entries()) {
      const [x, y, z] = [first, first + 1, first + 2].map((i) => latents.subarray(i * count, (i + 1) * count));
      const [a, b, c, ...more] = weights;
      const out = sh.subarray(row * count, (row + 1) * count);
      for (let i = 0; i < count; i++) out[i] = a * x[i] + b * y[i] + c * z[i];
      for (const [k, d] of more.entries()) {
        const from = (first + 3 + k) * count;
        for (let i = 0; i < count; i++) out[i] += d * latents[from + i];
      }
    }
  }
}

/** So many rows. @param {Float32Array} matrix @param {number} rows */
function split(matrix, rows) {
  const columns = matrix.length / rows;
  return Array.from({ length: rows }, (_, i) => matrix.subarray(i * columns, (i + 1) * columns));
}

/** Evaluates the networks of a file's colours, 9792 products per Gaussian. */
export class AppearanceDecoder {
  #network;
  #latents = new Float32Array(BLOCK * LATENTS);
  #unit;

  /**
   * @param {Weights} weights
   * @param {number} exponent of positions
   */
  constructor({ context1, context2, static1, static2, view1, view2 }, exponent) {
    const layers = [
      makeLayer(context1, ENCODED),
      makeLayer(context2, HIDDEN),
      makeLayer(static1, CONTEXT + 3),
      makeLayer(static2, HIDDEN),
      makeLayer(view1, CONTEXT + 3),
      makeLayer(view2, HIDDEN),
    ];
    this.#unit = 2 ** exponent;
    // the third block holds the context, behind it the static or the view latents
    const widths = [ENCODED, HIDDEN, CONTEXT + 3, 4, 12];
    this.#network = new Network(layers, widths);
  }

  /**
   * Writes the harmonics of some Gaussians, 12 columns, into `sh`.
   *
   * @param {Uint16Array} positions the bits of the halves
   * @param {Codes} codes latents
   * @param {Float32Array} sh
   */
  decode(positions, codes, sh) {
    const network = this.#network;
    const [context1, context2, static1, static2, view1, view2] = network.layers;
    const [encoded, hidden, inputs, degree0, degree1] = network.blocks;
    const latents = this.#latents;
    const count = positions.length / 3;
    for (let start = 0; start < count; start += BLOCK) {
      const rows = Math.min(BLOCK, count - start);
      this.#encode(positions, start, rows, encoded);
      network.apply(context1, encoded, hidden, 0);
      network.apply(context2, hidden, inputs, 1);
      lookUp(codes, latents, 1, BLOCK, start, start + rows);
      inputs.set(latents.subarray(0, 3 * BLOCK), CONTEXT * BLOCK);
      network.apply(static1, inputs, hidden, SLOPE);
      network.apply(static2, hidden, degree0, 1);
      inputs.set(latents.subarray(3 * BLOCK), CONTEXT * BLOCK);
      network.apply(view1, inputs, hidden, SLOPE);
      network.apply(view2, hidden, degree1, 1);
      writeColumns(degree0, 3, rows, sh, start, count);
      writeColumns(degree1, 9, rows, sh, 3 * count + start, count);
    }
  }

  /** From the centre, but at least 1, in units of the radius. @param {Uint16Array} positions @param {number} place */
  #distance(positions, place) {
    const x = fromHalf(positions[place]) * this.#unit;
    const y = fromHalf(positions[place + 1]) * this.#unit;
    const z = fromHalf(positions[place + 2]) * this.#unit;
    const square = fround(fround(fround(x * x) + fround(y * y)) + fround(z * z));
    return Math.max(1, fround(sqrt(square)));
  }

  /**
   * Sines and cosines of the contracted positions: 16 octaves per axis, sines first.
   *
   * @param {Uint16Array} positions
   * @param {number} start
   * @param {number} rows
   * @param {Float32Array} encoded
   */
  #encode(positions, start, rows, encoded) {
    for (let row = 0; row < rows; row++) {
      const place = 3 * (start + row);
      const length = this.#distance(positions, place);
      const grow = fround(2 - fround(1 / length));
      for (let axis = 0; axis < 3; axis++) {
        const value = fromHalf(positions[place + axis]) * this.#unit;
        const bent = fround(grow * fround(value / length));
        writeOctaves(bent, encoded, axis * OCTAVES * BLOCK + row);
      }
    }
  }
}

/**
 * Sines of an axis from `at` on, and its cosines behind the sines of all.
 *
 * From one octave to the next an angle doubles, which takes two products instead of a sine and
 * a cosine; in float64 the last octave is still right to 1e-11.
 *
 * @param {number} bent a coordinate, contracted
 * @param {Float32Array} encoded
 * @param {number} at
 */
function writeOctaves(bent, encoded, at) {
  // every rounding matters: the last octave multiplies by 2^15
  const unit = fround(fround(bent * 0.25) + 0.5);
  let sine = Math.sin(Math.PI * unit);
  let cosine = Math.cos(Math.PI * unit);
  for (const end = at + OCTAVES * BLOCK; at < end; at += BLOCK) {
    encoded[at] = sine;
    encoded[at + (ENCODED / 2) * BLOCK] = cosine;
    const double = 2 * sine * cosine;
    cosine = 1 - 2 * sine * sine;
    sine = double;
  }
}
