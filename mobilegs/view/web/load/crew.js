/** Gaussians of a `.mgs` made ready for the GPU, by this thread and some helpers. */

import { RowDecoder } from "../mgs/rows.js";
import { packRows } from "../render/pack.js";

/** @typedef {import("../mgs/decode.js").Decoder} Decoder */
/** @typedef {import("../render/pack.js").PackedRows} PackedRows */
/** @typedef {{chunk: number, stage: number, packed: PackedRows}} Brought what a helper sends back */
/** @typedef {{worker: Worker, errands: number}} Helper with what it has not brought yet */

/** Gaussians at a time: milliseconds. */
const CHUNK = 8192;
/** Gaussians from which on helpers save more time than it takes to start them. */
const WORTH = 100_000;
const HELPERS = 3;
/** Errands of a helper, so that it need not wait for the next one. */
const AHEAD = 2;

/**
 * Computes each chunk of Gaussians as soon as a stage of the file is there, and again for a later
 * one. Nothing depends on the helpers: what they were given and have not brought is done here in the
 * end, and whatever comes first counts.
 */
export class Crew {
  /** What has been done and nobody has taken away yet. @type {[from: number, PackedRows][]} */
  taken = [];

  #count;
  /** @type {Decoder | null} */
  #codes = null;
  /** @type {RowDecoder | null} */
  #own = null;
  /** @type {Helper[]} */
  #helpers = [];
  /** By chunk, the stage that somebody was asked for, and the one that there is. */
  #given;
  #done;
  #stage = 0;
  #running = false;
  #last = 0;
  #resolve = () => {};
  #reject = () => {};
  /** @type {Promise<void>} */
  #end = new Promise((resolve, reject) => {
    this.#resolve = resolve;
    this.#reject = reject;
  });

  /** @param {number} count Gaussians of the scene */
  constructor(count) {
    this.#count = count;
    // what goes wrong is told to who waits for the end
    this.#end.catch(() => {});
    this.#given = new Uint8Array(Math.ceil(count / CHUNK));
    this.#done = this.#given.slice();
    const cores = count < WORTH ? 1 : navigator.hardwareConcurrency;
    for (let i = 1; i < Math.min(cores, HELPERS + 1); i++) this.#hire();
  }

  #hire() {
    try {
      const worker = new Worker(self.location.href, { type: "module" });
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

  /** Positions are there. @param {Decoder} codes @returns {RowDecoder} of this thread */
  begin(codes) {
    const { recipe } = codes;
    for (const { worker } of this.#helpers) worker.postMessage({ recipe });
    this.#codes = codes;
    return (this.#own = new RowDecoder(recipe));
  }

  /** Computes what a stage brings, if there is one that was not asked for yet. @param {number} stage */
  advance(stage) {
    if (stage <= this.#stage) return;
    this.#stage = stage;
    for (const helper of this.#helpers) this.#send(helper);
    this.#run().catch(this.#reject);
  }

  /** Waits until all of the last stage is done. @param {number} stage */
  finish(stage) {
    this.#last = stage;
    this.advance(stage);
    this.#check();
    return this.#end;
  }

  /** Sends the helpers home. */
  dismiss() {
    for (const { worker } of this.#helpers) worker.terminate();
  }

  /** The first chunk that nobody was given; -1 if there is none. */
  get #free() {
    return this.#given.findIndex((stage) => stage < this.#stage);
  }

  /** That, or else one that a helper still has. */
  get #next() {
    const free = this.#free;
    return free < 0 ? this.#done.findIndex((stage) => stage < this.#stage) : free;
  }

  /** @param {number} chunk */
  #rows(chunk) {
    const codes = /** @type {Decoder} */ (this.#codes);
    return codes.rows(chunk * CHUNK, Math.min((chunk + 1) * CHUNK, this.#count));
  }

  /** Gives a helper something to do. @param {Helper} helper */
  #send(helper) {
    for (let chunk; helper.errands < AHEAD && (chunk = this.#free) >= 0; helper.errands++) {
      const stage = (this.#given[chunk] = this.#stage);
      helper.worker.postMessage({ rows: this.#rows(chunk), chunk, stage });
    }
  }

  async #run() {
    if (this.#running) return;
    this.#running = true;
    for (let chunk; (chunk = this.#next) >= 0 && this.#own; ) {
      const stage = (this.#given[chunk] = this.#stage);
      this.#take({ chunk, stage, packed: packRows(this.#own.decode(this.#rows(chunk))) });
      await turn();
    }
    this.#running = false;
  }

  /** @param {Brought} brought */
  #take({ chunk, stage, packed }) {
    if (stage <= this.#done[chunk]) return;
    this.#done[chunk] = stage;
    this.taken.push([chunk * CHUNK, packed]);
    this.#check();
  }

  /** Whether all of the last stage is there. */
  get complete() {
    return this.#last > 0 && this.#done.every((done) => done === this.#last);
  }

  #check() {
    if (this.complete) this.#resolve();
  }
}

/** Lets messages through. */
export function turn() {
  const { port1, port2 } = new MessageChannel();
  return new Promise((resolve) => {
    port1.onmessage = () => {
      port1.close();
      resolve(null);
    };
    port2.postMessage(null);
  });
}
