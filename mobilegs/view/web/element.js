/**
 * `<mobile-gs src="scene.mgs">`: a scene in any page.
 *
 * Attributes: `src`, address of a .mgs file; `renderer`, auto, webgpu or webgl; `scale`, share of the
 * screen's pixels to draw instead of as many as the device can; `noui` hides the buttons; `poster`, a
 * picture to show until there is something better. While a scene arrives `data-state` is `loading`,
 * then `loaded` or `failed`.
 */

import { STYLE } from "./viewer/style.js";
import { Viewer } from "./viewer/viewer.js";

/** @typedef {import("./render/choose.js").Choice} Choice */
/** @typedef {import("./viewer/viewer.js").Stats} Stats */

const HELP = [
  ["Drag", "turn around the scene"],
  ["Two fingers, right button or Shift", "move sideways"],
  ["Pinch or wheel", "come nearer, go away"],
  ["Double tap", "look at what is there"],
  ["Arrows", "turn"],
  ["W A S D Q E", "fly; with Shift faster"],
  ["M", "orbit, or look around from where you are"],
  ["V", "next of the cameras the scene was taken with"],
  ["R", "back to the beginning"],
  ["F", "full screen"],
  ["P", "save a picture"],
  ["I", "frame rate and device"],
  ["H", "this help"],
];
const TEMPLATE = `
<style>${STYLE}</style>
<canvas tabindex="0" role="application" aria-label="3D scene. Press H for the keys."></canvas>
<div class="bar" role="progressbar" aria-label="loading"><div></div></div>
<div class="panel stats" hidden></div>
<div class="buttons">
  <button data-act="reset" title="Back to the beginning (R)">Reset</button>
  <button data-act="mode" title="Orbit or look around (M)" aria-pressed="false">Orbit</button>
  <button data-act="full" title="Full screen (F)">Full screen</button>
  <button data-act="help" title="Help (H)" aria-expanded="false">?</button>
</div>
<div class="panel help" role="dialog" aria-label="Help" hidden><h2>Ways to move</h2><dl>
${HELP.map(([what, does]) => `<dt>${what}</dt><dd>${does}</dd>`).join("")}
</dl><button data-act="close">Close</button></div>
<div class="panel report" role="dialog" aria-label="Measured" hidden>
  <h2></h2>
  <textarea readonly rows="14" cols="44" aria-label="the figures as JSON"></textarea><br />
  <button data-act="copy">Copy</button> <button data-act="share">Share</button>
  <button data-act="close">Close</button>
</div>
<div class="panel message" hidden><p role="alert"></p><button data-act="close">Close</button></div>
<div class="panel drop" hidden>Drop a scene to open it</div>`;
const KEYS = new Map([
  ["KeyR", "reset"],
  ["KeyM", "mode"],
  ["KeyF", "full"],
  ["KeyH", "help"],
  ["KeyI", "stats"],
  ["KeyP", "picture"],
  ["KeyV", "view"],
]);

export class MobileGs extends HTMLElement {
  static observedAttributes = ["src"];

  /** @type {Viewer | null} */
  viewer = null;
  #root;
  /** Frame times of the last second or so, milliseconds. @type {number[]} */
  #times = [];
  #view = 0;
  #ready = Promise.resolve(false);

  constructor() {
    super();
    this.#root = this.attachShadow({ mode: "open", delegatesFocus: true });
    this.#root.innerHTML = TEMPLATE;
    for (const button of this.#root.querySelectorAll("button")) {
      button.addEventListener("click", () => this.act(button.dataset.act ?? ""));
    }
    this.#root.addEventListener("keydown", (event) => {
      const { code, ctrlKey, metaKey, altKey, repeat, target } = /** @type {KeyboardEvent} */ (event);
      const act = KEYS.get(code);
      const typing = target instanceof HTMLTextAreaElement;
      if (act && !ctrlKey && !metaKey && !altKey && !repeat && !typing) this.act(act);
      if (code === "Escape") this.act("close");
    });
    this.addEventListener("dragover", (event) => {
      event.preventDefault();
      this.#part("drop").hidden = false;
    });
    this.addEventListener("dragleave", () => (this.#part("drop").hidden = true));
    this.addEventListener("drop", (event) => {
      event.preventDefault();
      this.#part("drop").hidden = true;
      const file = event.dataTransfer?.files[0];
      if (file) this.open(file);
    });
  }

  connectedCallback() {
    // a script that comes with the element may still want to set attributes
    queueMicrotask(() => this.isConnected && !this.viewer && this.#begin());
  }

  #begin() {
    this.#part("buttons").hidden = this.hasAttribute("noui");
    const canvas = /** @type {HTMLCanvasElement} */ (this.#root.querySelector("canvas"));
    const scale = Number(this.getAttribute("scale"));
    this.viewer = new Viewer(canvas, this, { scale: scale > 0 && scale <= 1 ? scale : null });
    const choice = this.getAttribute("renderer") ?? "auto";
    this.#ready = this.viewer.begin(/** @type {Choice} */ (choice));
    const poster = this.getAttribute("poster");
    if (poster) {
      const { href } = new URL(poster, document.baseURI);
      this.style.background = `center / cover no-repeat url("${href}")`;
    }
    const source = this.getAttribute("src");
    if (source) this.open(source);
  }

  disconnectedCallback() {
    this.viewer?.destroy();
    this.viewer = null;
    // a canvas that was drawn to in one way cannot be drawn to in another
    const canvas = this.#root.querySelector("canvas");
    canvas?.classList.remove("drawn");
    canvas?.replaceWith(canvas.cloneNode());
    this.#showMode("orbit");
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (name === "src" && this.viewer && value && value !== before) this.open(value);
  }

  /** Opens a scene: an address, or a file of the visitor's. @param {string | Blob} source */
  async open(source) {
    const viewer = this.viewer;
    if (!(await this.#ready) || viewer === null || viewer !== this.viewer) return;
    this.#part("message").hidden = true;
    this.dataset.state = "loading";
    this.progress(NaN);
    try {
      const request =
        source instanceof Blob ? { file: source } : { url: new URL(source, document.baseURI).href };
      viewer.load(request);
    } catch (error) {
      const why = error instanceof Error ? error.message : String(error);
      this.failed(`the scene cannot be opened: ${why}`);
    }
  }

  /** Does what a button or key stands for. @param {string} what */
  act(what) {
    const viewer = this.viewer;
    if (!viewer) return;
    if (what === "reset") viewer.reset();
    else if (what === "view") viewer.reset(++this.#view);
    else if (what === "help") this.#toggle("help");
    else if (what === "stats") viewer.timed = this.#toggle("stats");
    else if (what === "picture") void this.#save();
    else if (what === "copy") void navigator.clipboard?.writeText(this.#report);
    else if (what === "share") void navigator.share?.({ text: this.#report }).catch(() => {});
    else if (what === "full") {
      if (document.fullscreenElement) void document.exitFullscreen();
      else void this.requestFullscreen?.().catch(() => {});
    } else if (what === "mode") {
      viewer.mode = viewer.mode === "orbit" ? "fly" : "orbit";
      this.#showMode(viewer.mode);
    } else if (what === "close") {
      for (const name of ["help", "report", "message"]) this.#toggle(name, false);
      this.focus({ preventScroll: true });
    }
    viewer.redraw();
  }

  /** @param {number} share of the file that has arrived */
  progress(share) {
    const bar = this.#part("bar");
    bar.hidden = false;
    const percent = Number.isFinite(share) ? Math.round(100 * share) : 0;
    bar.setAttribute("aria-valuenow", String(percent));
    /** @type {HTMLElement} */ (bar.firstElementChild).style.width = `${percent}%`;
  }

  /** @param {number} milliseconds */
  loaded(milliseconds) {
    this.#part("bar").hidden = true;
    this.#part("message").hidden = true;
    this.dataset.state = "loaded";
    this.dispatchEvent(new CustomEvent("load", { detail: { milliseconds } }));
  }

  /** @param {string} sentence */
  failed(sentence) {
    this.#part("bar").hidden = true;
    const message = this.#part("message");
    /** @type {HTMLElement} */ (message.querySelector("p")).textContent = sentence;
    message.hidden = false;
    this.dataset.state = "failed";
    this.dispatchEvent(new CustomEvent("error", { detail: { sentence } }));
  }

  /** Shows figures, to be copied or shared. @param {Record<string, unknown>} figures */
  report(figures) {
    const text = JSON.stringify(figures, null, 1);
    const panel = this.#part("report");
    /** @type {HTMLTextAreaElement} */ (panel.querySelector("textarea")).value = text;
    const { cold, steady } = /** @type {any} */ (figures);
    const words = `${cold.fps} frames/s cold, ${steady.fps} steady`;
    /** @type {HTMLElement} */ (panel.querySelector("h2")).textContent = words;
    panel.hidden = false;
    this.dispatchEvent(new CustomEvent("report", { detail: figures }));
  }

  /** @param {Stats} stats */
  drawn(stats) {
    this.#root.querySelector("canvas")?.classList.add("drawn");
    this.dispatchEvent(new CustomEvent("frame", { detail: stats }));
    const panel = this.#part("stats");
    if (panel.hidden) return;
    if (stats.milliseconds) this.#times = [...this.#times.slice(-29), stats.milliseconds];
    const mean = this.#times.reduce((sum, time) => sum + time, 0) / this.#times.length;
    const lines = [
      `${stats.renderer}, ${stats.width} x ${stats.height}`,
      `${stats.count.toLocaleString("en")} Gaussians`,
      this.#times.length ? `${(1000 / mean).toFixed(0)} frames/s, ${mean.toFixed(1)} ms` : "still",
      ...Object.entries(stats.passes ?? {}).map(([pass, time]) => `${pass} ${time.toFixed(2)} ms`),
    ];
    panel.textContent = lines.join("\n");
  }

  get #report() {
    const area = /** @type {HTMLTextAreaElement} */ (this.#root.querySelector("textarea"));
    area.select(); // where a page may not copy, its reader still can
    return area.value;
  }

  async #save() {
    const picture = await this.viewer?.screenshot();
    if (!picture) return;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(picture);
    link.download = "scene.png";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /** @param {string} name @param {boolean} [shown] @returns {boolean} whether it is shown now */
  #toggle(name, shown) {
    const part = this.#part(name);
    part.hidden = shown === undefined ? !part.hidden : !shown;
    this.#root.querySelector(`[data-act=${name}]`)?.setAttribute("aria-expanded", String(!part.hidden));
    return !part.hidden;
  }

  /** @param {"orbit" | "fly"} mode */
  #showMode(mode) {
    const button = this.#root.querySelector("[data-act=mode]");
    if (button) button.textContent = mode === "orbit" ? "Orbit" : "Fly";
    button?.setAttribute("aria-pressed", String(mode === "fly"));
  }

  /** @param {string} name @returns {HTMLElement} */
  #part(name) {
    return /** @type {HTMLElement} */ (this.#root.querySelector(`.${name}`));
  }
}

customElements.define("mobile-gs", MobileGs);
