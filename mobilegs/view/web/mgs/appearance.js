/** Colour from position and latents. docs/format.md, section 7. */

import { lookUp } from "./codebooks.js";
import { BLOCK, applyLayer, makeBlock, makeLayer, rectify } from "./dense.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./weights.js").Weights} Weights */

const OCTAVES = 16;
const ENCODED = 6 * OCTAVES;
const HIDDEN = 64;
const CONTEXT = 13;
const SLOPE = 0.01;
const LATENTS = 6;
const { fround, sqrt } = Math;

/** Evaluates the networks of a file's colours, 9792 products per Gaussian. */
export class AppearanceDecoder {
  #context1;
  #context2;
  #static1;
  #static2;
  #view1;
  #view2;
  #encoded = makeBlock(ENCODED);
  #hidden = makeBlock(HIDDEN);
  #inputs = makeBlock(CONTEXT + 3); // context, then static or view latents
  #degree0 = makeBlock(4);
  #degree1 = makeBlock(12);
  #latents = new Float64Array(BLOCK * LATENTS);

  /** @param {Weights} weights */
  constructor(weights) {
    this.#context1 = makeLayer(weights.context1, ENCODED);
    this.#context2 = makeLayer(weights.context2, HIDDEN);
    this.#static1 = makeLayer(weights.static1, CONTEXT + 3);
    this.#static2 = makeLayer(weights.static2, HIDDEN);
    this.#view1 = makeLayer(weights.view1, CONTEXT + 3);
    this.#view2 = makeLayer(weights.view2, HIDDEN);
  }

  /**
   * Writes the harmonics of Gaussians `from` to `to`, 12 numbers each, into `sh`.
   *
   * @param {Float32Array} places normalised positions
   * @param {Codes} codes latents
   * @param {number} from
   * @param {number} to
   * @param {Float32Array} sh
   */
  decode(places, codes, from, to, sh) {
    for (let start = from; start < to; start += BLOCK) {
      const rows = Math.min(BLOCK, to - start);
      encode(places, start, rows, this.#encoded.values);
      applyLayer(this.#context1, this.#encoded, this.#hidden, rows);
      rectify(this.#hidden, HIDDEN, 0);
      applyLayer(this.#context2, this.#hidden, this.#inputs, rows);
      lookUp(codes, start, start + rows, this.#latents, 0, LATENTS);
      this.#insertLatents(0);
      applyLayer(this.#static1, this.#inputs, this.#hidden, rows);
      rectify(this.#hidden, HIDDEN, SLOPE);
      applyLayer(this.#static2, this.#hidden, this.#degree0, rows);
      this.#insertLatents(3);
      applyLayer(this.#view1, this.#inputs, this.#hidden, rows);
      rectify(this.#hidden, HIDDEN, SLOPE);
      applyLayer(this.#view2, this.#hidden, this.#degree1, rows);
      for (let row = 0; row < rows; row++) {
        const place = 12 * (start + row);
        for (let i = 0; i < 3; i++) sh[place + i] = this.#degree0.values[4 * row + i];
        for (let i = 0; i < 9; i++) sh[place + 3 + i] = this.#degree1.values[12 * row + i];
      }
    }
  }

  /** Puts three of the latents behind the context. @param {number} first */
  #insertLatents(first) {
    const { values, stride } = this.#inputs;
    for (let row = 0; row < BLOCK; row++) {
      for (let i = 0; i < 3; i++) {
        values[row * stride + CONTEXT + i] = this.#latents[row * LATENTS + first + i];
      }
    }
  }
}

/**
 * Sines and cosines of the contracted positions: 16 octaves per axis, sines first.
 *
 * From one octave to the next an angle doubles, which takes two products instead of a sine and
 * a cosine; in float64 the last octave is still right to 1e-11.
 *
 * @param {Float32Array} places
 * @param {number} start
 * @param {number} rows
 * @param {Float64Array} encoded
 */
function encode(places, start, rows, encoded) {
  for (let row = 0; row < rows; row++) {
    const place = 3 * (start + row);
    const x = places[place];
    const y = places[place + 1];
    const z = places[place + 2];
    const square = fround(fround(fround(x * x) + fround(y * y)) + fround(z * z));
    const length = Math.max(1, fround(sqrt(square)));
    const grow = fround(2 - fround(1 / length));
    for (let axis = 0; axis < 3; axis++) {
      // every rounding matters: the last octave multiplies by 2^15
      const bent = fround(grow * fround(places[place + axis] / length));
      const unit = fround(fround(bent * 0.25) + 0.5);
      let sine = Math.sin(Math.PI * unit);
      let cosine = Math.cos(Math.PI * unit);
      let at = row * ENCODED + axis * OCTAVES;
      for (const end = at + OCTAVES; at < end; at++) {
        encoded[at] = sine;
        encoded[at + ENCODED / 2] = cosine;
        const double = 2 * sine * cosine;
        cosine = 1 - 2 * sine * sine;
        sine = double;
      }
    }
  }
}
