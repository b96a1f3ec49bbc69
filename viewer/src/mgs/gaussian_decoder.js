/** Decodes codes to blocks of Gaussians, with neutral values for attributes that have not arrived. */

import { AppearanceDecoder, LatentDecoder, LinearDecoder, SH_COLUMNS } from "./appearance.js";
import { lookUp, meanCodes } from "./codebooks.js";
import { C0, LobeDecoder } from "./lobes.js";
import { BLOCK, BlockMemory } from "./block_memory.js";
import { decodeQuaternions } from "./rotations.js";
import { STATICS, Statics } from "./statics.js";
import { fill } from "./gaussian_block.js";

/** @typedef {import("./codebooks.js").Books} Books */
/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./gaussian_block.js").Gaussians} Gaussians */
/** @typedef {import("./weights.js").Weights} Weights */
/** @typedef {Record<"scale" | "rotation", Uint16Array[]> & Partial<Record<Attribute, Uint16Array[]>>} Columns */
/**
 * @typedef {object} DecoderInputs the shared data that decoding needs; can be sent to workers
 * @property {Header} header
 * @property {Map<Attribute, Books>} books
 * @property {Weights} appearance
 * @property {Weights} lobes empty if the scene has none
 * @property {Uint16Array} samples positions of the Gaussians whose mean colour is the neutral colour
 */
/**
 * @typedef {object} QuantizedRows the codes of some Gaussians
 * @property {Uint16Array} positions 3 float16 bit patterns each
 * @property {Columns} columns of attributes that have come, scales and rotations at least, the
 *     entry in each book
 */

const DOT_WIDTH = 1 / 3; // of a dot, in standard deviations
const IDENTITY = [1, 0, 0, 0];

export class GaussianDecoder {
  #decoderInputs;
  #memory = new BlockMemory();
  #quats;
  #colors;
  #lobeDecoder;
  /** Inputs of the view network; null if the file has none. @type {Statics | null} */
  #statics;
  /** The output block. @type {Gaussians} */
  #gaussians;
  /** Colour and lobes, without the base opacity, until their streams arrive. */
  #neutral;
  /** Codes by attribute, with the columns of the current rows. @type {Partial<Record<Attribute, Codes>>} */
  #codes;
  /** Codes of the standard deviations. */
  #scales;
  /** Mean standard deviations. */
  #meanScales;

  /** @param {DecoderInputs} decoderInputs */
  constructor(decoderInputs) {
    const { header, samples } = decoderInputs;
    const { lobes: shape, grid } = header;
    const memory = this.#memory;
    this.#decoderInputs = decoderInputs;
    const degree = shape?.degree ?? 0;
    const sh = memory.block(SH_COLUMNS);
    const blocks = {
      logScales: memory.block(3),
      scales: memory.block(3),
      quats: memory.block(4),
      sh: memory.part(sh, 0, 12),
      // the last network layer writes four columns at a time
      lobes: memory.block(2 * (degree + 1) ** 2 + 2),
      statics: memory.block(header.network ? STATICS : 0),
      words: memory.block(18),
    };
    this.#quats = blocks.quats;
    this.#lobeDecoder = shape && new LobeDecoder(memory, blocks, blocks.lobes, shape, decoderInputs.lobes);
    this.#statics = header.network ? new Statics(memory, blocks, blocks.statics) : null;
    const { appearance } = decoderInputs;
    if (header.colors === "linear") this.#colors = new LinearDecoder(memory, sh, appearance);
    else if (header.colors === "latent_networks") this.#colors = new LatentDecoder(memory, sh, appearance);
    else this.#colors = new AppearanceDecoder(memory, sh, appearance, grid.exponent);
    memory.allocate();
    this.#codes = Object.fromEntries([...decoderInputs.books].map(([name, books]) => [name, { ...books, columns: [] }]));
    this.#scales = exponentials(this.#codesOf("scale"));
    this.#meanScales = exponentials(meanCodes(this.#codesOf("scale")));
    const columns = Object.fromEntries(Object.entries(blocks).map(([name, { numbers }]) => [name, numbers]));
    const scaleRange = rangeOf(this.#scales);
    this.#gaussians = /** @type {any} */ ({ ...columns, count: 0, lobeDegree: degree, scaleRange, memory: memory.wasmMemory });
    this.#neutral = { sh: this.#meanColor(samples), lobes: [0, 1 / C0] };
    if (this.#lobeDecoder) this.#neutral.lobes = this.#meanLobes(this.#lobeDecoder);
  }

  /** The mean colour of some Gaussians. @param {Uint16Array} samples */
  #meanColor(samples) {
    const { sh } = this.#gaussians;
    const mean = new Float64Array(12);
    const codes = meanCodes(this.#codesOf("appearance"));
    for (let at = 0; at < samples.length; at += 3 * BLOCK) {
      const some = samples.subarray(at, at + 3 * BLOCK);
      this.#colors.decode(some, codes, 0);
      for (let i = 0; i < 12; i++) {
        for (let row = 0; 3 * row < some.length; row++) mean[i] += (3 * sh[i * BLOCK + row]) / samples.length;
      }
    }
    return mean;
  }

  /** The lobes of a Gaussian with mean attributes. @param {LobeDecoder} decoder */
  #meanLobes(decoder) {
    const { scales, quats, sh, lobes } = this.#gaussians;
    const latents = this.#codes.lobes;
    lookUp(this.#meanScales, scales, BLOCK, 0, BLOCK);
    fill(quats, IDENTITY);
    fill(sh, this.#neutral.sh);
    decoder.decode(latents ? meanCodes(latents) : null, 0, BLOCK);
    return Array.from({ length: lobes.length / BLOCK - 2 }, (_, i) => lobes[i * BLOCK]);
  }

  /**
   * Decode a block of Gaussians. The next call overwrites the result.
   *
   * @param {QuantizedRows} rows
   * @param {number} [from] the first of them
   * @returns {Gaussians}
   */
  decode({ positions: means, columns }, from = 0) {
    const { header } = this.#decoderInputs;
    const positions = means.subarray(3 * from, 3 * (from + BLOCK));
    const count = positions.length / 3;
    const to = from + count;
    const [gaussians, codes] = [this.#gaussians, this.#codes];
    gaussians.count = count;
    gaussians.positions = positions;
    const { logScales, scales, quats, sh, lobes } = gaussians;
    const { scale, rotation, appearance } = columns;
    let all = true;
    for (const name of /** @type {Attribute[]} */ (Object.keys(codes))) {
      const found = columns[name];
      if (found) this.#codesOf(name).columns = found;
      else all = false;
    }
    this.#scales.columns = scale;
    lookUp(this.#codesOf("scale"), logScales, BLOCK, from, to);
    lookUp(this.#scales, scales, BLOCK, from, to);
    const scalar = header.scalars.get("rotation");
    if (scalar) decodeQuaternions(scalar, rotation, from, to, quats);
    else {
      lookUp(this.#codesOf("rotation"), quats, BLOCK, from, to);
      this.#memory.units(this.#quats, this.#quats);
    }
    if (appearance) this.#colors.decode(positions, this.#codesOf("appearance"), from);
    else fill(sh, this.#neutral.sh);
    // hidden layers take all other attributes as input
    if (this.#lobeDecoder && all) this.#lobeDecoder.decode(codes.lobes ?? null, from, to);
    else fill(lobes, this.#neutral.lobes);
    if (codes.opacity) {
      const { books: [book] } = columns.opacity ? codes.opacity : meanCodes(codes.opacity);
      const column = columns.opacity?.[0];
      addOpacities(lobes, book, column, from, count);
    }
    this.#statics?.write();
    return gaussians;
  }

  /** True if the file has a view network. */
  get network() {
    return this.#statics !== null;
  }

  get lobeDegree() {
    return this.#gaussians.lobeDegree;
  }

  get scaleRange() {
    return this.#gaussians.scaleRange;
  }

  /** Colour and side of the dots that stand for Gaussians. */
  get neutral() {
    const color = /** @type {[number, number, number]} */ ([0, 1, 2].map((i) => 0.5 + C0 * this.#neutral.sh[i]));
    const [a, b, c] = this.#meanScales.books.map(([size]) => size);
    return { color, side: DOT_WIDTH * Math.cbrt(a * b * c) };
  }

  /** @param {Attribute} name */
  #codesOf(name) {
    return /** @type {Codes} */ (this.#codes[name]);
  }
}

/**
 * Add base opacities to the constant coefficients of the opacity lobes.
 *
 * @param {Float32Array} lobes
 * @param {Float32Array} book
 * @param {Uint16Array | undefined} column undefined: the first entry for all
 * @param {number} from
 * @param {number} count
 */
function addOpacities(lobes, book, column, from, count) {
  for (let i = 0; i < count; i++) lobes[i] += book[column ? column[from + i] : 0] / C0;
}

/** Codes whose books hold the exponentials. @template {Books} T @param {T} codes @returns {T} */
function exponentials(codes) {
  return { ...codes, books: codes.books.map((book) => book.map(Math.exp)) };
}

/** Minimum and maximum. @param {Books} books @returns {[number, number]} */
function rangeOf({ books }) {
  let range = /** @type {[number, number]} */ ([Infinity, -Infinity]);
  for (const book of books) {
    for (const value of book) range = [Math.min(range[0], value), Math.max(range[1], value)];
  }
  return range;
}
