/** Codes of some Gaussians to what is drawn, as far as the codes have come. */

import { AppearanceDecoder, LinearDecoder } from "./appearance.js";
import { lookUp, meanCodes } from "./codebooks.js";
import { C0, LobeDecoder } from "./lobes.js";
import { turn } from "./rotations.js";
import { fillColumns, fillRows, makeGaussians, normaliseQuats } from "./scene.js";

/** @typedef {import("./codebooks.js").Books} Books */
/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./scene.js").Gaussians} Gaussians */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Recipe what decoding takes; a message to another thread can hold it
 * @property {Header} header
 * @property {Map<Attribute, Books>} books
 * @property {Weights} appearance
 * @property {Weights} lobes nothing if the header says so
 * @property {Uint16Array} samples positions of Gaussians whose mean colour is the neutral one
 */
/**
 * @typedef {object} Rows what a file holds of some Gaussians
 * @property {Uint16Array} positions 3 halves each
 * @property {Partial<Record<Attribute, Uint16Array[]>>} columns of attributes that have come, the
 *     entry in each book
 */

// in their logarithms: some three times
const SMALLER = 1.1;
const PARTS = /** @type {const} */ (["logScales", "scales", "quats", "sh", "lobes"]);

export class RowDecoder {
  #recipe;
  #colors;
  #lobeDecoder;
  /** Colour and lobes, without the base opacity, as long as there are no others. */
  #neutral;
  /** What was decoded last. @type {Gaussians} */
  #room;

  /** @param {Recipe} recipe */
  constructor(recipe) {
    const { header, samples } = recipe;
    const { lobes, frame } = header;
    this.#recipe = recipe;
    this.#lobeDecoder = lobes && new LobeDecoder(lobes, recipe.lobes);
    this.#room = makeGaussians(new Uint16Array(0), lobes?.degree ?? 0, rangeOf(this.#of("scale")));
    const many = samples.length / 3;
    const found = new Float32Array(12 * many);
    this.#colors = header.colors === "linear"
      ? new LinearDecoder(recipe.appearance)
      : new AppearanceDecoder(recipe.appearance, frame.exponent);
    this.#colors.decode(samples, meanCodes(this.#of("appearance"), many), found);
    this.#neutral = makeGaussians(samples.subarray(0, 3), this.#room.lobeDegree, [0, 0]);
    const { sh, scales, quats, lobes: constant } = this.#neutral;
    for (let i = 0; i < 3 * many; i++) sh[Math.floor(i / many)] += found[i] / many;
    lookUp(exponentials(smallCodes(this.#of("scale"), 1)), scales, 3);
    quats[0] = 1;
    if (this.#lobeDecoder) {
      const latents = recipe.books.get("lobes");
      this.#lobeDecoder.decode(this.#neutral, latents ? meanCodes(latents, 1) : null, constant);
    } else constant[1] = 1 / C0;
  }

  /**
   * Gaussians, in memory that the next call takes again.
   *
   * @param {Rows} rows
   * @returns {Gaussians}
   */
  decode({ positions, columns }) {
    const { header } = this.#recipe;
    const gaussians = this.#roomFor(positions);
    const { count, logScales, scales, quats, sh, lobes } = gaussians;
    /** @type {(name: Attribute) => Codes | null} */
    const codes = (name) => {
      const found = columns[name];
      return found ? { ...this.#of(name), columns: found } : null;
    };
    const scale = codes("scale") ?? smallCodes(this.#of("scale"), count);
    lookUp(scale, logScales, 3);
    lookUp(exponentials(scale), scales, 3);
    const rotation = codes("rotation");
    const scalar = header.scalars.get("rotation");
    if (rotation && scalar) turn(scalar, rotation.columns, logScales, quats);
    else if (rotation) {
      lookUp(rotation, quats, 4);
      normaliseQuats(quats);
    } else fillRows(quats, this.#neutral.quats);
    const appearance = codes("appearance");
    if (appearance) this.#colors.decode(positions, appearance, sh);
    else fillColumns(sh, this.#neutral.sh);
    // hidden layers look at everything else
    const names = [...header.cuts.keys(), ...header.scalars.keys()];
    const all = names.every((name) => columns[name]);
    if (all && this.#lobeDecoder) this.#lobeDecoder.decode(gaussians, codes("lobes"), lobes);
    else fillColumns(lobes, this.#neutral.lobes);
    if (names.includes("opacity")) {
      addBase(codes("opacity") ?? meanCodes(this.#of("opacity"), count), lobes);
    }
    return gaussians;
  }

  /** @param {Uint16Array} positions @returns {Gaussians} */
  #roomFor(positions) {
    const count = positions.length / 3;
    if (this.#room.count < count) {
      this.#room = makeGaussians(positions, this.#room.lobeDegree, this.#room.logScaleRange);
    }
    const room = { ...this.#room, count, positions };
    for (const part of PARTS) {
      room[part] = room[part].subarray(0, (room[part].length / this.#room.count) * count);
    }
    return room;
  }

  /** @param {Attribute} name */
  #of(name) {
    return /** @type {Books} */ (this.#recipe.books.get(name));
  }
}

/**
 * Log-scales of Gaussians whose own have not come: dots, which are quick to draw, and between which
 * one sees how deep a place is.
 *
 * @param {Books} all
 * @param {number} count
 * @returns {Codes}
 */
function smallCodes(all, count) {
  const { books, ...codes } = meanCodes(all, count);
  return { ...codes, books: books.map((book) => book.map((value) => value - SMALLER)) };
}

/** Standard deviations in the place of their logarithms. @param {Codes} codes @returns {Codes} */
function exponentials({ books, ...codes }) {
  return { ...codes, books: books.map((book) => book.map(Math.exp)) };
}

/**
 * Adds the base opacity's logit to the constant part of the opacity's lobe.
 *
 * @param {Codes} codes
 * @param {Float32Array} lobes
 */
function addBase({ books: [book], columns: [column] }, lobes) {
  for (let i = 0; i < column.length; i++) lobes[i] += book[column[i]] / C0;
}

/** The least and the largest number. @param {Books} books @returns {[number, number]} */
function rangeOf({ books }) {
  let range = /** @type {[number, number]} */ ([Infinity, -Infinity]);
  for (const book of books) {
    for (const value of book) range = [Math.min(range[0], value), Math.max(range[1], value)];
  }
  return range;
}
