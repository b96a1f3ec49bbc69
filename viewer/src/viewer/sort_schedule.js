/** Decides when a sorted scene needs a new order. */

import { dot } from "./vector.js";

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("./vector.js").Vector} Vector */

const SAME_SIDE = Math.cos((0.5 * Math.PI) / 180); // an order is used for all directions within this angle

export class SortSchedule {
  /** The thread that sorts; "": the scene is not sorted. @type {"" | "worker" | "page"} */
  by = "";

  #pending = false; // a request to the worker
  /** Viewing direction of the last order. @type {Vector | null} */
  #direction = null;

  /** Start with another scene. @param {"" | "worker" | "page"} by */
  reset(by) {
    this.by = by;
    this.#pending = false;
  }

  /** The scene has changed. */
  invalidate() {
    this.#direction = null;
  }

  /** True while the worker sorts. */
  get pending() {
    return this.#pending;
  }

  /** The worker has sent an order. */
  received() {
    this.#pending = false;
  }

  /** The viewing direction to sort for now; null if no order is needed. @param {Camera} camera */
  neededDirection({ viewmat }) {
    const forward = /** @type {Vector} */ ([viewmat[8], viewmat[9], viewmat[10]]);
    const current = this.#direction !== null && dot(forward, this.#direction) >= SAME_SIDE;
    if (!this.by || this.#pending || current) return null;
    this.#pending = this.by === "worker";
    return (this.#direction = forward);
  }
}
