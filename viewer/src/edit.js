/**
 * The editor: tools beside the viewer, on the page of `mobilegs edit`.
 *
 * It hides what is removed, and sends its settings and a bit per Gaussian to the server, which writes a new
 * file. Nothing is sent before Save.
 */

import { Marks } from "./edit/marks.js";
import { annotationTool, pathTool, startTool, textTool, upTool } from "./edit/note_tools.js";
import { STYLE, button, hint, make, row } from "./edit/panel.js";
import { boxTool, camerasTool, floorTool, lassoTool, sphereTool } from "./edit/remove_tools.js";
import { History } from "./edit/selection.js";

/** @typedef {import("./element.js").MobileGs} MobileGs */
/** @typedef {import("./viewer/viewer.js").Viewer} Viewer */
/** @typedef {import("./viewer/vector.js").Vector} Vector */
/** @typedef {import("./edit/selection.js").Mask} Mask */
/**
 * @typedef {object} Settings what differs from the file
 * @property {string} [title]
 * @property {string} [credit]
 * @property {Vector} [up]
 * @property {number[]} [start] eye, target, tangents of half the width and height
 * @property {number[]} [start_portrait]
 * @property {number[]} [floor] normal and offset
 * @property {boolean} [free] no limits of the camera
 * @property {import("./viewer/annotations.js").Annotation[]} [annotations]
 * @property {number[][]} [path] eye and target of key poses
 */

export class Editor {
  /** @type {Settings} */
  settings = {};
  /** Ends the use of a tool that waits for clicks or strokes. */
  tool = () => {};
  marks;
  history;
  #said = hint("");
  #count = hint("");
  #undo = button("Undo", () => this.#step("undo"));
  #redo = button("Redo", () => this.#step("redo"));
  #save = button("Save as a new file", () => void this.save());
  /** @type {(() => Mask) | null} */
  #previewed = null;
  #requested = 0;
  #dirty = false;

  /** @param {MobileGs} element @param {Viewer} viewer @param {Record<string, unknown>} notes of the file */
  constructor(element, viewer, notes) {
    this.element = element;
    this.viewer = viewer;
    this.notes = notes;
    this.history = new History(viewer.count);
    this.marks = new Marks(() => viewer);
    this.#save.className = "main";
    this.#said.setAttribute("role", "status");
    const save = make("div", { className: "save" }, this.#count, row(this.#undo, this.#redo), this.#said, this.#save);
    const tools = [
      textTool, startTool, upTool, boxTool, sphereTool, lassoTool, floorTool, camerasTool, annotationTool, pathTool,
    ].map((tool) => tool(this)); // prettier-ignore
    const panel = make("aside", { id: "edit", ariaLabel: "Editor" }, make("h1", { textContent: document.title }), ...tools, save);
    document.body.append(make("style", { textContent: STYLE }), this.marks.element, panel);
    element.addEventListener("frame", () => this.marks.draw());
    addEventListener("keydown", (event) => this.#key(event));
    addEventListener("beforeunload", (event) => this.#dirty && event.preventDefault());
    this.#show();
  }

  /** Something has changed that can be saved. @param {string} [sentence] */
  changed(sentence = "") {
    this.#dirty = true;
    this.say(sentence);
    this.#show();
  }

  /** @param {string} sentence */
  say(sentence) {
    this.#said.textContent = sentence;
  }

  /** Remove Gaussians; returns how many. @param {Mask} mask */
  remove(mask) {
    const removed = this.history.remove(mask);
    if (this.history.removed === this.viewer.count) {
      this.history.undo();
      this.say("This would remove everything.");
      return 0;
    }
    if (removed) this.changed(`${removed.toLocaleString("en")} Gaussians removed.`);
    this.viewer.hide(this.history.hidden);
    return removed;
  }

  /** Show what a tool would remove; null for nothing. @param {(() => Mask) | null} mask */
  preview(mask) {
    this.#previewed = mask;
    this.#requested ||= requestAnimationFrame(() => {
      this.#requested = 0;
      const more = this.#previewed?.();
      this.viewer.hide(more ? this.history.with(more) : this.history.hidden);
    });
  }

  /** Put the tool away. */
  put() {
    this.tool();
    this.tool = () => {};
    this.marks.clear();
    this.preview(null);
  }

  /** Wait for a click on the scene. @param {(point: Vector) => void} act */
  pick(act) {
    this.tool();
    this.say("Click a point of the scene.");
    this.tool = this.marks.click((x, y) => {
      const point = this.viewer.pointAt(x, y);
      if (!point) {
        this.say("There is nothing under this point: click another one.");
        return;
      }
      this.tool();
      this.tool = () => {};
      this.say("");
      act(point);
    });
  }

  /** Let a direction point up. @param {Vector} up length 1 */
  setUp(up) {
    this.settings.up = up;
    const pose = this.viewer.pose.copy();
    pose.up = up;
    this.viewer.place(pose);
    this.changed("The upward direction is set.");
  }

  /** Send everything to the server, which writes a new file. */
  async save() {
    const { settings, history } = this;
    const annotations = settings.annotations?.filter(({ text }) => text.trim());
    const posted = {
      ...settings,
      ...(annotations ? { annotations } : {}),
      ...(history.removed ? { removed: history.bits } : {}),
    };
    this.#save.disabled = true;
    this.say("Saving ...");
    try {
      const body = JSON.stringify(posted);
      const answer = await fetch("save", { method: "POST", headers: { "Content-Type": "application/json" }, body });
      const found = await answer.json();
      if (!answer.ok) throw new Error(found.error);
      this.#dirty = false;
      this.say(`Saved as ${found.file}. ${found.lines.join(". ")}.`);
    } catch (error) {
      this.say(`Not saved: ${/** @type {Error} */ (error).message}`);
    }
    this.#show();
  }

  /** @param {"undo" | "redo"} way */
  #step(way) {
    this.history[way]();
    this.changed();
    this.preview(this.#previewed);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const typing = /** @type {Element} */ (event.target).matches("input:not([type=range]), textarea");
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || typing) return;
    this.#step(event.shiftKey ? "redo" : "undo");
    event.preventDefault();
  }

  #show() {
    const { removed, canUndo, canRedo } = this.history;
    const told = (/** @type {number} */ value) => value.toLocaleString("en");
    this.#count.textContent = `${told(this.viewer.count - removed)} of ${told(this.viewer.count)} Gaussians stay.`;
    this.#undo.disabled = !canUndo;
    this.#redo.disabled = !canRedo;
    this.#save.disabled = !this.#dirty;
  }
}

/** Start when the scene is complete. */
async function start() {
  const element = /** @type {MobileGs} */ (document.querySelector("mobile-gs"));
  if (element.dataset.state !== "loaded") {
    await new Promise((loaded) => element.addEventListener("load", loaded, { once: true }));
  }
  const { notes, count } = await (await fetch("notes")).json();
  const { viewer } = element;
  if (!viewer) return;
  if (viewer.count !== count) {
    element.failed(0, "the viewer does not show all of this scene: it cannot be edited here");
    return;
  }
  Object.assign(element, { editor: new Editor(element, viewer, notes) });
}

void start();
