/** The handle between two scenes, the first on the left, the second on the right. */

import { filled } from "./localize.js";

const STEP = 0.02; // share of the width per press of an arrow key
/** Movement by key, as a share of the width. */
const KEYS = new Map([
  ["ArrowLeft", -STEP],
  ["ArrowDown", -STEP],
  ["ArrowRight", STEP],
  ["ArrowUp", STEP],
  ["PageDown", -5 * STEP],
  ["PageUp", 5 * STEP],
  ["Home", -1],
  ["End", 1],
]);

/** A slider that clips the canvas of the second scene, which lies above the first. */
export class Split {
  /** Share of the width that shows the first scene. */
  share = 0.5;

  #handle;
  #canvas;
  #names = ["", ""];

  /**
   * @param {HTMLElement} handle with an element for each name
   * @param {HTMLCanvasElement} canvas
   */
  constructor(handle, canvas) {
    this.#handle = handle;
    this.#canvas = canvas;
    handle.onpointerdown = ({ pointerId }) => handle.setPointerCapture(pointerId);
    handle.onpointermove = ({ pointerId, clientX }) => {
      if (!handle.hasPointerCapture(pointerId)) return;
      const { left, width } = canvas.getBoundingClientRect();
      this.#place((clientX - left) / width);
    };
    handle.onkeydown = (event) => {
      const step = KEYS.get(event.key);
      if (step === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.#place(this.share + step);
    };
  }

  /** Show the handle and the second scene. @param {[string, string]} names of both @param {string} phrase says where they are */
  show(names, phrase) {
    this.#names = names;
    this.#handle.querySelectorAll("span").forEach((place, side) => (place.textContent = names[side]));
    this.#handle.setAttribute("aria-label", filled(phrase, ...names));
    this.#handle.hidden = false;
    this.#canvas.classList.add("drawn");
    this.#place(this.share);
  }

  /** @param {number} share */
  #place(share) {
    this.share = Math.min(Math.max(share, 0), 1);
    const percent = Math.round(100 * this.share);
    this.#canvas.style.clipPath = `inset(0 0 0 ${100 * this.share}%)`;
    this.#handle.style.left = `${100 * this.share}%`;
    this.#handle.setAttribute("aria-valuenow", String(percent));
    const [first, other] = this.#names;
    this.#handle.setAttribute("aria-valuetext", `${percent} % ${first}, ${100 - percent} % ${other}`);
  }
}
