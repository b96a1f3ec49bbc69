/** Decodes and packs the Gaussians of a `.mgs` for the GPU, in this thread and in helper workers. */

import { startWorker } from "../assets.js";
import { COLORED } from "../mgs/stream_decoder.js";
import { GaussianDecoder } from "../mgs/gaussian_decoder.js";
import { packRows } from "../render/pack.js";
import { yieldToMessages } from "./yield_to_messages.js";

/** @typedef {import("../mgs/stream_decoder.js").StreamDecoder} StreamDecoder */
/** @typedef {import("../mgs/gaussian_decoder.js").DecoderInputs} DecoderInputs */
/** @typedef {import("../render/pack.js").PackedRows} PackedRows */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {{chunk: number, stage: number, packed: PackedRows}} Result message of a helper */
/** @typedef {{worker: Worker, jobs: number}} Helper and the number of its unfinished jobs */
/** @typedef {{level: number, from: number, to: number, first: number}} Chunk rows of an LOD level; `first` is the index of the first in the scene */

/** Gaussians of a job; one takes some milliseconds. */
const CHUNK = 8192;
/** Scenes with fewer Gaussians get no helpers: starting them would take longer than they save. */
const WORTH = 100_000;
const HELPERS = 3;
/** Jobs that a helper has at once, so that it never waits for the next one. */
const AHEAD = 2;

/**
 * Computes each chunk when a stage of its LOD level has arrived, and again for a later stage.
 *
 * No result depends on the helpers: this thread also computes chunks that helpers have not finished,
 * and the first result counts.
 */
export class WorkerPool {
  /** Results since the caller last emptied this list. @type {[from: number, PackedRows][]} */
  results = [];
  /** @type {Chunk[]} */
  #chunks = [];
  /** The requested stage of each level. */
  #stages;
  /** @type {StreamDecoder | null} */
  #codes = null;
  /** @type {GaussianDecoder | null} */
  #decoder = null;
  /** @type {Helper[]} */
  #helpers = [];
  #count; // Gaussians
  #output = /** @type {PackedRows | null} */ (null);
  /** By chunk: the stage last assigned to a thread, and the stage of the last result. */
  #assigned;
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

  /** @param {number[]} levels Gaussians of each LOD level */
  constructor(levels) {
    // `finish` reports an error; without this it would also be an unhandled rejection
    this.#end.catch(() => {});
    let count = 0;
    for (const [level, size] of levels.entries()) {
      for (let from = 0; from < size; from += CHUNK) {
        this.#chunks.push({ level, from, to: Math.min(from + CHUNK, size), first: count + from });
      }
      count += size;
    }
    this.#stages = new Uint8Array(levels.length);
    this.#assigned = new Uint8Array(this.#chunks.length);
    this.#done = this.#assigned.slice();
    this.#count = count;
  }

  /** Arrays for all Gaussians, which results are written to; null: results are collected. @param {PackedRows | null} output */
  set output(output) {
    this.#output = output;
    if (output === null) return;
    for (const [from, packed] of this.results.splice(0)) {
      write(packed, partOf(output, this.#count, from, from + packed.shapes.length / 4));
    }
  }

  /** Start helpers if the scene is large enough. Call `start` first. */
  spawn() {
    const { decoderInputs } = /** @type {StreamDecoder} */ (this.#codes);
    const cores = this.#count < WORTH ? 1 : navigator.hardwareConcurrency;
    for (let i = 1; i < Math.min(cores, HELPERS + 1); i++) this.#spawn(decoderInputs);
  }

  /** @param {DecoderInputs} decoderInputs */
  #spawn(decoderInputs) {
    try {
      const worker = startWorker(self.location.href);
      worker.postMessage({ decoderInputs });
      const helper = { worker, jobs: 0 };
      worker.onmessage = ({ data }) => {
        helper.jobs--;
        this.#receive(data);
        this.#send(helper);
      };
      worker.onerror = (event) => event.preventDefault();
      this.#helpers.push(helper);
    } catch {
      // some browsers cannot start workers from workers
    }
  }

  /** Call once the positions of the first level are decoded. @param {StreamDecoder} codes @returns {GaussianDecoder} of this thread */
  start(codes) {
    this.#codes = codes;
    return (this.#decoder = new GaussianDecoder(codes.decoderInputs));
  }

  /** Compute a stage of a level, unless it was requested before. @param {number} level @param {number} stage */
  advance(level, stage) {
    if (stage <= this.#stages[level]) return;
    this.#stages[level] = stage;
    for (const helper of this.#helpers) this.#send(helper);
    this.#run().catch(this.#reject);
  }

  /** Wait until everything requested is done. */
  finish() {
    this.#ending = true;
    this.#check();
    return this.#end;
  }

  /** End the helpers. */
  terminate() {
    for (const { worker } of this.#helpers) worker.terminate();
  }

  /** The first chunk that is not assigned; -1 without one. */
  get #unassigned() {
    return this.#assigned.findIndex((stage, chunk) => stage < this.#requested(chunk));
  }

  /** The first unassigned chunk, or else one that a helper has not finished. */
  get #next() {
    const unassigned = this.#unassigned;
    return unassigned < 0 ? this.#done.findIndex((stage, chunk) => stage < this.#requested(chunk)) : unassigned;
  }

  /** The requested stage of a chunk. @param {number} chunk */
  #requested(chunk) {
    return this.#stages[this.#chunks[chunk].level];
  }

  /** @param {number} chunk @param {"slice" | "subarray"} how */
  #rows(chunk, how) {
    const { levels } = /** @type {StreamDecoder} */ (this.#codes);
    const { level, from, to } = this.#chunks[chunk];
    return levels[level].rows(from, to, how);
  }

  /** The part of the output that belongs to a chunk. @param {number} chunk @returns {PackedRows | undefined} */
  #outputOf(chunk) {
    const { first, from, to } = this.#chunks[chunk];
    return this.#output ? partOf(this.#output, this.#count, first, first + to - from) : undefined;
  }

  /** Send jobs to a helper. @param {Helper} helper */
  #send(helper) {
    for (let chunk; helper.jobs < AHEAD && (chunk = this.#unassigned) >= 0; helper.jobs++) {
      const stage = (this.#assigned[chunk] = this.#requested(chunk));
      const rows = this.#rows(chunk, "slice");
      const transfer = [rows.positions, ...Object.values(rows.columns).flat()].map(({ buffer }) => buffer);
      helper.worker.postMessage({ rows, chunk, stage }, { transfer });
    }
  }

  async #run() {
    if (this.#running) return;
    this.#running = true;
    for (let chunk; (chunk = this.#next) >= 0 && this.#decoder; ) {
      const stage = (this.#assigned[chunk] = this.#requested(chunk));
      const packed = packRows(this.#decoder, this.#rows(chunk, "subarray"), this.#outputOf(chunk));
      this.#receive({ chunk, stage, packed });
      await yieldToMessages();
    }
    this.#running = false;
  }

  /** @param {Result} result */
  #receive({ chunk, stage, packed }) {
    if (stage <= this.#done[chunk]) return;
    this.#done[chunk] = stage;
    const place = this.#outputOf(chunk);
    if (place === undefined) this.results.push([this.#chunks[chunk].first, packed]);
    else if (place.shapes.buffer !== packed.shapes.buffer) write(packed, place);
    this.#check();
  }

  /** True if every Gaussian of the first level has a result. */
  get firstLevelReady() {
    return this.#chunks.every(({ level }, chunk) => level > 0 || this.#done[chunk] > 0);
  }

  /** The number of levels, from the first one on, whose Gaussians all have colours. */
  get levels() {
    const missing = this.#done.findIndex((stage) => stage < COLORED);
    return missing < 0 ? this.#stages.length : this.#chunks[missing].level;
  }

  #check() {
    if (this.#ending && this.#next < 0) this.#resolve();
  }
}

/**
 * The views of some rows of a scene.
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
