/** Reads a scene away from the page's own thread, sends it on as it arrives, and sorts if needed. */

import { COLORED, WHOLE } from "../mgs/decode.js";
import { centersOf, thinned, toWorld } from "../mgs/positions.js";
import { readScene } from "../mgs/reader.js";
import { RowDecoder } from "../mgs/rows.js";
import { emptyScene, packRows } from "../render/pack.js";
import { Crew, turn } from "./crew.js";
import { farFirst } from "./order.js";
import { isPly, readPly } from "./ply.js";
import { isSpz, readSpz } from "./spz.js";

/** @typedef {import("../mgs/decode.js").CodedLayer} CodedLayer */
/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/dots.js").Dots} Dots */
/** @typedef {import("../render/pack.js").PackedRows} PackedRows */
/** @typedef {import("../mgs/positions.js").Places} Places */
/** @typedef {import("../mgs/reader.js").SceneReader} SceneReader */
/** @typedef {import("../render/types.js").Numbers} Numbers */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {{url: string} | {file: Blob} | {forward: [number, number, number]}} Request */
/**
 * @typedef {{kind: "dots", dots: Dots, views: View[], near: number}
 *   | {kind: "scene", data: SceneData, places: Places, views: View[], near: number}
 *   | {kind: "more", places: Places}
 *   | {kind: "rows", part: Part, from: number, numbers: Numbers}
 *   | {kind: "order", order: Uint32Array<ArrayBuffer>}
 *   | {kind: "progress", received: number, total: number}
 *   | {kind: "done", milliseconds: number, bytes: number}
 *   | {kind: "failed", sentence: string}} Message
 */

/** Dots in a first picture, at most: more keep a slow device from decoding what they stand for. */
const DOTS = 8192;
/** Of a scene that does not say. */
const NEAR = 0.2;
/** Bytes to begin with, of a file that does not say how long it is. */
const MORE = 2 ** 20;
/** Milliseconds between two states that are shown. */
const SOON = 1500;
/** Gaussians for which a byte of the file that has come makes room: a claim alone does not. */
const ROOM = 8;
const PARTS = /** @type {Part[]} */ (["shapes", "colors", "lobes"]);
const NETWORK =
  "this scene asks a network for every Gaussian in every frame, which no viewer does: train it " +
  "with --set student.view.kind=fitted student.view.fraction=0.35";

/** Of a scene that may be sorted. */
let centers = new Float32Array(0);

/** @param {Message} message @param {Transferable[]} [moved] */
const send = (message, moved = []) => self.postMessage(message, { transfer: moved });

/** What of a scene moves to who draws it. @param {SceneData} data */
const movable = ({ shapes, colors, lobes }) => [shapes.buffer, colors.buffer, lobes.buffer];

/**
 * @param {{url: string} | {file: Blob}} request
 * @returns {Promise<{source: ReadableStream<Uint8Array<ArrayBuffer>>, total: number}>}
 */
async function bytesOf(request) {
  if ("file" in request) return { source: request.file.stream(), total: request.file.size };
  let response;
  try {
    response = await fetch(request.url);
  } catch {
    throw new Error(
      `${request.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`,
    );
  }
  if (!response.ok || response.body === null) {
    throw new Error(`${request.url} could not be loaded: the server says ${response.status}`);
  }
  // of what is compressed on its way the length is another one
  const length = response.headers.has("Content-Encoding") ? NaN : Number(response.headers.get("Content-Length"));
  return { source: response.body, total: length || NaN };
}

/**
 * A `.mgs` whose first positions are known: some Gaussians of its first layer as dots, then all of
 * them and what is known of them, then the other layers, each when it is done.
 */
class Arriving {
  #header;
  #layers;
  #crew;
  #own;
  /** Layers that are shown; 0: some of the first, as dots. */
  #shown = 0;
  /** Before it is sent. @type {SceneData & PackedRows | null} */
  #scene = null;
  #room = false; // whether it was made

  /**
   * @param {Header} header
   * @param {CodedLayer[]} layers
   * @param {Crew} crew
   * @param {RowDecoder} own
   */
  constructor(header, layers, crew, own) {
    this.#header = header;
    this.#layers = layers;
    this.#crew = crew;
    this.#own = own;
    const { frame, views, near } = header;
    const background = /** @type {[number, number, number]} */ (Array.from(header.background));
    const { color, side } = own.neutral;
    const centers = toWorld(thinned(/** @type {Uint16Array} */ (layers[0].positions), DOTS), frame);
    // few of them cover what all will cover
    const grown = side * Math.sqrt((3 * header.count) / centers.length);
    const dots = { centers, color, side: grown, background };
    send({ kind: "dots", dots, views, near }, [dots.centers.buffer]);
  }

  /** Sends what has been done since the last time. @param {number} received bytes of the file */
  send(received) {
    if (!this.#crew.begun || !this.makeRoom(received)) return;
    const done = this.#crew.layers;
    const before = this.#shown;
    this.#shown = Math.max(done, 1);
    const taken = this.#crew.taken.splice(0);
    const scene = this.#scene;
    if (scene) {
      this.#scene = this.#crew.room = null; // it goes away
      const { views, near } = this.#header;
      send({ kind: "scene", data: scene, places: this.#places(), views, near }, movable(scene));
      return;
    }
    for (const [from, packed] of taken) {
      for (const part of PARTS) {
        const numbers = packed[part];
        send({ kind: "rows", part, from, numbers }, [numbers.buffer]);
      }
    }
    if (before === this.#shown) return;
    send({ kind: "more", places: this.#places() });
  }

  /** Whether there is a scene to write into, or was, after so many bytes. @param {number} received */
  makeRoom(received) {
    const { count } = this.#header;
    if (!this.#room && ROOM * received >= count) {
      this.#scene = this.#crew.room = emptyScene(this.#header, count, this.#own.scaleRange);
      this.#room = true;
    }
    return this.#room;
  }

  /** Of the layers that are shown. Few of those who ask need them in the world. @returns {Places} */
  #places() {
    const layers = this.#layers.slice(0, this.#shown);
    const stored = new Uint16Array(layers.reduce((sum, { count }) => sum + 3 * count, 0));
    let at = 0;
    for (const { positions, count } of layers) {
      stored.set(/** @type {Uint16Array} */ (positions), at);
      at += 3 * count;
    }
    const places = { stored, frame: this.#header.frame };
    if (this.#header.sorted) centers = centersOf(places);
    return places;
  }
}

/**
 * A scene that is shown while it arrives, though not with every step: a picture of half of it keeps
 * the device from the other half. Returns its bytes.
 *
 * @param {ReadableStream<Uint8Array>} source
 */
async function loadMgs(source) {
  let crew = /** @type {Crew | null} */ (null);
  let arriving = /** @type {Arriving | null} */ (null);
  let [timer, arrived] = [0, 0];
  let come = /** @type {import("../mgs/decode.js").CodedLayer[]} */ ([]);
  /** @type {(reader: SceneReader, waited: number) => Promise<void>} */
  const onStep = async ({ header, decoder, received, total }, waited) => {
    send({ kind: "progress", received, total });
    if (header === null || decoder === null) return;
    if (header.network) throw new Error(NETWORK);
    arrived = received;
    crew ??= new Crew(header.layers);
    const layers = (come = decoder.layers);
    const slow = waited * (total / received - 1) > SOON;
    if (layers[0].positions && !arriving) {
      arriving = new Arriving(header, layers, crew, crew.begin(decoder));
      crew.hire(); // not before there is something to see: what helpers take to start delays it
      timer = setInterval(() => arriving?.send(arrived), SOON);
    }
    arriving?.makeRoom(received);
    for (const [i, { stage }] of layers.entries()) {
      if (arriving && (stage === WHOLE || (slow && i === 0 && stage >= COLORED))) crew.advance(i, stage);
    }
    await turn();
  };
  try {
    await readScene(source, onStep);
  } finally {
    // layers that have come are shown, as far as they have colours, whatever became of the rest
    for (const [i, { stage, positions }] of come.entries()) {
      if (arriving && positions && stage >= COLORED) crew?.advance(i, stage);
    }
    await crew?.finish().finally(() => {
      clearInterval(timer);
      crew?.dismiss();
    });
    arriving?.send(arrived);
  }
  return arrived;
}

/**
 * A plain scene, which is read when all of it is there. Returns its bytes.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 * @param {number} total bytes
 * @param {(bytes: Uint8Array<ArrayBuffer>) => SceneData | Promise<SceneData>} read
 */
async function loadPlain(source, total, read) {
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
  const data = await read(bytes.subarray(0, received));
  if (!data.count) throw new Error("there is no Gaussian in this file that can be drawn");
  centers = new Float32Array(3 * data.count);
  for (let i = 0; i < centers.length; i++) centers[i] = data.shapes[4 * i + 3];
  send({ kind: "scene", data, places: centers, views: [], near: NEAR }, movable(data));
  return received;
}

/**
 * The first piece of a stream, and a stream that begins with it all the same, and tells in plain words if it breaks.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 */
async function peeked(source) {
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
    const { first, whole } = await peeked(source);
    let bytes;
    if (isPly(first)) bytes = await loadPlain(whole, total, readPly);
    else if (isSpz(first)) bytes = await loadPlain(whole, total, readSpz);
    else bytes = await loadMgs(whole);
    send({ kind: "done", milliseconds: performance.now() - started, bytes });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    // what asks for more memory than there is fails in words of the browser's own
    const sentence = error instanceof RangeError ? `the scene is too large for this device: ${message}` : message;
    send({ kind: "failed", sentence });
  }
}

/** Of a helper. @type {RowDecoder} */
let decoder;

self.onmessage = async ({ data }) => {
  if ("recipe" in data) {
    decoder = new RowDecoder(data.recipe);
    return;
  }
  if ("rows" in data) {
    const { rows, chunk, stage } = data;
    const packed = packRows(decoder, rows);
    const moved = PARTS.map((part) => packed[part].buffer);
    self.postMessage({ chunk, stage, packed }, { transfer: moved });
    return;
  }
  if ("forward" in data) {
    const order = farFirst(centers, data.forward);
    send({ kind: "order", order }, [order.buffer]);
    return;
  }
  await load(data);
};

// a page that was there before the viewer's script names the scene with its thread: early.js
if (self.name) void load({ url: self.name });
