/** Colour from position and latents. docs/format.md, section 7. */

import { lookUp } from "./codebooks.js";
import { BLOCK, Network, makeLayer } from "./dense.js";

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
  #network;
  #latents = new Float32Array(BLOCK * LATENTS);

  /** @param {Weights} weights */
  constructor({ context1, context2, static1, static2, view1, view2 }) {
    const layers = [
      makeLayer(context1, ENCODED),
      makeLayer(context2, HIDDEN),
      makeLayer(static1, CONTEXT + 3),
      makeLayer(static2, HIDDEN),
      makeLayer(view1, CONTEXT + 3),
      makeLayer(view2, HIDDEN),
    ];
    // the third block holds the context, behind it the static or the view latents
    this.#network = new Network(layers, [ENCODED, HIDDEN, CONTEXT + 3, 4, 12]);
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
    const network = this.#network;
    const [context1, context2, static1, static2, view1, view2] = network.layers;
    const [encoded, hidden, inputs, degree0, degree1] = network.blocks;
    const latents = this.#latents;
    for (let start = from; start < to; start += BLOCK) {
      const rows = Math.min(BLOCK, to - start);
      encode(places, start, rows, encoded);
      network.apply(context1, encoded, hidden, 0);
      network.apply(context2, hidden, inputs, 1);
      lookUp(codes, start, start + rows, latents, 0, 1, BLOCK);
      inputs.set(latents.subarray(0, 3 * BLOCK), CONTEXT * BLOCK);
      network.apply(static1, inputs, hidden, SLOPE);
      network.apply(static2, hidden, degree0, 1);
      inputs.set(latents.subarray(3 * BLOCK), CONTEXT * BLOCK);
      network.apply(view1, inputs, hidden, SLOPE);
      network.apply(view2, hidden, degree1, 1);
      for (let row = 0; row < rows; row++) {
        const place = 12 * (start + row);
        for (let i = 0; i < 3; i++) sh[place + i] = degree0[i * BLOCK + row];
        for (let i = 0; i < 9; i++) sh[place + 3 + i] = degree1[i * BLOCK + row];
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
 * @param {Float32Array} encoded
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
      let at = axis * OCTAVES * BLOCK + row;
      for (const end = at + OCTAVES * BLOCK; at < end; at += BLOCK) {
        encoded[at] = sine;
        encoded[at + (ENCODED / 2) * BLOCK] = cosine;
        const double = 2 * sine * cosine;
        cosine = 1 - 2 * sine * sine;
        sine = double;
      }
    }
  }
}
