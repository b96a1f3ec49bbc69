/**
 * HTML of the page over a scene: children of `<mobile-gs>` with `slot="annotation"` follow the points that their
 * `data-at="x y z"` names.
 *
 * A child whose point is outside of the picture gets the attribute `data-outside`. It is hidden then, unless a style
 * of the page shows it: it lies at the nearest edge.
 */

import { projected } from "./annotations.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./viewer.js").Viewer} Viewer */

/** Moves the children of a slot with each frame. */
export class Slotted {
  #slot;
  #viewer;
  /** Texts of `data-at` that have been reported. @type {Set<string>} */
  #reported = new Set();

  /** @param {HTMLElement} element @param {HTMLSlotElement} slot @param {() => Viewer | null} viewer */
  constructor(element, slot, viewer) {
    this.#slot = slot;
    this.#viewer = viewer;
    const move = () => this.#move();
    element.addEventListener("frame", move);
    slot.addEventListener("slotchange", move);
    new MutationObserver(move).observe(element, { attributes: true, attributeFilter: ["data-at"], subtree: true });
    move();
  }

  #move() {
    const viewer = this.#viewer();
    const { clientWidth: width, clientHeight: height } = this.#slot;
    const camera = viewer?.count && width && height ? viewer.camera(width, height) : null;
    for (const child of /** @type {HTMLElement[]} */ (this.#slot.assignedElements())) {
      const at = this.#point(child.dataset.at ?? "");
      const place = camera && at && projected(camera, at);
      child.toggleAttribute("data-outside", !place?.inside);
      if (!place) continue;
      child.style.setProperty("--annotation-x", `${place.x}px`);
      child.style.setProperty("--annotation-y", `${place.y}px`);
    }
  }

  /** @param {string} text @returns {Vector | null} */
  #point(text) {
    const numbers = text.trim().split(/[\s,]+/).map(Number);
    if (numbers.length === 3 && text.trim() && numbers.every(Number.isFinite)) return /** @type {Vector} */ (numbers);
    if (!this.#reported.has(text)) {
      console.warn(`mobile-gs: data-at="${text}" of an annotation is not a point: write three numbers, as "0 1.5 -2"`);
    }
    this.#reported.add(text);
    return null;
  }
}
