/**
 * `<mobile-gs src="scene.mgs">`: a scene in any page.
 *
 * The file viewer/attributes.js lists its attributes.
 *
 * Children with `slot="annotation"` follow the points that their `data-at="x y z"` names (slotted.js).
 *
 * `data-state` is `loading`, then `loaded` or `failed`.
 */

import { own, trustedHtml } from "./assets.js";
import { giveBack, seen, take, used } from "./contexts.js";
import { STILL, VIEWER_ATTRIBUTES, applyAttribute, optionsOf, reflect } from "./viewer/attributes.js";
import { LoadProgress } from "./viewer/load_progress.js";
import { Chrome } from "./viewer/chrome.js";
import { Dialogs } from "./viewer/dialogs.js";
import { listenToFiles, listenToKeys } from "./viewer/element_input.js";
import { icon } from "./viewer/icons.js";
import { filled, languageOf, localize, textsOf, visible } from "./viewer/localize.js";
import { applySetting, showSettings } from "./viewer/settings.js";
import { shareable } from "./viewer/share.js";
import { adoptStyle } from "./viewer/style.js";
import { poseFromHash, poseToHash } from "./viewer/pose_hash.js";
import { TEMPLATE } from "./viewer/template.js";
import { en } from "./viewer/texts.js";
import { Viewer } from "./viewer/viewer.js";

/** @import { Request } from "./load/worker.js" */
/** @import { Choice } from "./render/create_renderer.js" */
/** @import { Pose } from "./viewer/pose.js" */
/** @import { Split } from "./viewer/split.js" */
/** @import { FrameStats, Stats } from "./viewer/stats.js" */
/** @import { Vector } from "./viewer/vector.js" */
/** @import { Side } from "./viewer/viewer.js" */
/** @typedef {string | Blob} Source a URL, or a file that the visitor opened */
/** @typedef {{eye: Vector, target: Vector, up?: Vector}} CameraPose world units; without `up` that direction stays */
/**
 * @typedef {object} CameraChange detail of the event `camera`
 * @property {string} camera in the form of the attribute
 * @property {Vector} eye
 * @property {Vector} target centre of the orbit
 * @property {Vector} up of the world
 * @property {MobileGs} origin the element whose camera was moved: this one, or the one that it follows
 */

/** @type {import("./viewer/viewer.js").Mode[]} */
const MODES = ["orbit", "fly", "walk"];
const LOWEST = 120; // pixels: the height of an element without one
const TEXT_ATTRIBUTES = ["heading", "credit", "alt", "lang"];
const OTHER_ATTRIBUTES = ["src", "compare", "annotations", "follow"];
const NOTICE_TIME = 2000; // milliseconds
const SORTED = "sorted"; // value of `compare`: the same scene, rendered sorted
const NEAR = { rootMargin: "100%" };
const extras = () => own(import("./viewer/extras.js"));

// servers import this module too, and have no elements
export class MobileGs extends (globalThis.HTMLElement ?? Object) {
  /** @internal */
  static observedAttributes = [...OTHER_ATTRIBUTES, ...VIEWER_ATTRIBUTES, ...TEXT_ATTRIBUTES];

  /** @internal @type {Viewer | null} */
  viewer = null;
  #root;
  #chrome;
  #dialogs;
  #texts = en;
  #language = "en";
  /** @type {Split | null} */
  #split = null;
  #loadProgress = new LoadProgress();
  /** The source opened last, if not `src`. @type {Source | null} */
  #source = null;
  /** The second source opened last, if not `compare`. @type {Source | null | undefined} */
  #other;
  #twice = false; // whether the scene is compared with itself, sorted
  #again = false; // whether it will be, once it has loaded
  /** @type {FrameStats | null} */
  #stats = null;
  #view = 0;
  #ready = Promise.resolve(false);
  #blind = false; // no renderer works
  #stick = false; // whether the stick for walking works
  #camera = ""; // of the last event
  #notice = 0; // timer of the text that is shown
  /** The pose taken last from another element, and the element whose camera was moved. @type {{pose: Pose, origin: MobileGs} | null} */
  #taken = null;
  /** Ends following another element. */
  #following = new AbortController();
  /** Choices and pose to restore when the element has its context again. @type {{choices: object, pose: Pose | null} | null} */
  #asleep = null;
  /** @type {import("./contexts.js").Holder} */
  #holder = { inSight: null, cost: 2, suspend: () => this.#suspend(), resume: () => this.#start() };
  #sight = new IntersectionObserver(([{ isIntersecting }]) => {
    seen(this.#holder, isIntersecting);
    if (this.viewer) this.viewer.visible = isIntersecting;
  });
  /** Starts the viewer when the element is less than a screen away from the visible part of the page. */
  #near = new IntersectionObserver((all) => all.some((one) => one.isIntersecting) && this.#start(), NEAR);

  constructor() {
    super();
    this.#root = this.attachShadow({ mode: "open", delegatesFocus: true });
    this.#root.innerHTML = trustedHtml(TEMPLATE);
    adoptStyle(this.#root);
    this.#dialogs = new Dialogs(this.#root);
    this.#chrome = new Chrome(this, this.#part("chrome"));
    for (const button of this.#root.querySelectorAll("button")) {
      button.addEventListener("click", () => this.act(button.dataset.act ?? ""));
    }
    listenToKeys(this.#root, (action) => this.act(action), () => this.#part("help").classList.add("typed"));
    this.#part("settings").addEventListener("input", ({ target }) => {
      const control = /** @type {HTMLInputElement} */ (target);
      if (control.name === "stats") this.act("stats");
      else if (this.viewer) applySetting(control, this.viewer);
      void this.#showStick();
    });
    this.addEventListener("fullscreenchange", () => {
      const button = this.#button("full");
      const name = document.fullscreenElement ? "window" : "full";
      button.innerHTML = trustedHtml(icon(name));
      button.dataset.name = name;
      localize(this.#root, this.#texts);
    });
    this.addEventListener("pointerdown", () => used(this.#holder));
    listenToFiles(this, this.#part("drop"), (files) => this.#openFiles(files));
    const picked = this.#picker;
    picked.addEventListener("change", () => {
      this.#dialogs.show(null);
      this.#openFiles(picked.files);
      picked.value = ""; // so that the same file can be opened again
    });
    const slot = /** @type {HTMLSlotElement} */ (this.#root.querySelector("slot"));
    const follow = async () => {
      const { Slotted } = await extras();
      new Slotted(this, slot, () => this.viewer);
    };
    slot.addEventListener("slotchange", () => void follow(), { once: true });
  }

  /** @internal */
  connectedCallback() {
    // scripts may set attributes right after they create the element
    queueMicrotask(() => {
      if (!this.isConnected) return;
      if (this.viewer) return void this.#follow(); // it was moved, perhaps into another tree
      const poster = this.getAttribute("poster")?.replace(/[\x22\\\n]/g, encodeURIComponent);
      if (poster) this.style.background = `center / cover no-repeat url("${poster}")`;
      if (this.clientHeight <= LOWEST) this.style.aspectRatio = "16 / 10"; // the page gives it no height
      this.#sight.observe(this);
      if (this.getAttribute("loading") === "lazy") this.#near.observe(this);
      else this.#start();
    });
  }

  /** Begin, or wait until another element of the page gives its context back. @param {boolean} [asked] by the visitor */
  #start(asked = false) {
    this.#near.disconnect();
    this.#part("chrome").hidden = this.hasAttribute("noui");
    this.#holder.cost = navigator.gpu && this.getAttribute("renderer") !== "webgl" ? 1 : 2;
    const able = (this.#part("wake").hidden = take(this.#holder, asked));
    if (!able) return void this.#localize();
    this.#begin();
    if (this.#asleep) this.#restore(this.#asleep); // kept until the scene is drawn
  }

  /** @param {{choices: object, pose: Pose | null}} before */
  #restore({ choices, pose }) {
    const viewer = /** @type {Viewer} */ (this.viewer);
    Object.assign(viewer, choices);
    if (pose) viewer.place(pose);
  }

  /** Give the context back; a still picture stays. */
  #suspend() {
    const { viewer } = this;
    if (!viewer) return;
    if (viewer.count) {
      this.#asleep = { choices: viewer.choices, pose: viewer.pose };
      const still = viewer.copy();
      still.className = "still";
      this.#part("wake").before(still);
    }
    this.#part("wake").hidden = false;
    this.#end();
  }

  /** @param {Choice} [choice] of a renderer, instead of the attribute */
  #begin(choice = /** @type {Choice} */ (this.getAttribute("renderer") ?? "auto")) {
    this.#button("full").hidden = !document.fullscreenEnabled;
    this.#button("share").hidden = !shareable();
    void this.#chrome.offer();
    void this.#localize();
    const canvas = /** @type {HTMLCanvasElement} */ (this.#root.querySelector("canvas"));
    this.viewer = new Viewer(canvas, this, optionsOf(this));
    this.viewer.visible = this.#holder.inSight !== false;
    canvas.classList.toggle("polite", this.hasAttribute("polite"));
    for (const name of VIEWER_ATTRIBUTES) applyAttribute(this, this.viewer, name);
    this.#ready = this.viewer.begin(choice);
    this.#blind = false;
    this.#camera = "";
    void this.#follow();
    void this.#ready.then((able) => (this.#blind = !able));
    const source = this.#source ?? this.getAttribute("src");
    const other = this.#other === undefined ? this.getAttribute("compare") : this.#other;
    if (source) void this.open(source);
    if (other) void this.compareWith(other);
  }

  /** @internal */
  disconnectedCallback() {
    // to be moved in the document is to be removed and inserted at once
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.#near.disconnect();
      this.#sight.disconnect();
      this.#following.abort();
      const { viewer } = this;
      if (viewer?.count) this.#asleep = { choices: viewer.choices, pose: viewer.pose };
      this.#end();
      giveBack(this.#holder);
    });
  }

  /** The camera, in the form of the page's fragment: `eye=x,y,z&at=x,y,z&up=x,y,z`; empty without a scene. */
  get camera() {
    return this.viewer ? poseToHash(this.viewer.pose) : "";
  }

  set camera(text) {
    // frameworks set null where there is no value
    if (!text || text === this.camera) return;
    const pose = poseFromHash(text);
    if (!this.viewer) this.setAttribute("camera", text); // for the viewer that begins later
    else if (pose) this.viewer.place(pose);
  }

  /**
   * Fly to a camera. An input of the visitor, another flight or the signal stops the flight.
   *
   * @param {string | CameraPose} camera
   * @param {{seconds?: number, signal?: AbortSignal}} [options] 0.9 seconds; 0 for visitors who prefer reduced motion
   * @returns {Promise<boolean>} whether it arrived
   */
  async flyTo(camera, { seconds, signal } = {}) {
    const to = typeof camera === "string" ? poseFromHash(camera) : camera;
    if (!to) throw new TypeError(`"${camera}" is not a camera: write eye=x,y,z&at=x,y,z&up=x,y,z`);
    const { flyTo } = await extras();
    const { viewer } = this;
    if (!viewer?.count || signal?.aborted) return false;
    viewer.turning = false;
    return flyTo(viewer, this, to, { seconds: matchMedia(STILL).matches ? 0 : seconds, signal });
  }

  /**
   * The point of the scene under a pixel of the element, in world units; null where there is none.
   *
   * @param {number} x CSS pixels from the left
   * @param {number} y from the top
   * @returns {Vector | null}
   */
  pointAt(x, y) {
    return this.viewer?.count ? this.viewer.pointAt(x, y) : null;
  }

  /** Follow the camera of another element. */
  async #follow() {
    this.#following.abort();
    this.#following = new AbortController();
    const { signal } = this.#following;
    if (!this.hasAttribute("follow")) return;
    const { followCamera } = await extras();
    if (signal.aborted) return;
    followCamera(this, signal, (pose, origin) => {
      this.#taken = { pose, origin };
      this.viewer?.place(pose);
    });
  }

  /** Show the stick for walking, in that mode. */
  async #showStick() {
    const stick = this.#part("stick");
    const walks = this.viewer?.mode === "walk";
    stick.classList.toggle("shown", walks);
    if (!walks || this.#stick) return;
    this.#stick = true;
    const { makeJoystick } = await extras();
    makeJoystick(stick, (right, forward) => this.viewer?.stride(right, forward));
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

  /** @internal @param {string} name @param {string | null} before @param {string | null} value */
  attributeChangedCallback(name, before, value) {
    if (name === "src") this.#source = this.#asleep = null; // another scene has another camera
    if (name === "compare") this.#other = undefined;
    if (!this.viewer || value === before) return;
    if (TEXT_ATTRIBUTES.includes(name)) return void this.#localize();
    if (name === "compare") void this.compareWith(value || null);
    else if (name === "annotations") void this.#showNotes(false);
    else if (name === "follow") void this.#follow();
    else if (name === "camera") this.camera = value ?? "";
    else if (name !== "src") applyAttribute(this, this.viewer, name);
    else if (value) void this.open(value);
  }

  /** Open a scene. @param {Source} source */
  async open(source) {
    this.#source = source;
    this.#again = this.#twice; // until it has loaded, the previous scene stays on both sides
    await this.#load(0, source, (viewer, request) => {
      viewer.load(request);
      applyAttribute(this, viewer, "up");
    });
  }

  /**
   * Compare the open scene with another one; null ends the comparison.
   *
   * @param {Source | null} other `sorted`: the same scene, rendered sorted
   */
  async compareWith(other) {
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
      void this.#splitWith(canvas);
      void viewer.compare(canvas, request, this.#twice);
    });
  }

  /** Make the handle between both scenes. @param {HTMLCanvasElement} canvas of the second one */
  async #splitWith(canvas) {
    const { Split } = await extras();
    if (!canvas.isConnected) return;
    this.#split = new Split(this.#part("split"), canvas);
    this.viewer?.redraw(); // which shows it
  }

  /** Perform the action of a button or key. @param {string} what */
  act(what) {
    const viewer = this.viewer;
    if (what === "wake") this.#start(true);
    if (!viewer) return;
    if (what === "reset" || what === "view") {
      viewer.turning = false;
      viewer.reset(what === "view" ? ++this.#view : undefined);
    } else if (what === "help" || what === "settings") this.#dialogs.show(what);
    else if (what === "stats") {
      viewer.timed = this.#dialogs.toggle("stats");
      void extras().then(({ FrameStats }) => {
        this.#stats ??= new FrameStats();
        viewer.redraw();
      });
    }
    else if (what === "own") viewer.background = null;
    else if (what === "up") {
      const name = viewer.turnUp();
      this.#announce(name ? filled(this.#texts.axis, name) : this.#texts.ownAxis, true);
    }
    else if (what === "mode") {
      const next = MODES[(MODES.indexOf(viewer.mode) + 1) % MODES.length];
      viewer.mode = next;
      this.#announce(this.#texts[/** @type {const} */ ({ orbit: "orbits", fly: "flies", walk: "walks" })[next]], true);
    }
    else if (what === "vr" || what === "ar") {
      this.#chrome.present(what, viewer)?.catch(({ message }) => this.#announce(message, true));
    } else if (what === "picture") void extras().then(async ({ save }) => save(await viewer.screenshot(this.#split?.share)));
    else if (what === "open") this.#picker.click();
    else if (what === "copy") void this.#dialogs.copy(this.#texts);
    else if (what === "share") void this.#dialogs.share(this.#texts);
    else if (what === "send") this.#dialogs.send();
    else if (what === "retry" && this.#source !== null) {
      this.#part("message").hidden = true;
      void this.open(this.#source);
    }
    else if (what === "full") {
      if (document.fullscreenElement) void document.exitFullscreen();
      else void this.requestFullscreen?.().catch(() => {});
    } else if (what === "close") {
      this.#part("message").hidden = true;
      this.#dialogs.show(null);
    }
    void this.#showStick();
    showSettings(this.#part("settings"), viewer, !this.#part("stats").hidden, this.#texts);
    viewer.redraw();
  }

  /** @internal @param {Side} side @param {number} share of the file that has been received */
  progress(side, share) {
    this.#loadProgress.note(side, { share, state: "loading" });
    this.#update();
  }

  /** @internal @param {Side} side @param {number} milliseconds @param {number} bytes of the file */
  loaded(side, milliseconds, bytes) {
    this.#loadProgress.note(side, { share: 1, state: "loaded" });
    this.#update();
    if (side === 1) return;
    if (this.#again) void this.compareWith(SORTED);
    this.#announce(filled(this.#texts.loaded, (this.viewer?.count ?? 0).toLocaleString(this.#language)));
    this.dispatchEvent(new CustomEvent("load", { detail: { milliseconds, bytes } }));
    void this.#showNotes(this.hasAttribute("autoplay"));
  }

  /** Show the annotations of the file. @param {boolean} autoplay whether the camera follows its path */
  async #showNotes(autoplay) {
    const { viewer } = this;
    this.#root.querySelector(".annotations")?.remove();
    const asked = ["annotations", "path"].some((name) => viewer?.notes[name] || this.hasAttribute(name));
    if (!viewer || !asked || this.hasAttribute("editable")) return;
    const { showNotes } = await extras();
    if (viewer === this.viewer) showNotes(this, this.#root, viewer, autoplay);
  }

  /** @internal @param {Side} side @param {string} sentence @param {boolean} [kept] whether the previous scene stays */
  failed(side, sentence, kept = false) {
    this.#loadProgress.fail(side, sentence, kept);
    if (side === 0) this.#again = false;
    this.#update();
    const message = this.#part("message");
    message.hidden = false;
    if (side === 0) this.#source = this.viewer?.source ?? this.#source; // the previous scene stays
    const { viewer } = this;
    const shown = Boolean(viewer?.count);
    const heading = /** @type {HTMLElement} */ (message.querySelector("h2"));
    heading.hidden = shown;
    heading.dataset.text = navigator.onLine ? "failed" : "offline";
    localize(message, this.#texts);
    this.#button("open", message).hidden = shown;
    this.#button("retry", message).hidden = shown || typeof this.#source !== "string" || !viewer?.device.renderer;
    this.dispatchEvent(new CustomEvent("error", { detail: { sentence } }));
  }

  /** The renderer cannot continue: WebGL2 takes over from WebGPU. @internal @param {Side} side @param {string} sentence */
  broken(side, sentence) {
    const viewer = this.viewer;
    if (!viewer || viewer.device.renderer === "WebGL2" || this.getAttribute("renderer") === "webgpu") {
      this.failed(side, sentence);
      return;
    }
    console.warn(`WebGL2 takes over: ${sentence}`);
    this.#end();
    this.#begin("webgl");
    this.#restore({ choices: viewer.choices, pose: viewer.count ? viewer.pose : null });
  }

  /** The shadow tree and its dialogs. @internal */
  get inside() {
    return { root: this.#root, dialogs: this.#dialogs };
  }

  /** @internal @param {Stats} stats */
  drawn(stats) {
    if (!stats.early) this.#root.querySelector("canvas")?.classList.add("drawn");
    this.#root.querySelector(".still")?.remove();
    this.#asleep = null;
    if (stats.compared && this.#part("split").hidden) this.#split?.show(this.#loadProgress.names, this.#texts.compared);
    this.#showTitle();
    if (!this.viewer?.measured) this.#chrome.invite(this.#source);
    this.dispatchEvent(new CustomEvent("frame", { detail: stats }));
    this.#tellCamera();
    const panel = this.#part("stats");
    if (!panel.hidden) panel.textContent = this.#stats?.lines(stats) ?? "";
  }

  /** Dispatch the event `camera` if the camera has moved. */
  #tellCamera() {
    const { viewer, camera } = this;
    if (!viewer || camera === this.#camera) return;
    this.#camera = camera;
    const { eye, target, up } = viewer.pose;
    const origin = (viewer.pose === this.#taken?.pose && this.#taken.origin) || this;
    const detail = { camera, eye, target, up, origin };
    this.#taken = null;
    // elements that follow this one listen at its root
    this.dispatchEvent(new CustomEvent("camera", { detail, bubbles: true }));
  }

  /** Announce a text to screen readers and, if `seen`, show it for two seconds. @param {string} text */
  #announce(text, seen = false) {
    const said = this.#part("said");
    said.textContent = text;
    said.classList.toggle("seen", seen);
    clearTimeout(this.#notice);
    this.#notice = setTimeout(() => said.classList.remove("seen"), NOTICE_TIME);
  }

  /** Set all texts, in the language of the attribute, the page or the visitor. */
  async #localize() {
    this.#language = languageOf(this);
    this.#texts = await textsOf(this.#language);
    localize(this.#root, this.#texts);
    const canvas = this.#root.querySelector("canvas");
    canvas?.setAttribute("aria-label", `${this.getAttribute("alt") ?? this.#texts.scene}. ${this.#texts.keysHint}`);
    this.#showTitle();
  }

  /** Show title and credit: those of the attributes, or else of the file. */
  #showTitle() {
    const { title = "", credit = "" } = this.viewer?.notes ?? {};
    this.#chrome.setTitle(this.getAttribute("heading") ?? String(title ?? ""), this.getAttribute("credit") ?? String(credit ?? ""));
  }

  /** @returns {HTMLInputElement} */
  get #picker() {
    return /** @type {HTMLInputElement} */ (this.#root.querySelector("[type=file]"));
  }

  /** @param {FileList | null | undefined} files one or two */
  #openFiles(files) {
    const [file, other] = files ?? [];
    if (file) void this.open(file);
    if (other) void this.compareWith(other);
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
    const name = visible(source instanceof File ? source.name : address);
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
    if (!this.#part("split").hidden) this.#split?.show(names, this.#texts.compared);
    if (state) this.dataset.state = state;
  }

  /** Remove the second scene's canvas and hide the handle. */
  #removeComparison() {
    this.#part("split").hidden = true;
    this.#root.querySelector(".over")?.remove();
    this.#split = null;
  }

  /** A button, the first one of an action. @param {string} act @param {ParentNode} [within] @returns {HTMLElement} */
  #button(act, within = this.#root) {
    return /** @type {HTMLElement} */ (within.querySelector(`[data-act=${act}]`));
  }

  /** @param {string} name @returns {HTMLElement} */
  #part(name) {
    return /** @type {HTMLElement} */ (this.#root.querySelector(`.${name}`));
  }
}

reflect(MobileGs.prototype, MobileGs.observedAttributes);

// a page may have two copies of this module
if (!globalThis.customElements?.get("mobile-gs")) globalThis.customElements?.define("mobile-gs", MobileGs);
