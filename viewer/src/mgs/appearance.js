/** Decodes colours from positions and latents. docs/reference/format.md, section 7. */

import { lookUp } from "./codebooks.js";
import { fromFloat16 } from "./float16.js";
import { BLOCK } from "./block_memory.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./block_memory.js").Block} Block */
/** @typedef {import("./block_memory.js").BlockMemory} BlockMemory */
/** @typedef {import("./weights.js").Weights} Weights */

const OCTAVES = 16;
const ENCODED = 6 * OCTAVES;
const HIDDEN = 64;
const CONTEXT = 13;
const SLOPE = 0.01;
const LATENTS = 6;
/** Columns of the harmonics' block: networks write some that are not needed. */
export const SH_COLUMNS = 15;
const { fround, sqrt } = Math;

/** Decodes colours that are linear in their latents; the first three latents are static. */
export class LinearDecoder {
  #memory;
  #latents;
  #layer;
  #sh;

  /** @param {BlockMemory} memory @param {Block} sh the output: 12 columns of harmonics @param {Weights} weights */
  constructor(memory, sh, { static2, view2 }) {
    const latents = 3 + view2.length / 9;
    const matrix = new Float32Array(12 * latents);
    for (let row = 0; row < 12; row++) {
      const own = row < 3 ? static2.subarray(3 * row, 3 * row + 3) : view2.subarray((row - 3) * (latents - 3));
      matrix.set(own.subarray(0, latents - 3), row * latents + (row < 3 ? 0 : 3));
    }
    this.#memory = memory;
    this.#latents = memory.block(latents);
    this.#layer = memory.layer(matrix, latents);
    this.#sh = sh;
  }

  /**
   * Decode the harmonics of at most a block of Gaussians.
   *
   * @param {Uint16Array} positions only their count is used
   * @param {Codes} codes latents
   * @param {number} from the first of them in the codes
   */
  decode(positions, codes, from) {
    lookUp(codes, this.#latents.numbers, BLOCK, from, from + positions.length / 3);
    this.#memory.apply(this.#layer, this.#latents, this.#sh, 1);
  }
}

/** Evaluates two networks of all latents: 1536 products per Gaussian. */
export class LatentDecoder {
  #memory;
  #layers;
  #latents;
  #hidden;
  #halves;
  #sh;
  #degree1;

  /** @param {BlockMemory} memory @param {Block} sh the output @param {Weights} weights */
  constructor(memory, sh, { both1, static2, view2 }) {
    this.#memory = memory;
    this.#layers = [memory.layer(both1, LATENTS), memory.layer(static2, HIDDEN), memory.layer(view2, HIDDEN)];
    this.#latents = memory.block(LATENTS);
    this.#hidden = memory.block(2 * HIDDEN);
    this.#halves = [memory.part(this.#hidden, 0, HIDDEN), memory.part(this.#hidden, HIDDEN, HIDDEN)];
    this.#sh = sh;
    this.#degree1 = memory.part(sh, 3, 12);
  }

  /**
   * Decode the harmonics of at most a block of Gaussians.
   *
   * @param {Uint16Array} positions only their count is used
   * @param {Codes} codes latents
   * @param {number} from the first of them in the codes
   */
  decode(positions, codes, from) {
    const memory = this.#memory;
    const [both1, static2, view2] = this.#layers;
    lookUp(codes, this.#latents.numbers, BLOCK, from, from + positions.length / 3);
    memory.apply(both1, this.#latents, this.#hidden, SLOPE);
    memory.apply(static2, this.#halves[0], this.#sh, 1);
    memory.apply(view2, this.#halves[1], this.#degree1, 1);
  }
}

/** Evaluates the networks of position and latents: 9792 products per Gaussian. */
export class AppearanceDecoder {
  #memory;
  #layers;
  #latents;
  #encoded;
  #hidden;
  #inputs;
  #own;
  #sh;
  #degree1;
  #unit;

  /**
   * @param {BlockMemory} memory
   * @param {Block} sh the output
   * @param {Weights} weights
   * @param {number} exponent of positions
   */
  constructor(memory, sh, { context1, context2, static1, static2, view1, view2 }, exponent) {
    this.#memory = memory;
    this.#layers = [
      memory.layer(context1, ENCODED),
      memory.layer(context2, HIDDEN),
      memory.layer(static1, CONTEXT + 3),
      memory.layer(static2, HIDDEN),
      memory.layer(view1, CONTEXT + 3),
      memory.layer(view2, HIDDEN),
    ];
    this.#unit = 2 ** exponent;
    this.#latents = memory.block(LATENTS);
    this.#encoded = memory.block(ENCODED);
    this.#hidden = memory.block(HIDDEN);
    // the context, followed by the static or the view latents
    this.#inputs = memory.block(CONTEXT + 3);
    this.#own = memory.part(this.#inputs, CONTEXT, 3);
    this.#sh = sh;
    this.#degree1 = memory.part(sh, 3, 12);
  }

  /**
   * Decode the harmonics of at most a block of Gaussians.
   *
   * @param {Uint16Array} positions float16 bit patterns
   * @param {Codes} codes latents
   * @param {number} from the first of them in the codes
   */
  decode(positions, codes, from) {
    const memory = this.#memory;
    const [context1, context2, static1, static2, view1, view2] = this.#layers;
    const [latents, own] = [this.#latents.numbers, this.#own.numbers];
    const [encoded, hidden, inputs] = [this.#encoded, this.#hidden, this.#inputs];
    this.#encode(positions, encoded.numbers);
    memory.apply(context1, encoded, hidden, 0);
    memory.apply(context2, hidden, inputs, 1);
    lookUp(codes, latents, BLOCK, from, from + positions.length / 3);
    own.set(latents.subarray(0, 3 * BLOCK));
    memory.apply(static1, inputs, hidden, SLOPE);
    memory.apply(static2, hidden, this.#sh, 1);
    own.set(latents.subarray(3 * BLOCK));
    memory.apply(view1, inputs, hidden, SLOPE);
    memory.apply(view2, hidden, this.#degree1, 1);
  }

  /** Distance from the centre in units of the radius, at least 1. @param {Uint16Array} positions @param {number} place */
  #distance(positions, place) {
    const x = fromFloat16(positions[place]) * this.#unit;
    const y = fromFloat16(positions[place + 1]) * this.#unit;
    const z = fromFloat16(positions[place + 2]) * this.#unit;
    const square = fround(fround(fround(x * x) + fround(y * y)) + fround(z * z));
    return Math.max(1, fround(sqrt(square)));
  }

  /**
   * Sines and cosines of the contracted positions: 16 octaves per axis, sines first.
   *
   * @param {Uint16Array} positions
   * @param {Float32Array} encoded
   */
  #encode(positions, encoded) {
    for (let row = 0, place = 0; place < positions.length; row++, place += 3) {
      const length = this.#distance(positions, place);
      const grow = fround(2 - fround(1 / length));
      for (let axis = 0; axis < 3; axis++) {
        const value = fromFloat16(positions[place + axis]) * this.#unit;
        const bent = fround(grow * fround(value / length));
        writeOctaves(bent, encoded, axis * OCTAVES * BLOCK + row);
      }
    }
  }
}

/**
 * Write the sines of an axis from `at` on, and its cosines after the sines of all axes.
 *
 * From one octave to the next an angle doubles, which takes two products instead of a sine and
 * a cosine; in float64 the last octave is still right to 1e-11.
 *
 * @param {number} bent a coordinate, contracted
 * @param {Float32Array} encoded
 * @param {number} at
 */
function writeOctaves(bent, encoded, at) {
  // round as the reference does: the last octave multiplies by 2^15
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
