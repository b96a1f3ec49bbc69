/** Decodes the streams of a file to codes, in tasks that run when their input has arrived. */

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
 * @property {string[]} after tasks that must be done before
 * @property {number} minBytes bytes of the file that must be received before the task may allocate its arrays
 * @property {(stream: Stream) => void} read decodes the stream of the task's name
 */

// Gaussians whose mean colour stands for colours that are not decoded yet
const SAMPLES = 256;
const FLOATS = ["raw", "halves", "planes"];
const INDICES = ["bits", "rans"];
/** Attributes by stage: each complete stage can be shown. @type {Attribute[][]} */
const STAGES = [["scale", "rotation"], ["appearance", "opacity"], ["lobes"]];
/** The stage of a complete level. */
export const COMPLETE = STAGES.length;
/** The first stage with colours. Scenes of one colour would look worse than dots. */
export const COLORED = 2;

/** Codes of the Gaussians of an LOD level. */
export class QuantizedLevel {
  /** Three float16 bit patterns per Gaussian, once decoded. @type {Uint16Array | null} */
  positions = null;
  /** Decoded columns by attribute. @type {Map<Attribute, Uint16Array[]>} */
  columns = new Map();

  #header;

  /** @param {Header} header @param {number} count Gaussians of the level */
  constructor(header, count) {
    this.#header = header;
    this.count = count;
  }

  /** The number of complete stages, from the first one on. */
  get stage() {
    const missing = STAGES.findIndex((names) => !names.every((name) => this.#has(name)));
    return missing < 0 ? COMPLETE : missing;
  }

  /**
   * The decoded codes of some Gaussians; positions must be decoded.
   *
   * @param {number} from
   * @param {number} to
   * @param {"slice" | "subarray"} [how] copies, or views
   * @returns {QuantizedRows}
   */
  rows(from, to, how = "slice") {
    const columns = [...this.columns]
      .filter(([name]) => this.#has(name))
      .map(([name, found]) => [name, found.map((column) => column[how](from, to))]);
    const all = /** @type {Uint16Array} */ (this.positions);
    return { positions: all[how](3 * from, 3 * to), columns: Object.fromEntries(columns) };
  }

  /** True if all columns of an attribute are decoded, or the file has none. @param {Attribute} name */
  #has(name) {
    const { cuts, scalars } = this.#header;
    const finer = scalars.size && name === "rotation" ? 3 : 0;
    const columns = (cuts.get(name)?.count ?? scalars.get(name)?.columns.length ?? 0) + finer;
    return Object.keys(this.columns.get(name) ?? []).length === columns;
  }
}

/** Decodes the streams of a file, each once. */
export class StreamDecoder {
  /** @type {QuantizedLevel[]} */
  levels;
  /** Weights of the view network, once decoded. @type {Weights | null} */
  network = null;

  #header;
  #table;
  /** Remaining tasks, the most urgent first. @type {Map<string, Task>} */
  #tasks = new Map();
  /** Received streams whose task has not run. @type {Map<string, Stream>} */
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
    let minBytes = 0;
    this.levels = lodSizes.map((count, i) => {
      minBytes += count;
      return this.#planLevel(count, i ? `@${i}` : "", decoders, minBytes);
    });
  }

  /**
   * @param {number} count Gaussians of the level
   * @param {string} end of its streams' names
   * @param {string[]} decoders tasks that come before all levels
   * @param {number} minBytes
   */
  #planLevel(count, end, decoders, minBytes) {
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
    // a false count gets no memory: each Gaussian needs a received byte
    this.#plan(positions, ["morton-class"], decoders, place, minBytes);
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

  /** Add a stream; unknown ones are ignored. @param {Stream} stream */
  accept(stream) {
    if (this.#tasks.has(stream.name)) this.#streams.set(stream.name, stream);
  }

  /**
   * Decode the most urgent stream that is available.
   *
   * @param {number} received bytes of the file
   * @returns {boolean} false: another stream is needed first
   */
  step(received) {
    for (const [name, { after, minBytes, read }] of this.#tasks) {
      const stream = this.#streams.get(name);
      if (stream === undefined || received < minBytes || after.some((other) => this.#tasks.has(other))) continue;
      read(stream);
      this.#tasks.delete(name);
      this.#streams.delete(name);
      return true;
    }
    return false;
  }

  /** The input of GaussianDecoder; positions of the first level must be decoded. @returns {DecoderInputs} */
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
   * @param {number} [minBytes]
   */
  #plan(name, codecs, after, read, minBytes = 0) {
    const row = this.#table.find((row) => row.name === name);
    if (row === undefined) throw new SceneError(`the .mgs file lacks its stream '${name}'`);
    if (!codecs.includes(row.codec)) {
      throw new SceneError(
        `the stream '${name}' of the .mgs file uses the codec '${row.codec}', which this ` +
          "program does not know",
      );
    }
    this.#tasks.set(name, { after, minBytes, read });
  }

  /** @param {string} name @param {Shape[]} shapes @param {(weights: Weights) => void} take */
  #planWeights(name, shapes, take) {
    this.#plan(name, FLOATS, [], (stream) =>
      take(splitWeights(decodeFloat16(stream, weightNumbers(shapes)), shapes)),
    );
  }
}
