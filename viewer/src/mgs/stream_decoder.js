/** The streams of a file to codes, as tasks that run when what they need is there. */

import { bookNumbers, decodeIndices, scalarBooks, splitBooks } from "./codebooks.js";
import { SceneError } from "./error.js";
import { decodeFloat16 } from "./float16.js";
import { decodePositions } from "./positions.js";
import { decodeRefinements } from "./rotations.js";
import { NETWORK, colorShapes, lobeShapes, splitWeights, weightNumbers } from "./weights.js";

/** @typedef {import("./codebooks.js").Books} Books */
/** @typedef {import("./container.js").Row} Row */
/** @typedef {import("./container.js").Stream} Stream */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./gaussian_decoder.js").DecoderInputs} DecoderInputs */
/** @typedef {import("./gaussian_decoder.js").QuantizedRows} QuantizedRows */
/** @typedef {import("./weights.js").Shape} Shape */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Task
 * @property {string[]} after tasks that must be done
 * @property {number} room bytes that must have come before there may be arrays as long
 * @property {(stream: Stream) => void} read takes the stream of the task's name
 */

// Gaussians whose mean colour is the neutral one
const SAMPLES = 256;
const FLOATS = ["raw", "halves", "planes"];
const INDICES = ["bits", "rans"];
/** Attributes that are worth a picture of their own, the last of which needs all. @type {Attribute[][]} */
const STAGES = [["scale", "rotation"], ["appearance", "opacity"], ["lobes"]];
/** The stage at which there is everything. */
export const COMPLETE = STAGES.length;
/** The stage from which on colours are there: in one for all, a scene looks worse than its dots. */
export const COLORED = 2;

/** Codes of the Gaussians of a level. */
export class QuantizedLevel {
  /** Three halves for each Gaussian, once they are known. @type {Uint16Array | null} */
  positions = null;
  /** By attribute those that have come. @type {Map<Attribute, Uint16Array[]>} */
  columns = new Map();

  #header;

  /** @param {Header} header @param {number} count Gaussians of the level */
  constructor(header, count) {
    this.#header = header;
    this.count = count;
  }

  /** How many of the `STAGES` are there, one after the other. */
  get stage() {
    const missing = STAGES.findIndex((names) => !names.every((name) => this.#has(name)));
    return missing < 0 ? COMPLETE : missing;
  }

  /**
   * What has come of some Gaussians; there must be positions.
   *
   * @param {number} from
   * @param {number} to
   * @param {"slice" | "subarray"} [how] for themselves, or where they lie
   * @returns {QuantizedRows}
   */
  rows(from, to, how = "slice") {
    const columns = [...this.columns]
      .filter(([name]) => this.#has(name))
      .map(([name, found]) => [name, found.map((column) => column[how](from, to))]);
    const all = /** @type {Uint16Array} */ (this.positions);
    return { positions: all[how](3 * from, 3 * to), columns: Object.fromEntries(columns) };
  }

  /** Whether all of an attribute is there, or there is none. @param {Attribute} name */
  #has(name) {
    const { cuts, scalars } = this.#header;
    const finer = scalars.size && name === "rotation" ? 3 : 0;
    const columns = (cuts.get(name)?.count ?? scalars.get(name)?.columns.length ?? 0) + finer;
    return Object.keys(this.columns.get(name) ?? []).length === columns;
  }
}

/** Decodes each stream once. */
export class StreamDecoder {
  /** @type {QuantizedLevel[]} */
  levels;
  /** Weights of the view network, if there is one and it has come. @type {Weights | null} */
  network = null;

  #header;
  #table;
  /** What is left to do, the most urgent first. @type {Map<string, Task>} */
  #tasks = new Map();
  /** Streams that wait for their task. @type {Map<string, Stream>} */
  #streams = new Map();
  /** @type {Map<Attribute, Books>} */
  #books = new Map();
  /** @type {Weights} */
  #lobes = {};
  /** @type {Weights} */
  #appearance = {};

  /**
   * @param {Header} header
   * @param {Row[]} table
   */
  constructor(header, table) {
    this.#header = header;
    this.#table = table;
    const { network, lobes, cuts, scalars, lodSizes } = header;
    if (network) this.#planWeights("view-network", NETWORK, (found) => (this.network = found));
    if (lobes) {
      this.#planWeights("lobe-decoder", lobeShapes(lobes), (found) => (this.#lobes = found));
    }
    this.#planWeights(...colorShapes(header), (found) => (this.#appearance = found));
    if (scalars.size) this.#books = scalarBooks(scalars);
    else {
      this.#plan("codebooks", FLOATS, [], (stream) => {
        this.#books = splitBooks(decodeFloat16(stream, bookNumbers(cuts)), cuts);
      });
    }
    const decoders = [...this.#tasks.keys()];
    let room = 0;
    this.levels = lodSizes.map((count, i) => {
      room += count;
      return this.#planLevel(count, i ? `@${i}` : "", decoders, room);
    });
  }

  /**
   * @param {number} count Gaussians of the level
   * @param {string} end of its streams' names
   * @param {string[]} decoders tasks that come before all levels
   * @param {number} room
   */
  #planLevel(count, end, decoders, room) {
    const { cuts, scalars } = this.#header;
    const level = new QuantizedLevel(this.#header, count);
    const [positions, ...scales] = ["positions", "scale.0", "scale.1", "scale.2"].map((name) => name + end);
    /** @type {(name: Attribute, sizes: number[]) => void} */
    const planIndices = (name, sizes) => {
      /** @type {Uint16Array[]} */
      const columns = [];
      level.columns.set(name, columns);
      for (const [i, size] of sizes.entries()) {
        this.#plan(`${name}.${i}${end}`, INDICES, [positions], (stream) => {
          columns[i] = decodeIndices(stream, count, size);
        });
      }
    };
    /** @type {(stream: Stream) => void} */
    const place = ({ data }) => {
      level.positions = decodePositions(data, count);
    };
    // a claim alone gets no memory: a Gaussian takes a byte that has arrived, if not its own
    this.#plan(positions, ["morton-class"], decoders, place, room);
    for (const [name, { count: books, size }] of cuts) planIndices(name, Array(books).fill(size));
    for (const [name, { columns }] of scalars) planIndices(name, columns.map(({ size }) => size));
    if (scalars.size) {
      const [of, turns] = ["scale", "rotation"].map((name) => level.columns.get(/** @type {Attribute} */ (name)) ?? []);
      this.#plan(`rotation-finer${end}`, ["bits"], [positions, ...scales], ({ data }) => {
        const { books } = /** @type {Books} */ (this.#books.get("scale"));
        decodeRefinements(data, books, of).forEach((column, axis) => (turns[3 + axis] = column));
      });
    }
    return level;
  }

  /** Takes in a stream; those that are not known are let go. @param {Stream} stream */
  accept(stream) {
    if (this.#tasks.has(stream.name)) this.#streams.set(stream.name, stream);
  }

  /**
   * Decodes the most urgent of the streams that are there.
   *
   * @param {number} received bytes of the file
   * @returns {boolean} false: there is nothing to do before another stream comes
   */
  step(received) {
    for (const [name, { after, room, read }] of this.#tasks) {
      const stream = this.#streams.get(name);
      if (stream === undefined || received < room || after.some((other) => this.#tasks.has(other))) continue;
      read(stream);
      this.#tasks.delete(name);
      this.#streams.delete(name);
      return true;
    }
    return false;
  }

  /** What decoding rows takes; there must be positions of the first level. @returns {DecoderInputs} */
  get decoderInputs() {
    const [{ count, positions }] = this.levels;
    const all = /** @type {Uint16Array} */ (positions);
    const many = Math.min(count, SAMPLES);
    const samples = new Uint16Array(3 * many).map(
      (_, i) => all[3 * Math.floor((Math.floor(i / 3) * count) / many) + (i % 3)],
    );
    const [header, books] = [this.#header, this.#books];
    return { header, books, appearance: this.#appearance, lobes: this.#lobes, samples };
  }

  /**
   * @param {string} name
   * @param {string[]} codecs
   * @param {string[]} after
   * @param {(stream: Stream) => void} read
   * @param {number} [room]
   */
  #plan(name, codecs, after, read, room = 0) {
    const row = this.#table.find((row) => row.name === name);
    if (row === undefined) throw new SceneError(`the .mgs file lacks its stream '${name}'`);
    if (!codecs.includes(row.codec)) {
      throw new SceneError(
        `the stream '${name}' of the .mgs file uses the codec '${row.codec}', which this ` +
          "program does not know",
      );
    }
    this.#tasks.set(name, { after, room, read });
  }

  /** @param {string} name @param {Shape[]} shapes @param {(weights: Weights) => void} take */
  #planWeights(name, shapes, take) {
    this.#plan(name, FLOATS, [], (stream) =>
      take(splitWeights(decodeFloat16(stream, weightNumbers(shapes)), shapes)),
    );
  }
}
