/** The worker that loads a scene, sends it to the page while it arrives, and sorts it if needed; and its helpers. */

import { COLORED, COMPLETE } from "../mgs/stream_decoder.js";
import { worldMeans, subsampled, toWorld } from "../mgs/positions.js";
import { readScene } from "../mgs/reader.js";
import { GaussianDecoder } from "../mgs/gaussian_decoder.js";
import { buffersOf, emptyScene, packRows } from "../render/pack.js";
import { addressOf, startWorker } from "../assets.js";
import { WorkerPool } from "./worker_pool.js";
import { backToFront } from "./depth_sort.js";
import { bytesOf } from "./bytes_of.js";
import { nearOf } from "./near.js";
import { isPly, isSpz } from "./file_kind.js";
import { yieldToMessages } from "./yield_to_messages.js";
import { parsedUp } from "../viewer/up.js";

/** @typedef {import("../mgs/stream_decoder.js").QuantizedLevel} QuantizedLevel */
/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/dots.js").Dots} Dots */
/** @typedef {import("../render/pack.js").PackedRows} PackedRows */
/** @typedef {import("../mgs/positions.js").StoredMeans} StoredMeans */
/** @typedef {import("../mgs/reader.js").SceneReader} SceneReader */
/** @typedef {import("../mgs/weights.js").Weights} Weights */
/** @typedef {import("../render/types.js").Numbers} Numbers */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("../viewer/vector.js").Vector} Vector */
/** @typedef {{url: string} | {file: Blob} | {forward: [number, number, number]}} Request */
/**
 * @typedef {object} Cameras what a file tells of them
 * @property {View[]} views training cameras
 * @property {number} near
 * @property {Vector | null} up upward direction
 * @property {import("../mgs/header.js").Header["meta"]} notes
 */
/**
 * @typedef {({kind: "dots", dots: Dots} & Cameras)
 *   | ({kind: "scene", data: SceneData, means: StoredMeans} & Cameras)
 *   | {kind: "more", means: StoredMeans}
 *   | {kind: "rows", part: Part, from: number, numbers: Numbers}
 *   | {kind: "order", order: Uint32Array<ArrayBuffer>}
 *   | {kind: "progress", received: number, total: number}
 *   | {kind: "done", milliseconds: number, bytes: number}
 *   | {kind: "failed", sentence: string}} Message
 */
/** @typedef {Message | {kind: "formats"}} Sent the last asks for the script of `formats_worker.js` */

/** The most dots in the preview: more would delay decoding on slow devices. */
const DOTS = 8192;
/** Bytes to reserve first for a file of unknown length. */
const MORE = 2 ** 20;
/** Milliseconds between two updates of the page. */
const SOON = 1500;
/** Gaussians per received byte that memory may be allocated for, so that a false count in the header allocates little. */
const GAUSSIANS_PER_BYTE = 8;
const PARTS = /** @type {Part[]} */ (["shapes", "colors", "lobes"]);

/** Takes the address of the script of `formats_worker.js`. */
let receiveFormats = (/** @type {string} */ _) => {};
/** Means of the Gaussians of a sorted scene. */
let means = new Float32Array(0);

/** @param {Sent} message @param {Transferable[]} [transfer] */
const send = (message, transfer = []) => self.postMessage(message, { transfer });

/**
 * A `.mgs` whose first positions are decoded.
 *
 * Sends some Gaussians of the first LOD level as dots, then the first level with all that is known of
 * it, then each other level when it is complete.
 */
class SceneSender {
  #header;
  #levels;
  #pool;
  #own;
  #network;
  /** Levels that the page shows; 0: dots of the first. */
  #shown = 0;
  /** The arrays that results are written to, until they are sent. @type {SceneData & PackedRows | null} */
  #scene = null;
  #allocated = false;

  /**
   * @param {Header} header
   * @param {QuantizedLevel[]} levels
   * @param {WorkerPool} pool
   * @param {GaussianDecoder} own
   * @param {Weights | null} network
   */
  constructor(header, levels, pool, own, network) {
    this.#header = header;
    this.#network = network;
    this.#levels = levels;
    this.#pool = pool;
    this.#own = own;
    const background = /** @type {[number, number, number]} */ (Array.from(header.background));
    const { color, side } = own.neutral;
    const means = toWorld(subsampled(/** @type {Uint16Array} */ (levels[0].positions), DOTS), header.grid);
    // fewer dots are larger, to cover about the same area
    const grown = side * Math.sqrt((3 * header.count) / means.length);
    const dots = { means, color, side: grown, background };
    send({ kind: "dots", dots, ...this.#cameras }, [dots.means.buffer]);
  }

  /** @returns {Cameras} */
  get #cameras() {
    const { views, near, meta } = this.#header;
    return { views, near, up: parsedUp(meta.up), notes: meta };
  }

  /** Send the results since the last call. @param {number} received bytes of the file */
  send(received) {
    if (!this.#pool.firstLevelReady || !this.allocate(received)) return;
    const done = this.#pool.levels;
    const before = this.#shown;
    this.#shown = Math.max(done, 1);
    const taken = this.#pool.results.splice(0);
    const scene = this.#scene;
    if (scene) {
      this.#scene = this.#pool.output = null; // it is transferred
      send({ kind: "scene", data: scene, means: this.#storedMeans(), ...this.#cameras }, buffersOf(scene));
      return;
    }
    for (const [from, packed] of taken) {
      for (const part of PARTS) {
        const numbers = packed[part];
        send({ kind: "rows", part, from, numbers }, [numbers.buffer]);
      }
    }
    if (before === this.#shown) return;
    send({ kind: "more", means: this.#storedMeans() });
  }

  /** Allocate the scene once enough of the file is here; returns whether it is. @param {number} received bytes of the file */
  allocate(received) {
    const { count } = this.#header;
    if (!this.#allocated && GAUSSIANS_PER_BYTE * received >= count) {
      this.#scene = this.#pool.output = emptyScene(
        this.#header,
        count,
        this.#own.scaleRange,
        this.#network,
      );
      this.#allocated = true;
    }
    return this.#allocated;
  }

  /** The stored means of the levels that are shown. @returns {StoredMeans} */
  #storedMeans() {
    const levels = this.#levels.slice(0, this.#shown);
    const stored = new Uint16Array(levels.reduce((sum, { count }) => sum + 3 * count, 0));
    let at = 0;
    for (const { positions, count } of levels) {
      stored.set(/** @type {Uint16Array} */ (positions), at);
      at += 3 * count;
    }
    const found = { stored, grid: this.#header.grid };
    if (this.#header.sorted) means = worldMeans(found);
    return found;
  }
}

/**
 * Load a `.mgs` and show it while it arrives; returns its bytes.
 *
 * Not every decoded stage is shown: rendering half a scene delays decoding the rest.
 *
 * @param {ReadableStream<Uint8Array>} source
 */
async function loadMgs(source) {
  let pool = /** @type {WorkerPool | null} */ (null);
  let sender = /** @type {SceneSender | null} */ (null);
  let [timer, arrived] = [0, 0];
  let come = /** @type {import("../mgs/stream_decoder.js").QuantizedLevel[]} */ ([]);
  /** @type {(reader: SceneReader, waited: number) => Promise<void>} */
  const onStep = async ({ header, decoder, received, total }, waited) => {
    send({ kind: "progress", received, total });
    if (header === null || decoder === null) return;
    arrived = received;
    pool ??= new WorkerPool(header.lodSizes);
    const levels = (come = decoder.levels);
    const slow = waited * (total / received - 1) > SOON;
    if (levels[0].positions && !sender) {
      sender = new SceneSender(header, levels, pool, pool.start(decoder), decoder.network);
      pool.spawn(); // after the first dots: starting helpers delays them
      timer = setInterval(() => sender?.send(arrived), SOON);
    }
    sender?.allocate(received);
    for (const [i, { stage }] of levels.entries()) {
      if (sender && (stage === COMPLETE || (slow && i === 0 && stage >= COLORED))) pool.advance(i, stage);
    }
    await yieldToMessages();
  };
  try {
    await readScene(source, onStep);
  } finally {
    // show the levels that have colours, even if the rest of the file failed
    for (const [i, { stage, positions }] of come.entries()) {
      if (sender && positions && stage >= COLORED) pool?.advance(i, stage);
    }
    await pool?.finish().finally(() => {
      clearInterval(timer);
      pool?.terminate();
    });
    sender?.send(arrived);
  }
  return arrived;
}

/**
 * Load a file of another format, which is parsed when it is complete; returns its bytes.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 * @param {number} total bytes
 */
async function loadOther(source, total) {
  /** @type {Promise<string>} */
  const formats = new Promise((resolve) => (receiveFormats = resolve));
  // a script that the page hosts contains that of formats
  if (self.location.protocol === "blob:") send({ kind: "formats" });
  else receiveFormats(`${self.location.href}#formats`);
  let [bytes, received] = [new Uint8Array(total || MORE), 0];
  const reader = source.getReader();
  for (let piece; !(piece = await reader.read()).done; ) {
    const needed = received + piece.value.length;
    if (needed > bytes.length) {
      const before = bytes;
      bytes = new Uint8Array(Math.max(needed, 2 * bytes.length));
      bytes.set(before);
    }
    bytes.set(piece.value, received);
    received = needed;
    send({ kind: "progress", received, total });
  }
  const data = await parsed(bytes.subarray(0, received), await formats);
  if (!data.count) throw new Error("there is no Gaussian in this file");
  means = new Float32Array(3 * data.count);
  for (let i = 0; i < means.length; i++) means[i] = data.shapes[4 * i + 3];
  const cameras = { views: [], near: nearOf(means), up: data.up ?? null, notes: data.notes ?? {} };
  send({ kind: "scene", data, means, ...cameras }, buffersOf(data));
  return received;
}

/**
 * Parse a file in a worker of its own.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes which are transferred
 * @param {string} formats address of the worker's script; empty if it could not be loaded
 * @returns {Promise<SceneData>}
 */
async function parsed(bytes, formats) {
  const lost = () => new Error("the viewer's own files could not be loaded: reload the page");
  if (!formats) throw lost();
  const worker = startWorker(formats);
  try {
    return await new Promise((resolve, reject) => {
      worker.onmessage = (/** @type {MessageEvent<import("./formats_worker.js").Parsed>} */ { data }) => {
        if ("scene" in data) resolve(data.scene);
        else reject(data.memory ? new RangeError(data.failed) : new Error(data.failed));
      };
      worker.onerror = () => reject(lost());
      worker.postMessage(bytes, [bytes.buffer]);
    });
  } finally {
    worker.terminate();
  }
}

/**
 * Read the first piece of a stream; returns it and a stream that still contains it.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 */
async function peek(source) {
  const reader = source.getReader();
  const read = () => reader.read().catch(() => {
    throw new Error("the file broke off before its end: load it again");
  });
  let next = /** @type {Awaited<ReturnType<typeof read>> | null} */ (await read());
  const first = next?.value ?? new Uint8Array(0);
  /** @type {ReadableStream<Uint8Array<ArrayBuffer>>} */
  const whole = new ReadableStream({
    async pull(to) {
      const { value, done } = next ?? (await read());
      next = null;
      if (done) to.close();
      else to.enqueue(value);
    },
    cancel: () => reader.cancel(),
  });
  return { first, whole };
}

/** @param {{url: string} | {file: Blob}} request */
async function load(request) {
  const started = performance.now();
  try {
    const { source, total } = await bytesOf(request);
    const { first, whole } = await peek(source);
    const bytes = await (isPly(first) || isSpz(first) ? loadOther(whole, total) : loadMgs(whole));
    send({ kind: "done", milliseconds: performance.now() - started, bytes });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    // browsers throw a RangeError where memory is short
    const sentence = error instanceof RangeError ? `the scene is too large for this device: ${message}` : message;
    send({ kind: "failed", sentence });
  }
}

/** The decoder of a helper. @type {GaussianDecoder} */
let decoder;

/** @param {MessageEvent} event */
export const receive = async ({ data }) => {
  if ("decoderInputs" in data) {
    decoder = new GaussianDecoder(data.decoderInputs);
  } else if ("rows" in data) {
    const { rows, chunk, stage } = data;
    const packed = packRows(decoder, rows);
    self.postMessage({ chunk, stage, packed }, { transfer: buffersOf(packed) });
  } else if ("forward" in data) {
    const order = backToFront(means, data.forward);
    send({ kind: "order", order }, [order.buffer]);
  } else if ("formats" in data) {
    receiveFormats(data.formats && addressOf(data.formats));
  } else {
    await load(data);
  }
};

if (globalThis.self) self.onmessage = receive; // Node.js has none
