/** Numbered dots over a scene, whose texts open at a tap; and the start of a file's camera path. */

import { continued, flyTo, parsedPath, play } from "./camera_path.js";
import { visible } from "./localize.js";
import { adoptStyle } from "./style.js";
import { dot, length, minus, plus } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{at: Vector, text: string, eye?: Vector}} Annotation */

const STILL = "(prefers-reduced-motion: reduce)";
const STYLE = `
.annotations { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.annotations button { position: absolute; left: 0; top: 0; width: 28px; height: 28px; min-width: 0; min-height: 0; margin: -14px; padding: 0;
  border: 2px solid #fff; border-radius: 50%; background: #10131acc; color: #fff; font: 600 13px/1 system-ui, sans-serif;
  pointer-events: auto; cursor: pointer; }
.annotations button::after { content: ""; position: absolute; inset: -10px; border-radius: 50%; }
.annotations button[aria-expanded=true] { background: #fff; color: #10131a; }
.annotations button:focus-visible { outline: 3px solid #6cb6ff; outline-offset: 2px; }
.annotations p { position: absolute; left: 0; top: 0; box-sizing: border-box; width: max-content; max-width: min(300px, 80%);
  max-height: 45%; overflow: auto; margin: 0; padding: 10px 14px; border-radius: 10px; background: #10131aee; color: #f3f4f6;
  font: 15px/1.45 system-ui, sans-serif; white-space: pre-line; overflow-wrap: anywhere; pointer-events: auto; }`;

/** The annotations that a file's notes hold; those of another form are left out. @param {Record<string, unknown>} notes */
export function parsedAnnotations(notes) {
  const point = (/** @type {any} */ value) =>
    Array.isArray(value) && value.length === 3 && value.every((number) => Number.isFinite(number));
  return continued(notes, "annotations").flatMap((text) => {
    let found;
    try {
      found = JSON.parse(text);
    } catch {
      found = null;
    }
    const list = /** @type {Annotation[]} */ (Array.isArray(found) ? found : []);
    return list.filter((one) => point(one?.at) && typeof one.text === "string" && (!one.eye || point(one.eye)));
  });
}

/**
 * Show what the notes of a scene hold, or the element's attributes `annotations` and `path`, after it has loaded.
 *
 * @param {HTMLElement} element whose frames move the dots
 * @param {ShadowRoot} root for the dots
 * @param {Viewer} viewer
 * @param {boolean} autoplay whether the camera follows the file's path
 */
export function showNotes(element, root, viewer, autoplay) {
  const notesOf = (/** @type {string} */ name) => {
    const given = element.getAttribute(name);
    return given === null ? viewer.notes : { [name]: given };
  };
  root.querySelector(".annotations")?.remove();
  const annotations = parsedAnnotations(notesOf("annotations"));
  if (annotations.length) new Dots(element, root, viewer, annotations);
  const path = parsedPath(notesOf("path"));
  if (autoplay && path.length > 1 && !matchMedia(STILL).matches) play(viewer, element, path);
}

/**
 * Where a camera sees a point: pixels, and whether that is inside the picture. Otherwise it is the place of the
 * picture's edge that is nearest.
 *
 * @param {import("../render/types.js").Camera} camera
 * @param {Vector} at
 */
export function projected({ viewmat: m, fx, fy, cx, cy, width, height, near }, at) {
  const [x, y, z] = [0, 4, 8].map((row) => dot([m[row], m[row + 1], m[row + 2]], at) + m[row + 3]);
  const [left, top] = [(fx * x) / z + cx, (fy * y) / z + cy];
  if (z > near && left > 0 && left < width && top > 0 && top < height) return { x: left, y: top, inside: true };
  // along the line from the centre; a point behind the camera is on the side to which a turn brings it into sight
  const [across, down] = [fx * x, fy * y];
  const share = 1 / Math.max((2 * Math.abs(across)) / width, (2 * Math.abs(down)) / height, Number.MIN_VALUE);
  return { x: cx + share * across, y: cy + share * down, inside: false };
}

/** The dots of a scene, while they are in the document. */
export class Dots {
  #layer = document.createElement("div");
  #bubble = document.createElement("p");
  #viewer;
  #input;
  /** @type {{button: HTMLButtonElement, annotation: Annotation}[]} */
  #dots;
  /** The open one, or -1. */
  #open = -1;

  /** @param {HTMLElement} element @param {ShadowRoot} root @param {Viewer} viewer @param {Annotation[]} annotations */
  constructor(element, root, viewer, annotations) {
    this.#viewer = viewer;
    this.#input = element;
    const layer = this.#layer;
    layer.className = "annotations";
    adoptStyle(root, STYLE);
    this.#bubble.hidden = true;
    this.#bubble.id = "annotation";
    this.#bubble.setAttribute("role", "status");
    this.#dots = annotations.map((annotation, i) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = String(i + 1);
      button.setAttribute("aria-label", `${i + 1}: ${visible(annotation.text.slice(0, 80))}`);
      button.setAttribute("aria-expanded", "false");
      button.addEventListener("click", () => this.#show(i === this.#open ? -1 : i));
      return { button, annotation };
    });
    layer.append(...this.#dots.map(({ button }) => button), this.#bubble);
    layer.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.#show(-1);
      if (event.key === "Enter" || event.key === " ") event.stopPropagation(); // keys of the viewer
    });
    root.querySelector("canvas:last-of-type")?.after(layer);
    const move = () => {
      if (layer.isConnected) this.#move();
      else element.removeEventListener("frame", move);
    };
    element.addEventListener("frame", move);
    move();
    viewer.redraw();
  }

  /** Open an annotation and fly there; -1 closes it. @param {number} index */
  #show(index) {
    this.#open = index;
    this.#dots.forEach(({ button }, i) => button.setAttribute("aria-expanded", String(i === index)));
    this.#bubble.hidden = index < 0;
    if (index < 0) return;
    const { at, text, eye } = this.#dots[index].annotation;
    this.#bubble.textContent = visible(text);
    const { pose } = this.#viewer;
    const from = eye ?? plus(pose.eye, minus(at, pose.target), 1); // in the same direction
    if (length(minus(at, from)) > 0) flyTo(this.#viewer, this.#input, { eye: from, target: at });
    this.#move();
  }

  /** Put the dots where the camera sees their places. */
  #move() {
    const { clientWidth: width, clientHeight: height } = this.#layer;
    if (!width || !height) return;
    const camera = this.#viewer.camera(width, height);
    this.#dots.forEach(({ button, annotation: { at } }, i) => {
      const { x: left, y: top, inside: seen } = projected(camera, at);
      button.style.visibility = seen ? "" : "hidden";
      if (seen) button.style.transform = `translate(${left}px, ${top}px)`;
      if (i !== this.#open) return;
      this.#bubble.hidden = !seen;
      const { offsetWidth, offsetHeight } = this.#bubble;
      const across = Math.min(Math.max(left - offsetWidth / 2, 8), Math.max(width - offsetWidth - 8, 8));
      const below = top + 24 + offsetHeight < height ? top + 24 : Math.max(top - 24 - offsetHeight, 8);
      this.#bubble.style.transform = `translate(${across}px, ${below}px)`;
    });
  }
}
