/**
 * `<mobile-gs src="scene.mgs">`: a scene in any page.
 *
 * Attributes:
 *
 * - `src`: URL of a .mgs, .ply or .spz file
 * - `compare`: URL of a second scene, which a handle uncovers; or `sorted`, the same scene rendered sorted
 * - `renderer`: auto, webgpu or webgl
 * - `variant`: how it renders, instead of the fastest way: floats (or halves) and strips (or batches)
 * - `levels`: large Gaussians are added up in smaller targets, if their least standard deviation there is so
 *   many pixels, 0.6 to 100; `0` draws all at full size; by default 1, or 1.4 without soft edges
 * - `scale`: share of the screen's resolution, instead of one chosen by the frame time
 * - `background`: a CSS colour instead of the scene's own
 * - `fov`: field of view in degrees
 * - `up`: the axis of the scene that points up: x, -x, y, -y, z or -z; by default as the file or its cameras tell
 * - `autorotate`: rotates the scene until the first input
 * - `noui`: hides the buttons
 * - `poster`: URL of an image to show until the scene appears
 * - `loading`: with the value lazy, loading starts when the element is nearly in sight
 * - `alt`: description of the scene for screen readers
 * - `polite`: the page scrolls by wheel and by one finger; Ctrl and wheel, or two fingers, zoom
 *
 * `data-state` is `loading`, then `loaded` or `failed`.
 */

import { LoadProgress } from "./viewer/load_progress.js";
import { colorOf } from "./viewer/color.js";
import { applySetting, showSettings } from "./viewer/settings.js";
import { Split } from "./viewer/split.js";
import { KEYS, TEMPLATE } from "./viewer/template.js";
import { Viewer } from "./viewer/viewer.js";

/** @typedef {import("./load/worker.js").Request} Request */
/** @typedef {import("./render/create_renderer.js").Choice} Choice */
/** @typedef {import("./viewer/viewer.js").Side} Side */
/** @typedef {import("./viewer/viewer.js").Stats} Stats */
/** @typedef {string | Blob} Source a URL, or a file that the visitor opened */

const DIALOGS = ["settings", "help", "report"];
const VIEWER_ATTRIBUTES = ["scale", "background", "fov", "up", "autorotate"];
const NOTICE_TIME = 2000; // milliseconds
const SORTED = "sorted"; // value of `compare`: the same scene, rendered sorted
const NEAR = { rootMargin: "100%" };
const STILL = "(prefers-reduced-motion: reduce)";

// a worker runs this module too, and has no elements
export class MobileGs extends (globalThis.HTMLElement ?? Object) {
  static observedAttributes = ["src", "compare", ...VIEWER_ATTRIBUTES];

  /** @type {Viewer | null} */
  viewer = null;
  #root;
  /** @type {Split | null} */
  #split = null;
  #loadProgress = new LoadProgress();
  /** The source opened last, if not `src`. @type {Source | null} */
  #source = null;
  /** The second source opened last, if not `compare`. @type {Source | null | undefined} */
  #other;
  #twice = false; // whether the scene is compared with itself, sorted
  #again = false; // whether it will be, once it has loaded
  /** The element that had the focus before a dialog. @type {HTMLElement | null} */
  #opener = null;
  /** Recent frame times, milliseconds. @type {number[]} */
  #times = [];
  #view = 0;
  #ready = Promise.resolve(false);
  #blind = false; // no renderer works
  /** Starts the viewer when the element is less than a screen away from the visible part of the page. */
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
      // the code is the key's place, for keyboards with other alphabets
      const act = KEYS.get(key.toLowerCase()) ?? KEYS.get(code.slice(3).toLowerCase());
      const typing = defaultPrevented || /** @type {Element} */ (target).matches("textarea, select");
      if (act && !ctrlKey && !metaKey && !altKey && !repeat && !typing) this.act(act);
      if (code === "Escape") this.act("close");
    });
    // show the focus only to keyboard users: pages set the focus too
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
      picked.value = ""; // so that the same file can be opened again
    });
  }

  connectedCallback() {
    // scripts may set attributes right after they create the element
    queueMicrotask(() => {
      if (!this.isConnected || this.viewer) return;
      const poster = this.getAttribute("poster")?.replace(/[\x22\\\n]/g, encodeURIComponent);
      if (poster) this.style.background = `center / cover no-repeat url("${poster}")`;
      if (this.getAttribute("loading") === "lazy") this.#near.observe(this);
      else this.#begin();
    });
  }

  /** @param {Choice} [choice] of a renderer, instead of the attribute */
  #begin(choice = /** @type {Choice} */ (this.getAttribute("renderer") ?? "auto")) {
    this.#near.disconnect();
    this.#part("buttons").hidden = this.hasAttribute("noui");
    /** @type {HTMLElement} */ (this.#root.querySelector("[data-act=full]")).hidden = !document.fullscreenEnabled;
    const canvas = /** @type {HTMLCanvasElement} */ (this.#root.querySelector("canvas"));
    const variant = this.getAttribute("variant");
    const [floats, strips] = ["floats", "strips"].map((word) => Boolean(variant?.includes(word)));
    const levels = Number(this.getAttribute("levels") ?? NaN);
    this.viewer = new Viewer(canvas, this, {
      variant: variant === null ? null : { floats, strips },
      levels: levels === 0 || (levels >= 0.6 && levels <= 100) ? levels : null,
    });
    canvas.setAttribute("aria-label", `${this.getAttribute("alt") ?? "3D scene"}. Press H for the keys.`);
    canvas.classList.toggle("polite", this.hasAttribute("polite"));
    for (const name of VIEWER_ATTRIBUTES) this.#apply(name);
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
    this.#removeComparison();
    this.#loadProgress = new LoadProgress();
    // a canvas cannot change its context
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
    else if (name !== "src") this.#apply(name);
    else if (value) void this.open(value);
  }

  /** Open a scene. @param {Source} source */
  async open(source) {
    this.#source = source;
    this.#again = this.#twice; // until it has loaded, the previous scene stays on both sides
    await this.#load(0, source, (viewer, request) => {
      viewer.load(request);
      this.#apply("up");
    });
  }

  /**
   * Compare the open scene with another one; null ends the comparison.
   *
   * @param {Source | null} other `sorted`: the same scene, rendered sorted
   */
  async compare(other) {
    this.#other = other;
    this.#again = false;
    this.#twice = other === SORTED;
    const source = this.#twice ? this.#source : other;
    this.viewer?.endComparison();
    this.#removeComparison();
    this.#loadProgress.begin(1);
    this.#update();
    if (source === null) return;
    await this.#load(1, source, (viewer, request) => {
      this.#removeComparison();
      const canvas = document.createElement("canvas");
      canvas.className = "over";
      canvas.setAttribute("aria-hidden", "true");
      this.#part("split").before(canvas);
      this.#split = new Split(this.#part("split"), canvas);
      void viewer.compare(canvas, request, this.#twice);
    });
  }

  /** Perform the action of a button or key. @param {string} what */
  act(what) {
    const viewer = this.viewer;
    if (!viewer) return;
    if (what === "reset" || what === "view") {
      viewer.turning = false;
      viewer.reset(what === "view" ? ++this.#view : undefined);
    } else if (what === "help" || what === "settings") this.#dialog(what);
    else if (what === "stats") viewer.timed = this.#toggle("stats");
    else if (what === "own") viewer.background = null;
    else if (what === "up") {
      const name = viewer.turnUp();
      this.#announce(name ? `The axis ${name} points up.` : "The scene's own direction points up.", true);
    }
    else if (what === "mode") {
      const turns = viewer.mode === "fly";
      viewer.mode = turns ? "orbit" : "fly";
      this.#announce(`Dragging ${turns ? "rotates the scene" : "looks around"}.`, true);
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

  /** @param {Side} side @param {number} share of the file that has been received */
  progress(side, share) {
    this.#loadProgress.note(side, { share, state: "loading" });
    this.#update();
  }

  /** @param {Side} side @param {number} milliseconds @param {number} bytes of the file */
  loaded(side, milliseconds, bytes) {
    this.#loadProgress.note(side, { share: 1, state: "loaded" });
    this.#update();
    if (side === 1) return;
    if (this.#again) void this.compare(SORTED);
    this.#announce(`${this.viewer?.count.toLocaleString("en")} Gaussians loaded.`);
    this.dispatchEvent(new CustomEvent("load", { detail: { milliseconds, bytes } }));
  }

  /** @param {Side} side @param {string} sentence @param {boolean} [kept] whether the previous scene stays */
  failed(side, sentence, kept = false) {
    this.#loadProgress.fail(side, sentence, kept);
    if (side === 0) this.#again = false;
    this.#update();
    this.#part("message").hidden = false;
    if (side === 0) this.#source = this.viewer?.source ?? this.#source; // the previous scene stays
    /** @type {HTMLElement} */ (this.#root.querySelector(".message [data-act=open]")).hidden =
      Boolean(this.viewer?.count);
    this.dispatchEvent(new CustomEvent("error", { detail: { sentence } }));
  }

  /** The renderer cannot continue: WebGL2 takes over from WebGPU. @param {Side} side @param {string} sentence */
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

  /** Show a report that can be copied or shared. @param {Record<string, unknown>} figures */
  report(figures) {
    const text = JSON.stringify(figures, null, 1);
    const panel = this.#part("report");
    /** @type {HTMLTextAreaElement} */ (panel.querySelector("textarea")).value = text;
    const scenes = /** @type {import("./viewer/bench.js").Measured[]} */ (figures.scenes);
    const interrupted = scenes.some((one) => one.interrupted);
    const words = scenes.map(({ cold, steady }) => `${cold.fps} frames/s cold, ${steady.fps} steady`).join(" | ");
    /** @type {HTMLElement} */ (panel.querySelector("h2")).textContent =
      interrupted ? "The page was hidden during the measurement: measure again" : words;
    /** @type {HTMLElement} */ (panel.querySelector("[data-act=share]")).hidden = !navigator.share;
    if (panel.hidden) this.#dialog("report");
    this.dispatchEvent(new CustomEvent("report", { detail: figures }));
  }

  /** @param {Stats} stats */
  drawn(stats) {
    this.#root.querySelector("canvas")?.classList.add("drawn");
    if (stats.compared && this.#part("split").hidden) this.#split?.show(this.#loadProgress.names);
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
      ...(stats.fragments ? fragmentLines(stats.fragments) : []),
      ...Object.entries(stats.passes ?? {}).map(([pass, time]) => `${pass} ${time.toFixed(2)} ms`),
    ];
    panel.textContent = lines.join("\n");
  }

  /** Announce a text to screen readers and, if `seen`, show it for two seconds. @param {string} text */
  #announce(text, seen = false) {
    const said = this.#part("said");
    said.textContent = text;
    said.classList.toggle("seen", seen);
    setTimeout(() => said.classList.remove("seen"), NOTICE_TIME);
  }

  get #report() {
    const area = /** @type {HTMLTextAreaElement} */ (this.#root.querySelector("textarea"));
    area.focus();
    area.select(); // so that the visitor can copy it where pages may not
    return area.value;
  }

  /** Copy the report. Pages served over plain http have no clipboard API. */
  async #copy() {
    const text = this.#report;
    const done = navigator.clipboard
      ? await navigator.clipboard.writeText(text).then(() => true, () => false)
      : document.execCommand("copy");
    this.#part("copied").textContent = done ? "Copied." : "This browser does not allow copying: the text is selected, press Ctrl+C.";
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

  /** Toggle a dialog and close the others; null closes all. @param {string | null} name */
  #dialog(name) {
    if (DIALOGS.every((one) => this.#part(one).hidden)) {
      this.#opener = /** @type {HTMLElement | null} */ (this.#root.activeElement);
    }
    const shown = name !== null && this.#part(name).hidden;
    for (const one of DIALOGS) this.#toggle(one, shown && one === name);
    if (shown) this.#part(name).focus();
    else (this.#opener ?? this.#root.querySelector("canvas"))?.focus({ preventScroll: true });
  }

  /** Apply an attribute to the viewer. @param {string} name one of VIEWER_ATTRIBUTES */
  #apply(name) {
    const viewer = /** @type {Viewer} */ (this.viewer);
    const text = this.getAttribute(name);
    const number = Number(text);
    if (name === "scale") viewer.scale = number > 0 && number <= 1 ? number : null;
    else if (name === "fov") viewer.fov = number >= 1 && number <= 150 ? number : null;
    else if (name === "background") viewer.background = colorOf(text);
    else if (name === "up") viewer.up = text;
    else viewer.turning = text !== null && !matchMedia(STILL).matches;
    viewer.redraw();
  }

  /**
   * Start to load a scene.
   *
   * @param {Side} side
   * @param {Source} source
   * @param {(viewer: Viewer, request: Request) => void} load
   */
  async #load(side, source, load) {
    const viewer = this.viewer;
    if (viewer === null || this.#blind) return;
    // the first scene may load before the renderer exists
    const other = this.#other;
    if (side === 1 && (!(await this.#ready) || viewer !== this.viewer || other !== this.#other)) return;
    const address = typeof source === "string" ? source.replace(/[?#].*$/, "") : "scene";
    const name = source instanceof File ? source.name : address;
    this.#loadProgress.begin(side, side === 1 && this.#twice ? `${name}, sorted` : name);
    this.#update();
    try {
      const request =
        source instanceof Blob ? { file: source } : { url: new URL(source, document.baseURI).href };
      load(viewer, request);
    } catch (error) {
      this.failed(side, `the scene cannot be opened: ${/** @type {Error} */ (error).message}`);
    }
  }

  /** Update progress bar, message and state. */
  #update() {
    const { state, busy, share, sentence, names } = this.#loadProgress;
    const bar = this.#part("bar");
    bar.hidden = !busy;
    bar.classList.toggle("unknown", Number.isNaN(share));
    const percent = Math.min(100, Math.round(100 * share)) || 0; // compressed transfers exceed their length
    bar.setAttribute("aria-valuenow", String(percent));
    /** @type {HTMLElement} */ (bar.firstElementChild).style.width = `${percent}%`;
    const message = this.#part("message");
    const words = /** @type {HTMLElement} */ (message.querySelector("p"));
    if (words.textContent !== sentence) words.textContent = sentence; // setting it again would read it out again
    if (!sentence) message.hidden = true;
    if (!this.#part("split").hidden) this.#split?.show(names);
    if (state) this.dataset.state = state;
  }

  /** Remove the second scene's canvas and hide the handle. */
  #removeComparison() {
    this.#part("split").hidden = true;
    this.#root.querySelector(".over")?.remove();
    this.#split = null;
  }

  /** @param {string} name @returns {HTMLElement} */
  #part(name) {
    return /** @type {HTMLElement} */ (this.#root.querySelector(`.${name}`));
  }
}

/** @param {number[]} levels fragments per pixel by level */
function fragmentLines(levels) {
  const told = (/** @type {number} */ value) => value.toFixed(1);
  const sum = levels.reduce((all, value) => all + value);
  const lines = [`${told(sum)} fragments per pixel`];
  return levels.length > 1 ? [...lines, `${levels.map(told).join(" + ")} by level`] : lines;
}

globalThis.customElements?.define("mobile-gs", MobileGs);
