/**
 * `<mobile-gs src="scene.mgs">`: a scene in any page.
 *
 * Attributes: `src`, address of a .mgs, .ply or .spz file; `compare`, of another one that a handle
 * uncovers, or `sorted`, the same one drawn as if it were no sort-free scene; `renderer`, auto, webgpu
 * or webgl; `variant`, how it draws instead of what is fastest here: words out of floats (or halves)
 * and strips (or batches); `scale`, share of the screen's pixels to draw instead of as many as the device can;
 * `background`, a colour of CSS instead of the scene's own; `fov`, the field of view in degrees;
 * `autorotate` turns the scene until somebody takes hold of it; `noui` hides the buttons; `poster`, a
 * picture to show until there is something better; `loading`, lazy: nothing begins before the element is
 * nearly in sight; `alt`, what there is to see, for those who cannot; `polite` leaves the wheel, and one
 * finger's way up and down, to the page around, unless Ctrl is held or there are two. While scenes arrive `data-state` is `loading`, then `loaded` or `failed`.
 */

import { Arrivals } from "./viewer/arrivals.js";
import { colorOf } from "./viewer/color.js";
import { applySetting, showSettings } from "./viewer/settings.js";
import { Split } from "./viewer/split.js";
import { KEYS, TEMPLATE } from "./viewer/template.js";
import { Viewer } from "./viewer/viewer.js";

/** @typedef {import("./load/worker.js").Request} Request */
/** @typedef {import("./render/choose.js").Choice} Choice */
/** @typedef {import("./viewer/viewer.js").Side} Side */
/** @typedef {import("./viewer/viewer.js").Stats} Stats */
/** @typedef {string | Blob} Source an address, or a file of the visitor's */

const DIALOGS = ["settings", "help", "report"];
const WISHES = ["scale", "background", "fov", "autorotate"];
const SEEN = 2000; // milliseconds
const SORTED = "sorted"; // of compare: the same scene in the other way
const NEAR = { rootMargin: "100%" };
const STILL = "(prefers-reduced-motion: reduce)";

export class MobileGs extends HTMLElement {
  static observedAttributes = ["src", "compare", ...WISHES];

  /** @type {Viewer | null} */
  viewer = null;
  #root;
  /** @type {Split | null} */
  #split = null;
  #arrivals = new Arrivals();
  /** What was opened last, instead of what `src` says. @type {Source | null} */
  #source = null;
  /** What it was compared with last, instead of what `compare` says. @type {Source | null | undefined} */
  #other;
  #twice = false; // whether it is compared with itself
  #again = false; // whether it shall be, once it is there
  /** What had the focus before a dialog took it. @type {HTMLElement | null} */
  #opener = null;
  /** Frame times of the last second or so, milliseconds. @type {number[]} */
  #times = [];
  #view = 0;
  #ready = Promise.resolve(false);
  #blind = false; // there is no way to draw
  /** Told when there is less than a screen between the element and what is seen. */
  #near = new IntersectionObserver((all) => all.some((one) => one.isIntersecting) && this.#begin(), NEAR);

  constructor() {
    super();
    this.#root = this.attachShadow({ mode: "open", delegatesFocus: true });
    this.#root.innerHTML = TEMPLATE;
    for (const button of this.#root.querySelectorAll("button")) {
      button.addEventListener("click", () => this.act(button.dataset.act ?? ""));
    }
    this.#root.addEventListener("keydown", (event) => {
      const { code, key, ctrlKey, metaKey, altKey, repeat, target, defaultPrevented } = /** @type {KeyboardEvent} */ (event);
      // keyboards of other alphabets have other letters in the same places
      const act = KEYS.get(key.toLowerCase()) ?? KEYS.get(code.slice(3).toLowerCase());
      const typing = defaultPrevented || /** @type {Element} */ (target).matches("textarea, select");
      if (act && !ctrlKey && !metaKey && !altKey && !repeat && !typing) this.act(act);
      if (code === "Escape") this.act("close");
    });
    // pages give the scene the focus, too: only who comes to it by key needs to see that they are there
    this.#root.addEventListener("keyup", (event) => {
      const { code, target } = /** @type {KeyboardEvent} */ (event);
      const { classList } = /** @type {Element} */ (target);
      if (code !== "Tab") return;
      classList.add("reached");
      target?.addEventListener("blur", () => classList.remove("reached"), { once: true });
    });
    this.#part("settings").addEventListener("input", ({ target }) => {
      const control = /** @type {HTMLInputElement} */ (target);
      if (control.name === "stats") this.act("stats");
      else if (this.viewer) applySetting(control, this.viewer);
    });
    this.addEventListener("dragover", (event) => {
      event.preventDefault();
      this.#part("drop").hidden = false;
    });
    this.addEventListener("dragleave", () => (this.#part("drop").hidden = true));
    this.addEventListener("drop", (event) => {
      event.preventDefault();
      this.#part("drop").hidden = true;
      this.#openFiles(event.dataTransfer?.files);
    });
    const picked = this.#picker;
    picked.addEventListener("change", () => {
      this.#dialog(null);
      this.#openFiles(picked.files);
      picked.value = ""; // the same one may be chosen again
    });
  }

  connectedCallback() {
    // a script that comes with the element may still want to set attributes
    queueMicrotask(() => {
      if (!this.isConnected || this.viewer) return;
      const poster = this.getAttribute("poster")?.replace(/[\x22\\\n]/g, encodeURIComponent);
      if (poster) this.style.background = `center / cover no-repeat url("${poster}")`;
      if (this.getAttribute("loading") === "lazy") this.#near.observe(this);
      else this.#begin();
    });
  }

  /** @param {Choice} [choice] of a renderer, instead of what the attribute says */
  #begin(choice = /** @type {Choice} */ (this.getAttribute("renderer") ?? "auto")) {
    this.#near.disconnect();
    this.#part("buttons").hidden = this.hasAttribute("noui");
    /** @type {HTMLElement} */ (this.#root.querySelector("[data-act=full]")).hidden = !document.fullscreenEnabled;
    const canvas = /** @type {HTMLCanvasElement} */ (this.#root.querySelector("canvas"));
    const wished = this.getAttribute("variant");
    const [floats, strips] = ["floats", "strips"].map((word) => Boolean(wished?.includes(word)));
    this.viewer = new Viewer(canvas, this, { variant: wished === null ? null : { floats, strips } });
    canvas.setAttribute("aria-label", `${this.getAttribute("alt") ?? "3D scene"}. Press H for the keys.`);
    canvas.classList.toggle("polite", this.hasAttribute("polite"));
    for (const name of WISHES) this.#wish(name);
    this.#ready = this.viewer.begin(choice);
    this.#blind = false;
    void this.#ready.then((able) => (this.#blind = !able));
    const source = this.#source ?? this.getAttribute("src");
    const other = this.#other === undefined ? this.getAttribute("compare") : this.#other;
    if (source) void this.open(source);
    if (other) void this.compare(other);
  }

  disconnectedCallback() {
    this.#near.disconnect();
    this.#end();
  }

  #end() {
    this.viewer?.destroy();
    this.viewer = null;
    this.#uncover();
    this.#arrivals = new Arrivals();
    // a canvas that was drawn to in one way cannot be drawn to in another
    const canvas = this.#root.querySelector("canvas");
    canvas?.classList.remove("drawn");
    canvas?.replaceWith(canvas.cloneNode());
  }

  /** @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (name === "src") this.#source = null;
    if (name === "compare") this.#other = undefined;
    if (!this.viewer || value === before) return;
    if (name === "compare") void this.compare(value || null);
    else if (name !== "src") this.#wish(name);
    else if (value) void this.open(value);
  }

  /** Opens a scene. @param {Source} source */
  async open(source) {
    this.#source = source;
    this.#again = this.#twice; // once it is there: until then the one before stays, in both ways
    await this.#ask(0, source, (viewer, request) => viewer.load(request));
  }

  /**
   * Shows another scene beside the one that is open, or, for null, that one alone.
   *
   * @param {Source | null} other `sorted` stands for the same one, drawn as if it were a plain scene
   */
  async compare(other) {
    this.#other = other;
    this.#again = false;
    this.#twice = other === SORTED;
    const source = this.#twice ? this.#source : other;
    this.viewer?.alone();
    this.#uncover();
    this.#arrivals.begin(1);
    this.#tell();
    if (source === null) return;
    await this.#ask(1, source, (viewer, request) => {
      this.#uncover();
      const canvas = document.createElement("canvas");
      canvas.className = "over";
      canvas.setAttribute("aria-hidden", "true");
      this.#part("split").before(canvas);
      this.#split = new Split(this.#part("split"), canvas);
      void viewer.compare(canvas, request, this.#twice);
    });
  }

  /** Does what a button or key stands for. @param {string} what */
  act(what) {
    const viewer = this.viewer;
    if (!viewer) return;
    if (what === "reset" || what === "view") {
      viewer.turning = false;
      viewer.reset(what === "view" ? ++this.#view : undefined);
    } else if (what === "help" || what === "settings") this.#dialog(what);
    else if (what === "stats") viewer.timed = this.#toggle("stats");
    else if (what === "own") viewer.background = null;
    else if (what === "mode") {
      const turns = viewer.mode === "fly";
      viewer.mode = turns ? "orbit" : "fly";
      this.#say(`Dragging ${turns ? "turns the scene" : "looks around"}.`, true);
    }
    else if (what === "picture") void this.#save();
    else if (what === "open") this.#picker.click();
    else if (what === "copy") void this.#copy();
    else if (what === "share") void navigator.share?.({ text: this.#report }).catch(() => {});
    else if (what === "full") {
      if (document.fullscreenElement) void document.exitFullscreen();
      else void this.requestFullscreen?.().catch(() => {});
    } else if (what === "close") {
      this.#part("message").hidden = true;
      this.#dialog(null);
    }
    showSettings(this.#part("settings"), viewer, !this.#part("stats").hidden);
    viewer.redraw();
  }

  /** @param {Side} side @param {number} share of the file that has arrived */
  progress(side, share) {
    this.#arrivals.note(side, { share, state: "loading" });
    this.#tell();
  }

  /** @param {Side} side @param {number} milliseconds @param {number} bytes of the file */
  loaded(side, milliseconds, bytes) {
    this.#arrivals.note(side, { share: 1, state: "loaded" });
    this.#tell();
    if (side === 1) return;
    if (this.#again) void this.compare(SORTED);
    this.#say(`${this.viewer?.count.toLocaleString("en")} Gaussians are there.`);
    this.dispatchEvent(new CustomEvent("load", { detail: { milliseconds, bytes } }));
  }

  /** @param {Side} side @param {string} sentence @param {boolean} [kept] whether the scene before stays */
  failed(side, sentence, kept = false) {
    this.#arrivals.fail(side, sentence, kept);
    if (side === 0) this.#again = false;
    this.#tell();
    this.#part("message").hidden = false;
    if (side === 0) this.#source = this.viewer?.source ?? this.#source; // the scene before stays
    /** @type {HTMLElement} */ (this.#root.querySelector(".message [data-act=open]")).hidden =
      Boolean(this.viewer?.count);
    this.dispatchEvent(new CustomEvent("error", { detail: { sentence } }));
  }

  /** What draws cannot go on: the other way takes over, if there is one. @param {Side} side @param {string} sentence */
  broken(side, sentence) {
    const viewer = this.viewer;
    if (!viewer || viewer.device.renderer === "WebGL2" || this.getAttribute("renderer") === "webgpu") {
      this.failed(side, sentence);
      return;
    }
    console.warn(`WebGL2 takes over: ${sentence}`);
    this.#end();
    this.#begin("webgl");
    Object.assign(/** @type {any} */ (this.viewer), viewer.choices);
    if (viewer.count) this.viewer?.place(viewer.pose);
  }

  /** Shows figures, to be copied or shared. @param {Record<string, unknown>} figures */
  report(figures) {
    const text = JSON.stringify(figures, null, 1);
    const panel = this.#part("report");
    /** @type {HTMLTextAreaElement} */ (panel.querySelector("textarea")).value = text;
    const { cold, steady, interrupted } = /** @type {any} */ (figures);
    const words = `${cold.fps} frames/s cold, ${steady.fps} steady`;
    /** @type {HTMLElement} */ (panel.querySelector("h2")).textContent =
      interrupted ? "The page was not in sight all the time: measure again" : words;
    /** @type {HTMLElement} */ (panel.querySelector("[data-act=share]")).hidden = !navigator.share;
    if (panel.hidden) this.#dialog("report");
    this.dispatchEvent(new CustomEvent("report", { detail: figures }));
  }

  /** @param {Stats} stats */
  drawn(stats) {
    this.#root.querySelector("canvas")?.classList.add("drawn");
    if (stats.compared && this.#part("split").hidden) this.#split?.show(this.#arrivals.names);
    this.dispatchEvent(new CustomEvent("frame", { detail: stats }));
    const panel = this.#part("stats");
    if (panel.hidden) return;
    if (stats.milliseconds) this.#times = [...this.#times.slice(-29), stats.milliseconds];
    const mean = this.#times.reduce((sum, time) => sum + time, 0) / this.#times.length;
    const counts = [stats.count, stats.compared].filter((count, side) => side === 0 || count);
    const lines = [
      `${stats.renderer}, ${stats.width} x ${stats.height}`,
      `${counts.map((count) => count.toLocaleString("en")).join(" | ")} Gaussians`,
      this.#times.length ? `${(1000 / mean).toFixed(0)} frames/s, ${mean.toFixed(1)} ms` : "still",
      ...Object.entries(stats.passes ?? {}).map(([pass, time]) => `${pass} ${time.toFixed(2)} ms`),
    ];
    panel.textContent = lines.join("\n");
  }

  /** For those who hear the page and, if `seen`, for a moment for all. @param {string} text */
  #say(text, seen = false) {
    const said = this.#part("said");
    said.textContent = text;
    said.classList.toggle("seen", seen);
    setTimeout(() => said.classList.remove("seen"), SEEN);
  }

  get #report() {
    const area = /** @type {HTMLTextAreaElement} */ (this.#root.querySelector("textarea"));
    area.focus();
    area.select(); // where a page may not copy, its reader still can
    return area.value;
  }

  /** Copies the figures. Pages that come over plain http have only the old way. */
  async #copy() {
    const text = this.#report;
    const done = navigator.clipboard
      ? await navigator.clipboard.writeText(text).then(() => true, () => false)
      : document.execCommand("copy");
    this.#part("copied").textContent = done ? "Copied." : "This browser lets no page copy: the text is selected.";
  }

  /** @returns {HTMLInputElement} */
  get #picker() {
    return /** @type {HTMLInputElement} */ (this.#root.querySelector("[type=file]"));
  }

  /** @param {FileList | null | undefined} files one or two */
  #openFiles(files) {
    const [file, other] = files ?? [];
    if (file) void this.open(file);
    if (other) void this.compare(other);
  }

  async #save() {
    const picture = await this.viewer?.screenshot(this.#split?.share);
    if (!picture) return;
    const link = document.createElement("a");
    Object.assign(link, { href: URL.createObjectURL(picture), download: "scene.png" }).click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /** @param {string} name @param {boolean} [shown] @returns {boolean} whether it is shown now */
  #toggle(name, shown) {
    const part = this.#part(name);
    part.hidden = shown === undefined ? !part.hidden : !shown;
    this.#root.querySelector(`[data-act=${name}]`)?.setAttribute("aria-expanded", String(!part.hidden));
    return !part.hidden;
  }

  /** Shows a dialog and nothing but it, or hides it again; null hides all. @param {string | null} name */
  #dialog(name) {
    if (DIALOGS.every((one) => this.#part(one).hidden)) {
      this.#opener = /** @type {HTMLElement | null} */ (this.#root.activeElement);
    }
    const shown = name !== null && this.#part(name).hidden;
    for (const one of DIALOGS) this.#toggle(one, shown && one === name);
    if (shown) this.#part(name).focus();
    else (this.#opener ?? this.#root.querySelector("canvas"))?.focus({ preventScroll: true });
  }

  /** Takes over what an attribute says. @param {string} name one of WISHES */
  #wish(name) {
    const viewer = /** @type {Viewer} */ (this.viewer);
    const text = this.getAttribute(name);
    const number = Number(text);
    if (name === "scale") viewer.scale = number > 0 && number <= 1 ? number : null;
    else if (name === "fov") viewer.fov = number >= 1 && number <= 150 ? number : null;
    else if (name === "background") viewer.background = colorOf(text);
    else viewer.turning = text !== null && !matchMedia(STILL).matches;
    viewer.redraw();
  }

  /**
   * Begins to load one of the scenes.
   *
   * @param {Side} side
   * @param {Source} source
   * @param {(viewer: Viewer, request: Request) => void} load
   */
  async #ask(side, source, load) {
    const viewer = this.viewer;
    if (viewer === null || this.#blind) return;
    // the first scene can come while it is found out how to draw
    const other = this.#other;
    if (side === 1 && (!(await this.#ready) || viewer !== this.viewer || other !== this.#other)) return;
    const address = typeof source === "string" ? source.replace(/[?#].*$/, "") : "scene";
    const name = source instanceof File ? source.name : address;
    this.#arrivals.begin(side, side === 1 && this.#twice ? `${name}, sorted` : name);
    this.#tell();
    try {
      const request =
        source instanceof Blob ? { file: source } : { url: new URL(source, document.baseURI).href };
      load(viewer, request);
    } catch (error) {
      this.failed(side, `the scene cannot be opened: ${/** @type {Error} */ (error).message}`);
    }
  }

  /** Shows how far the scenes are. */
  #tell() {
    const { state, busy, share, sentence, names } = this.#arrivals;
    const bar = this.#part("bar");
    bar.hidden = !busy;
    bar.classList.toggle("unknown", Number.isNaN(share));
    const percent = Math.min(100, Math.round(100 * share)) || 0; // what is packed on its way comes to more
    bar.setAttribute("aria-valuenow", String(percent));
    /** @type {HTMLElement} */ (bar.firstElementChild).style.width = `${percent}%`;
    const message = this.#part("message");
    const words = /** @type {HTMLElement} */ (message.querySelector("p"));
    if (words.textContent !== sentence) words.textContent = sentence; // or it would be read out again
    if (!sentence) message.hidden = true;
    if (!this.#part("split").hidden) this.#split?.show(names);
    if (state) this.dataset.state = state;
  }

  /** Takes the other scene's canvas and handle away. */
  #uncover() {
    this.#part("split").hidden = true;
    this.#root.querySelector(".over")?.remove();
    this.#split = null;
  }

  /** @param {string} name @returns {HTMLElement} */
  #part(name) {
    return /** @type {HTMLElement} */ (this.#root.querySelector(`.${name}`));
  }
}

customElements.define("mobile-gs", MobileGs);
