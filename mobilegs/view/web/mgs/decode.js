/** The streams of a file to a scene, as tasks that run when what they need is there. */

import { AppearanceDecoder } from "./appearance.js";
import { bookNumbers, decodeIndices, lookUp, meanCodes, splitBooks } from "./codebooks.js";
import { SceneError } from "./error.js";
import { decodeHalves } from "./halves.js";
import { C0, LobeDecoder } from "./lobes.js";
import { decodePositions, normalised, toWorld } from "./positions.js";
import { fillRows, makeScene, normaliseQuats } from "./scene.js";
import { APPEARANCE, NETWORK, lobeShapes, splitWeights, weightNumbers } from "./weights.js";

/** @typedef {import("./codebooks.js").Codes} Codes */
/** @typedef {import("./envelope.js").Row} Row */
/** @typedef {import("./envelope.js").Stream} Stream */
/** @typedef {import("./header.js").Attribute} Attribute */
/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./scene.js").Part} Part */
/** @typedef {import("./scene.js").Scene} Scene */
/** @typedef {import("./weights.js").Shape} Shape */
/** @typedef {import("./weights.js").Weights} Weights */
/**
 * @typedef {object} Update what a step did
 * @property {Part[]} changed arrays of the scene with new numbers; may be empty
 * @property {number} from first Gaussian whose numbers are new
 * @property {number} to one behind the last of them
 */
/**
 * @typedef {object} Task
 * @property {string[]} after tasks that must be done
 * @property {((stream: Stream) => Part[]) | null} read takes the stream of the task's name
 * @property {(from: number, to: number) => Part[]} compute for some Gaussians at a time
 * @property {number} chunk how many
 */

const CHUNK = 2048; // Gaussians in a step of a network
const SAMPLES = 256; // Gaussians whose mean colour is the neutral one
const FLOATS = ["raw", "halves"];
const INDICES = ["bits", "rans"];
/**
 * What must be done before a part of the scene is what it will be.
 *
 * @type {Record<Part, string[]>}
 */
const TASKS_OF = {
  means: ["positions"],
  logScales: ["scale"],
  quats: ["rotation"],
  sh: ["colour"],
  lobes: ["opacity", "lobes"],
};

/** Decodes each stream once, what is quick first; attributes without codes yet are neutral. */
export class Decoder {
  /** The scene, once its positions are known. @type {Scene | null} */
  scene = null;

  #header;
  #table;
  /** What is left to do, the most urgent first. @type {Map<string, Task>} */
  #tasks = new Map();
  /** Streams that wait for their task. @type {Map<string, Stream>} */
  #streams = new Map();
  /** Gaussians that a task has computed so far. @type {Map<string, number>} */
  #computed = new Map();

  /** @type {Weights | null} */
  #network = null;
  /** @type {LobeDecoder | null} */
  #lobeDecoder = null;
  /** @type {AppearanceDecoder | null} */
  #appearance = null;
  /** @type {Map<Attribute, Codes>} */
  #codes = new Map();
  #places = new Float32Array(0); // normalised positions
  #neutralLobes = Float32Array.of(0, 1 / C0); // without the base opacity

  /**
   * @param {Header} header
   * @param {Row[]} table
   */
  constructor(header, table) {
    this.#header = header;
    this.#table = table;
    this.#planWeights();
    this.#planStream("codebooks", FLOATS, [], (stream) => this.#readBooks(stream));
    const decoders = [...this.#tasks.keys()];
    this.#planStream("positions", ["morton-class"], decoders, (s) => this.#readPositions(s));
    for (const [name, { count, size }] of header.cuts) {
      for (let i = 0; i < count; i++) {
        this.#planStream(`${name}.${i}`, INDICES, ["positions"], (stream) => {
          this.#of(name).columns[i] = decodeIndices(stream, header.count, size);
          return [];
        });
      }
    }
    this.#planAttributes();
  }

  /** Whether everything is decoded. */
  get complete() {
    return this.#tasks.size === 0;
  }

  /** Whether a part of the scene is what it will be. @param {Part} part */
  has(part) {
    return !TASKS_OF[part].some((name) => this.#tasks.has(name));
  }

  /** Takes in a stream; those that are not known are let go. @param {Stream} stream */
  accept(stream) {
    if (this.#tasks.get(stream.name)?.read) this.#streams.set(stream.name, stream);
  }

  /**
   * Does the next thing that can be done.
   *
   * @param {boolean} roomy whether there may be arrays for every Gaussian
   * @returns {Update | null} null: there is nothing to do before another stream comes
   */
  step(roomy) {
    for (const [name, task] of this.#tasks) {
      const stream = this.#streams.get(name);
      if (task.read !== null && stream === undefined) continue;
      if (task.after.some((other) => this.#tasks.has(other))) continue;
      if (name === "positions" && !roomy) continue;
      return this.#run(name, task, stream);
    }
    return null;
  }

  /**
   * @param {string} name
   * @param {Task} task
   * @param {Stream | undefined} stream
   * @returns {Update}
   */
  #run(name, task, stream) {
    const from = this.#computed.get(name) ?? 0;
    const to = Math.min(from + task.chunk, this.#header.count);
    const changed = task.read && stream ? task.read(stream) : task.compute(from, to);
    this.#computed.set(name, to);
    if (to === this.#header.count) {
      this.#tasks.delete(name);
      this.#streams.delete(name);
    }
    return { changed, from, to };
  }

  /**
   * @param {string} name
   * @param {string[]} codecs
   * @param {string[]} after
   * @param {(stream: Stream) => Part[]} read
   */
  #planStream(name, codecs, after, read) {
    const row = this.#table.find((row) => row.name === name);
    if (row === undefined) throw new SceneError(`the .mgs file lacks its stream '${name}'`);
    if (!codecs.includes(row.codec)) {
      throw new SceneError(
        `the stream '${name}' of the .mgs file uses the codec '${row.codec}', which this ` +
          "program does not know",
      );
    }
    this.#tasks.set(name, { after, read, compute: () => [], chunk: Infinity });
  }

  /**
   * @param {string} name
   * @param {string[]} after
   * @param {number} chunk
   * @param {(from: number, to: number) => Part} compute
   */
  #planComputing(name, after, chunk, compute) {
    this.#tasks.set(name, { after, read: null, compute: (from, to) => [compute(from, to)], chunk });
  }

  #planWeights() {
    /** @type {(name: string, shapes: Shape[], take: (weights: Weights) => void) => void} */
    const plan = (name, shapes, take) =>
      this.#planStream(name, FLOATS, [], (stream) => {
        take(splitWeights(decodeHalves(stream, weightNumbers(shapes)), shapes));
        return [];
      });
    const { network, lobes } = this.#header;
    if (network) plan("view-network", NETWORK, (found) => (this.#network = found));
    if (lobes) {
      const shapes = lobeShapes(lobes);
      plan("lobe-decoder", shapes, (found) => (this.#lobeDecoder = new LobeDecoder(lobes, found)));
    }
    plan("appearance-decoder", APPEARANCE, (found) => {
      this.#appearance = new AppearanceDecoder(found);
    });
  }

  /** What is done with indices: quick things first. */
  #planAttributes() {
    const { cuts, lobes } = this.#header;
    /** @type {(name: Attribute) => string[]} */
    const columns = (name) =>
      Array.from({ length: cuts.get(name)?.count ?? 0 }, (_, i) => `${name}.${i}`);
    this.#planComputing("scale", columns("scale"), Infinity, (from, to) => this.#scale(from, to));
    this.#planComputing("rotation", columns("rotation"), Infinity, (from, to) =>
      this.#rotation(from, to),
    );
    if (cuts.has("opacity")) {
      this.#planComputing("opacity", columns("opacity"), Infinity, (from, to) =>
        this.#opacity(from, to),
      );
    }
    const latents = columns("appearance");
    this.#planComputing("colour", latents, CHUNK, (from, to) => this.#colour(from, to));
    if (lobes === null) return;
    // hidden layers look at everything else
    const all = [...this.#tasks.keys()];
    this.#planComputing("lobes", all, CHUNK, (from, to) => this.#lobes(from, to));
  }

  /** @param {Stream} stream @returns {Part[]} */
  #readBooks(stream) {
    const { cuts } = this.#header;
    for (const [name, books] of splitBooks(decodeHalves(stream, bookNumbers(cuts)), cuts)) {
      this.#codes.set(name, { length: given(cuts.get(name)).length, books, columns: [] });
    }
    return [];
  }

  /**
   * Positions make the scene, with neutral values for all the rest.
   *
   * @param {Stream} stream
   * @returns {Part[]}
   */
  #readPositions(stream) {
    const { count, frame, lobes } = this.#header;
    const stored = decodePositions(stream.data, count);
    this.#places = normalised(stored, frame);
    const means = toWorld(this.#places, frame);
    const range = rangeOf(this.#of("scale").books);
    const scene = makeScene(this.#header, stored, means, range, this.#network);
    const logScales = new Float32Array(3);
    lookUp(meanCodes(this.#of("scale"), 1), 0, 1, logScales, 0, 3);
    const quats = Float32Array.of(1, 0, 0, 0);
    const sh = this.#meanColour();
    const stride = scene.lobes.length / count;
    if (lobes) {
      this.#neutralLobes = new Float32Array(stride);
      const codes = this.#codes.get("lobes");
      const mean = codes ? meanCodes(codes, 1) : null;
      given(this.#lobeDecoder).decode({ sh, logScales, quats }, mean, 0, 1, this.#neutralLobes);
    }
    const constant = this.#neutralLobes.slice();
    const opacity = this.#codes.get("opacity");
    if (opacity) addBase(meanCodes(opacity, 1), 0, 1, constant, stride);
    fillRows(scene.logScales, logScales);
    fillRows(scene.quats, quats);
    fillRows(scene.sh, sh);
    fillRows(scene.lobes, constant);
    this.scene = scene;
    return ["means", "logScales", "quats", "sh", "lobes"];
  }

  /** Harmonics of one colour: the mean of what mean latents give in some places. */
  #meanColour() {
    const { count } = this.#header;
    const samples = Math.min(count, SAMPLES);
    const places = new Float32Array(3 * samples);
    for (let i = 0; i < samples; i++) {
      const from = 3 * Math.floor((i * count) / samples);
      places.set(this.#places.subarray(from, from + 3), 3 * i);
    }
    const found = new Float32Array(12 * samples);
    const codes = meanCodes(this.#of("appearance"), samples);
    given(this.#appearance).decode(places, codes, 0, samples, found);
    const mean = new Float32Array(12);
    for (let i = 0; i < 3; i++) {
      for (let row = 0; row < samples; row++) mean[i] += found[12 * row + i] / samples;
    }
    return mean;
  }

  /** @param {number} from @param {number} to @returns {Part} */
  #scale(from, to) {
    lookUp(this.#of("scale"), from, to, given(this.scene).logScales, 3 * from, 3);
    return "logScales";
  }

  /** @param {number} from @param {number} to @returns {Part} */
  #rotation(from, to) {
    const { quats } = given(this.scene);
    lookUp(this.#of("rotation"), from, to, quats, 4 * from, 4);
    normaliseQuats(quats, from, to);
    return "quats";
  }

  /** @param {number} from @param {number} to @returns {Part} */
  #opacity(from, to) {
    const { lobes, count } = given(this.scene);
    const stride = lobes.length / count;
    for (let i = from; i < to; i++) lobes[i * stride] = this.#neutralLobes[0];
    addBase(this.#of("opacity"), from, to, lobes, stride);
    return "lobes";
  }

  /** @param {number} from @param {number} to @returns {Part} */
  #colour(from, to) {
    const { sh } = given(this.scene);
    given(this.#appearance).decode(this.#places, this.#of("appearance"), from, to, sh);
    return "sh";
  }

  /** @param {number} from @param {number} to @returns {Part} */
  #lobes(from, to) {
    const scene = given(this.scene);
    const latents = this.#codes.get("lobes") ?? null;
    given(this.#lobeDecoder).decode(scene, latents, from, to, scene.lobes);
    const opacity = this.#codes.get("opacity");
    if (opacity) addBase(opacity, from, to, scene.lobes, scene.lobes.length / scene.count);
    return "lobes";
  }

  /** @param {Attribute} name */
  #of(name) {
    return given(this.#codes.get(name));
  }
}

/**
 * Adds the base opacity's logit to the constant part of the opacity's lobe.
 *
 * @param {Codes} codes
 * @param {number} from
 * @param {number} to
 * @param {Float32Array} lobes
 * @param {number} stride
 */
function addBase({ books: [book], columns: [column] }, from, to, lobes, stride) {
  for (let i = from; i < to; i++) lobes[i * stride] += book[column[i]] / C0;
}

/** The least and the largest number. @param {Float32Array[]} books @returns {[number, number]} */
function rangeOf(books) {
  let range = /** @type {[number, number]} */ ([Infinity, -Infinity]);
  for (const book of books) {
    for (const value of book) range = [Math.min(range[0], value), Math.max(range[1], value)];
  }
  return range;
}

/**
 * What an earlier task has made.
 *
 * @template T
 * @param {T | null | undefined} value
 * @returns {T}
 */
function given(value) {
  if (value === null || value === undefined) throw new Error("a task came before what it needs");
  return value;
}
