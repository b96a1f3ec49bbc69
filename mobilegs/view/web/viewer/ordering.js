/** When a scene that is drawn in an order needs another one. */

import { dot } from "./vector.js";

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("./vector.js").Vector} Vector */

const SAME_SIDE = Math.cos((0.5 * Math.PI) / 180); // an order serves all directions as near as that

export class Ordering {
  /** Who makes an order, if the scene needs one. @type {"" | "worker" | "page"} */
  by = "";

  #waiting = false; // for the worker
  /** Direction of looking that the order is for. @type {Vector | null} */
  #served = null;

  /** For another scene. @param {"" | "worker" | "page"} by */
  begin(by) {
    this.by = by;
    this.#waiting = false;
  }

  /** There is more to be ordered. */
  renew() {
    this.#served = null;
  }

  /** The worker has made one. */
  arrived() {
    this.#waiting = false;
  }

  /** The direction of looking that an order is to be made for now; null for none. @param {Camera} camera */
  needed({ viewmat }) {
    const forward = /** @type {Vector} */ ([viewmat[8], viewmat[9], viewmat[10]]);
    const serves = this.#served !== null && dot(forward, this.#served) >= SAME_SIDE;
    if (!this.by || this.#waiting || serves) return null;
    this.#waiting = this.by === "worker";
    return (this.#served = forward);
  }
}
