/** Gaussians of a `.mgs` made ready for the GPU, by this thread and some helpers. */

import { newWorker } from "../files.js";
import { COLORED } from "../mgs/decode.js";
import { RowDecoder } from "../mgs/rows.js";
import { packRows } from "../render/pack.js";

/** @typedef {import("../mgs/decode.js").Decoder} Decoder */
/** @typedef {import("../mgs/rows.js").Recipe} Recipe */
/** @typedef {import("../render/pack.js").PackedRows} PackedRows */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {{chunk: number, stage: number, packed: PackedRows}} Brought what a helper sends back */
/** @typedef {{worker: Worker, errands: number}} Helper with what it has not brought yet */
/** @typedef {{layer: number, from: number, to: number, first: number}} Chunk rows of a layer, the first of them in the scene */

/** Gaussians at a time: milliseconds. */
const CHUNK = 8192;
/** Gaussians from which on helpers save more time than it takes to start them. */
const WORTH = 100_000;
const HELPERS = 3;
/** Errands of a helper, so that it need not wait for the next one. */
const AHEAD = 2;
/** Milliseconds that messages wait. */
const PATIENCE = 8;

/**
 * Computes each chunk of Gaussians as soon as a stage of its layer is there, and again for a later
 * one. Nothing depends on the helpers: what they were given and have not brought is done here in the
 * end, and whatever comes first counts.
 */
export class Crew {
  /** What has been done and nobody has taken away yet. @type {[from: number, PackedRows][]} */
  taken = [];
  /** @type {Chunk[]} */
  #chunks = [];
  /** Of each layer, the stage that is wanted. */
  #stages;
  /** @type {Decoder | null} */
  #codes = null;
  /** @type {RowDecoder | null} */
  #own = null;
  /** @type {Helper[]} */
  #helpers = [];
  #count; // Gaussians
  #room = /** @type {PackedRows | null} */ (null);
  /** By chunk, the stage that somebody was asked for, and the one that there is. */
  #given;
  #done;
  #running = false;
  #ending = false;
  #resolve = () => {};
  #reject = () => {};
  /** @type {Promise<void>} */
  #end = new Promise((resolve, reject) => {
    this.#resolve = resolve;
    this.#reject = reject;
  });

  /** @param {number[]} layers Gaussians of each */
  constructor(layers) {
    // what goes wrong is told to who waits for the end
    this.#end.catch(() => {});
    let count = 0;
    for (const [layer, size] of layers.entries()) {
      for (let from = 0; from < size; from += CHUNK) {
        this.#chunks.push({ layer, from, to: Math.min(from + CHUNK, size), first: count + from });
      }
      count += size;
    }
    this.#stages = new Uint8Array(layers.length);
    this.#given = new Uint8Array(this.#chunks.length);
    this.#done = this.#given.slice();
    this.#count = count;
  }

  /** Room for all Gaussians, if there is: then what is done is written there. @param {PackedRows | null} room */
  set room(room) {
    this.#room = room;
    if (room === null) return;
    for (const [from, packed] of this.taken.splice(0)) {
      write(packed, partOf(room, this.#count, from, from + packed.shapes.length / 4));
    }
  }

  /** Hires helpers, if they are worth it. `begin` comes first. */
  hire() {
    const { recipe } = /** @type {Decoder} */ (this.#codes);
    const cores = this.#count < WORTH ? 1 : navigator.hardwareConcurrency;
    for (let i = 1; i < Math.min(cores, HELPERS + 1); i++) this.#hire(recipe);
  }

  /** @param {Recipe} recipe */
  #hire(recipe) {
    try {
      const worker = newWorker();
      worker.postMessage({ recipe });
      const helper = { worker, errands: 0 };
      worker.onmessage = ({ data }) => {
        helper.errands--;
        this.#take(data);
        this.#send(helper);
      };
      worker.onerror = (event) => event.preventDefault();
      this.#helpers.push(helper);
    } catch {
      // there are browsers in which workers have none
    }
  }

  /** Positions of the first layer are there. @param {Decoder} codes @returns {RowDecoder} of this thread */
  begin(codes) {
    this.#codes = codes;
    return (this.#own = new RowDecoder(codes.recipe));
  }

  /** Computes what a stage brings, if it was not asked for yet. @param {number} layer @param {number} stage */
  advance(layer, stage) {
    if (stage <= this.#stages[layer]) return;
    this.#stages[layer] = stage;
    for (const helper of this.#helpers) this.#send(helper);
    this.#run().catch(this.#reject);
  }

  /** Waits until all that was asked for is done. */
  finish() {
    this.#ending = true;
    this.#check();
    return this.#end;
  }

  /** Sends the helpers home. */
  dismiss() {
    for (const { worker } of this.#helpers) worker.terminate();
  }

  /** The first chunk that nobody was given; -1 if there is none. */
  get #free() {
    return this.#given.findIndex((stage, chunk) => stage < this.#wanted(chunk));
  }

  /** That, or else one that a helper still has. */
  get #next() {
    const free = this.#free;
    return free < 0 ? this.#done.findIndex((stage, chunk) => stage < this.#wanted(chunk)) : free;
  }

  /** The stage that a chunk should have. @param {number} chunk */
  #wanted(chunk) {
    return this.#stages[this.#chunks[chunk].layer];
  }

  /** @param {number} chunk @param {"slice" | "subarray"} how */
  #rows(chunk, how) {
    const { layers } = /** @type {Decoder} */ (this.#codes);
    const { layer, from, to } = this.#chunks[chunk];
    return layers[layer].rows(from, to, how);
  }

  /** Where a chunk has room, if it has. @param {number} chunk @returns {PackedRows | undefined} */
  #place(chunk) {
    const { first, from, to } = this.#chunks[chunk];
    return this.#room ? partOf(this.#room, this.#count, first, first + to - from) : undefined;
  }

  /** Gives a helper something to do. @param {Helper} helper */
  #send(helper) {
    for (let chunk; helper.errands < AHEAD && (chunk = this.#free) >= 0; helper.errands++) {
      const stage = (this.#given[chunk] = this.#wanted(chunk));
      const rows = this.#rows(chunk, "slice");
      const moved = [rows.positions, ...Object.values(rows.columns).flat()].map(({ buffer }) => buffer);
      helper.worker.postMessage({ rows, chunk, stage }, { transfer: moved });
    }
  }

  async #run() {
    if (this.#running) return;
    this.#running = true;
    for (let chunk; (chunk = this.#next) >= 0 && this.#own; ) {
      const stage = (this.#given[chunk] = this.#wanted(chunk));
      const packed = packRows(this.#own, this.#rows(chunk, "subarray"), this.#place(chunk));
      this.#take({ chunk, stage, packed });
      await turn();
    }
    this.#running = false;
  }

  /** @param {Brought} brought */
  #take({ chunk, stage, packed }) {
    if (stage <= this.#done[chunk]) return;
    this.#done[chunk] = stage;
    const place = this.#place(chunk);
    if (place === undefined) this.taken.push([this.#chunks[chunk].first, packed]);
    else if (place.shapes.buffer !== packed.shapes.buffer) write(packed, place);
    this.#check();
  }

  /** Whether there is something of every Gaussian of the first layer. */
  get begun() {
    return this.#chunks.every(({ layer }, chunk) => layer > 0 || this.#done[chunk] > 0);
  }

  /** How many layers, from the first one on, can be shown. Those behind the first come whole, or are all that will come. */
  get layers() {
    const missing = this.#done.findIndex((stage) => stage < COLORED);
    return missing < 0 ? this.#stages.length : this.#chunks[missing].layer;
  }

  #check() {
    if (this.#ending && this.#next < 0) this.#resolve();
  }
}

/**
 * Some rows of a whole scene, where they lie.
 *
 * @param {PackedRows} scene
 * @param {number} count of its Gaussians
 * @param {number} from
 * @param {number} to
 */
export function partOf(scene, count, from, to) {
  const part = (/** @type {Part} */ name) => {
    const stride = scene[name].length / count;
    return scene[name].subarray(stride * from, stride * to);
  };
  return { shapes: part("shapes"), colors: part("colors"), lobes: part("lobes") };
}

/** @param {PackedRows} packed @param {PackedRows} place of as many */
export function write(packed, place) {
  for (const part of /** @type {Part[]} */ (Object.keys(place))) place[part].set(packed[part]);
}

/** When messages could come through. */
let last = 0;

/** Lets messages through, if they have waited: that takes a millisecond or two. */
export async function turn() {
  if (performance.now() - last < PATIENCE) return;
  const { port1, port2 } = new MessageChannel();
  await new Promise((resolve) => {
    port1.onmessage = () => {
      port1.close();
      resolve(null);
    };
    port2.postMessage(null);
  });
  last = performance.now();
}
