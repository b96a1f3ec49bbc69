/** One scene in a canvas: loads it, renders it, and sorts it if needed. */

import { loadingWorker } from "../load/scene_worker.js";
import { backToFront } from "../load/depth_sort.js";
import { worldMeans } from "../mgs/positions.js";
import { knownVariant, warmUp, warmUpDots } from "../render/calibrate.js";
import { usualLevelSigma } from "../render/levels.js";
import { createRenderer } from "../render/create_renderer.js";
import { INVISIBLE } from "../render/pack.js";
import { strides } from "../render/types.js";
import { selectVariant, storage } from "./variant_select.js";
import { SortSchedule } from "./sort_schedule.js";
import { recordLogits } from "./pick.js";

/** @typedef {import("../load/worker.js").Message} Message */
/** @typedef {import("../load/worker.js").Request} Request */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../mgs/positions.js").StoredMeans} StoredMeans */
/** @typedef {import("../render/create_renderer.js").Choice} Choice */
/** @typedef {import("../render/create_renderer.js").Renderer} Renderer */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("../render/webgl.js").Target} Target */
/** @typedef {import("./vector.js").Vector} Vector */
/**
 * @typedef {object} SceneListener callbacks of a scene view
 * @property {(share: number) => void} progress share of the file, 0 to 1; NaN while its size is unknown
 * @property {() => void} arrived another scene is shown, of which more may follow
 * @property {() => void} changed the scene has changed: render it
 * @property {() => void} ordered the requested order has arrived
 * @property {(milliseconds: number, bytes: number) => void} loaded everything is decoded
 * @property {(sentence: string, kept?: boolean) => void} failed `kept`: the previous scene stays
 * @property {(sentence: string) => void} broken the renderer cannot continue
 */

const LEAST_SIGMA = 0.6; // of levels: `levelSigma` of the renderers
const COUNT_EVERY = 1000; // milliseconds between two counts of fragments
const WARM_UP_DELAY = 50; // milliseconds, so that the first image reaches the screen before

export class SceneView {
  /** Gaussians of the scene. */
  count = 0;
  /** Gaussians of the whole file, once the first level is here. */
  total = 0;
  /** Training cameras that the file contains. @type {View[]} */
  views = [];
  near = 0.2;
  /** Upward direction that the file names. @type {Vector | null} */
  up = null;
  /** Notes of the file. @type {import("../mgs/header.js").Header["meta"]} */
  notes = {};
  /** Whether Gaussians can be hidden, which takes a copy of their lobes. */
  editable = false;
  /** Logits of the mean opacities, for picking. */
  logits = new Float32Array(0);
  /** The request that is loading, else the one that is shown. @type {Request | null} */
  request = null;
  /** Fragments per pixel by level when they were counted last, while each pass is timed. @type {number[] | null} */
  fragments = null;
  /** True if dots are not shown: the page has a poster, which is better. */
  patient = false;
  /** Resolves when the fastest variant is known; measured after the first scene has loaded. */
  calibrated = Promise.resolve();

  name = ""; // of the renderer
  /** True if the renderer failed with this scene. */
  broken = false;

  #storedMeans = /** @type {StoredMeans} */ (new Float32Array(0));
  #variant;
  #levels;
  #measured = false; // or known, or being measured
  #sorting;
  #listener;
  /** @type {Renderer | null} */
  #renderer = null;
  /** The worker of the shown scene. @type {Worker | null} */
  #worker = null;
  /** The worker of the scene that will replace it. @type {Worker | null} */
  #loading = null;
  /** The worker of the latest request. @type {Worker | null} */
  #latest = null;
  /** Resolves to whether a renderer exists. */
  #ready = Promise.resolve(false);
  #destroyed = false;
  /** @type {Request | null} */
  #shown = null;
  #reloaded = false; // the same scene again, after the renderer had lost it
  #lobeStride = 2;
  /** Packed lobes of an editable scene. @type {Uint32Array<ArrayBuffer>} */
  #lobes = new Uint32Array(0);
  /** Background colours: the scene's own, the chosen one, and the array that the renderer reads. */
  #background = [0, 0, 0];
  /** @type {Vector | null} */
  #chosen = null;
  #drawn = [0, 0, 0];
  #sortSchedule = new SortSchedule();
  /** The call of `sort` that waits for the worker. @type {{resolve: () => void, reject: (reason: Error) => void} | null} */
  #waiting = null;
  #counted = -Infinity; // time of it
  #timing = false;
  #dots = false; // whether only dots can be rendered yet
  #warm = false; // whether the shaders are compiled, or being compiled

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {SceneListener} listener
   * @param {Variant | null} variant null: the fastest on this device
   * @param {boolean} sorting whether sort-free scenes are rendered sorted
   * @param {number | null} levels `levelSigma` of the renderer; null: `usualLevelSigma` of the scene
   */
  constructor(canvas, listener, variant, sorting, levels = null) {
    this.canvas = canvas;
    this.#listener = listener;
    this.#variant = variant;
    this.#levels = levels;
    this.#sorting = sorting;
  }

  /** Create a renderer. @param {Choice} choice @returns {Promise<boolean>} whether it succeeded */
  begin(choice) {
    return (this.#ready = this.#open(choice));
  }

  /** @param {Choice} choice @returns {Promise<boolean>} */
  async #open(choice) {
    try {
      const { name, renderer } = await createRenderer(this.canvas, choice);
      if (this.#destroyed) {
        renderer.destroy();
        return false;
      }
      renderer.onLost = (sentence) => this.#break(sentence);
      if ("onRestored" in renderer) {
        renderer.onRestored = () => this.request && this.load(this.request);
      }
      const chosen = renderer.variants.find(
        ({ floats, strips }) => floats === this.#variant?.floats && strips === this.#variant.strips,
      );
      const known = chosen ?? knownVariant(renderer, storage());
      if (known) renderer.variant = known;
      renderer.levelSigma = this.#levels ?? 1; // for shaders that compile before the scene is known
      this.#measured = known !== null;
      this.#renderer = renderer;
      this.name = name;
      warmUpDots(renderer);
      return true;
    } catch (error) {
      this.#listener.failed(messageOf(error));
      return false;
    }
  }

  /** Select the fastest variant. */
  async #calibrate() {
    if (this.#measured || this.broken) return;
    this.#measured = true;
    const choice = this.name === "WebGPU" ? "webgpu" : "webgl";
    const variant = await selectVariant(choice);
    if (this.#renderer) this.#renderer.variant = variant;
    this.#listener.changed();
  }

  /**
   * Load a scene. It replaces the previous one, which stays if loading fails. Loading may start before
   * the renderer exists.
   *
   * @param {Request} request
   * @param {boolean} [again] whether the preloaded worker failed, so that the viewer starts its own
   */
  load(request, again = false) {
    this.#loading?.terminate();
    this.request = request;
    const worker = loadingWorker(request, async ({ data }) => {
      if (!(await this.#ready)) {
        worker.terminate();
        return;
      }
      // messages of a terminated worker may still arrive
      if (worker === this.#loading || worker === this.#worker) this.#receive(data, worker);
    });
    worker.onerror = (event) => {
      event.preventDefault();
      if (!again && worker === this.#loading) this.load(request, true);
      else this.#fail("the viewer's own files could not be loaded: reload the page", worker);
    };
    this.#loading = this.#latest = worker;
  }

  /**
   * Sort a sorted scene for exactly this camera, and upload the order.
   *
   * Throws an Error if the scene or the renderer is lost meanwhile.
   *
   * @param {Camera} camera
   * @returns {Promise<number | null>} milliseconds from the request to the uploaded order; null: the
   *     scene is not sorted
   */
  async sort(camera) {
    if (this.#sortSchedule.by === "") return null;
    if (this.broken) throw new Error("the renderer was lost"); // then orders are ignored
    if (this.#sortSchedule.pending) await this.#order(); // that of an earlier camera
    const began = performance.now();
    this.#sortSchedule.invalidate();
    this.#requestOrder(camera);
    if (this.#sortSchedule.pending) await this.#order();
    return performance.now() - began;
  }

  /** Wait for the worker's next order. @returns {Promise<void>} */
  #order() {
    return new Promise((resolve, reject) => (this.#waiting = { resolve, reject }));
  }

  /** No order will come. @param {string} sentence */
  #abandon(sentence) {
    this.#waiting?.reject(new Error(sentence));
    this.#waiting = null;
  }

  /**
   * Render; throws an Error if it cannot.
   *
   * @param {Camera} camera the scene's near plane replaces its own
   * @param {number} [supersampling] of the renderer
   */
  draw(camera, supersampling = 1) {
    if (this.#worker === null) return;
    const seen = { ...camera, near: this.near };
    if (this.#dots) {
      this.#renderer?.drawDots(seen);
      void this.#warmUp();
      return;
    }
    this.#requestOrder(camera);
    if (!this.#renderer) return;
    this.#renderer.supersampling = supersampling;
    this.#renderer.draw(seen);
    this.#renderer.supersampling = 1;
  }

  /** The context of a renderer that uses WebGL2; null: it uses WebGPU, or there is none. */
  get context() {
    return this.#webgl?.context ?? null;
  }

  /** @returns {import("../render/webgl.js").WebGlRenderer | null} */
  get #webgl() {
    return this.#renderer && "context" in this.#renderer ? this.#renderer : null;
  }

  /**
   * Render into parts of a framebuffer of WebGL2: the eyes of a headset. A sorted scene has one order for all. Reports
   * an error once.
   *
   * @param {{camera: Camera, target: Target}[]} eyes
   * @param {number} coarseness factor of `levelSigma`
   * @param {number[] | null} crop of the renderer
   */
  drawEyes(eyes, coarseness, crop) {
    const renderer = this.#webgl;
    if (this.#worker === null || this.broken || !renderer) return;
    if (!this.#dots) this.#requestOrder(eyes[0].camera);
    const { levelSigma } = renderer;
    if (levelSigma) renderer.levelSigma = Math.max(LEAST_SIGMA, coarseness * levelSigma);
    renderer.crop = crop;
    try {
      for (const { camera, target } of eyes) {
        const seen = { ...camera, near: Math.max(camera.near, this.near) };
        if (this.#dots) renderer.drawDots(seen, target);
        else renderer.draw(seen, target);
      }
    } catch (error) {
      this.#break(messageOf(error));
    }
    renderer.crop = null;
    renderer.levelSigma = levelSigma;
    if (this.#dots) void this.#warmUp();
  }

  /** Compile the shaders of scenes after the first image of dots. */
  async #warmUp() {
    const renderer = this.#renderer;
    if (this.#warm || this.#sorting || !renderer) return;
    this.#warm = true;
    await new Promise((later) => setTimeout(later, WARM_UP_DELAY));
    // a device that fails here also fails when it renders, and reports it then
    if (this.#dots && !this.#destroyed) await warmUp(renderer).catch(() => {});
  }

  /** Render; report an error once. @param {Camera} camera @param {number} supersampling */
  drawOrReport(camera, supersampling) {
    if (this.broken) return;
    try {
      this.draw(camera, supersampling);
    } catch (error) {
      this.#break(messageOf(error));
    }
  }

  /** Wait until all submitted work is rendered. */
  async finished() {
    await this.#renderer?.finished();
  }

  /** The image as RGBA floats. @param {Camera} camera @returns {Promise<Float32Array>} */
  pixels(camera) {
    const shown = this.#worker && !this.#dots ? this.#renderer?.pixels(camera) : null;
    return shown ?? Promise.reject(new Error("nothing can be drawn"));
  }

  /** Do not render some Gaussians of an editable `.mgs`. @param {Uint8Array} hidden 1 for those, by Gaussian */
  hide(hidden) {
    const lobes = this.#lobes.slice();
    for (let i = 0, at = 0; at < lobes.length; i++, at += this.#lobeStride) {
      if (hidden[i]) lobes[at] = INVISIBLE | (lobes[at] & 0xffff0000);
    }
    this.#renderer?.update("lobes", 0, lobes);
    recordLogits(this.logits, this.#lobeStride, 0, lobes);
    this.#listener.ordered();
  }

  /** The chosen background, or the scene's own. @returns {Vector} sRGB in [0, 1] */
  get background() {
    return /** @type {Vector} */ (this.#chosen ?? this.#background);
  }

  /** @param {Vector | null} color sRGB in [0, 1], or null for the scene's own */
  set background(color) {
    this.#chosen = color;
    // renderers keep this array and read it in every frame
    this.background.forEach((value, i) => (this.#drawn[i] = value));
  }

  /** Means of the rendered Gaussians, world units, 3 each; converted at the first use. */
  get means() {
    return (this.#storedMeans = worldMeans(this.#storedMeans));
  }

  /** Milliseconds of each pass of a timed frame; null where the device has no timer. */
  get milliseconds() {
    return this.#renderer?.milliseconds ?? null;
  }

  /** Request the pass times of the last frame, and now and then its fragments, unless a request is pending. */
  async time() {
    if (this.#timing || !this.#renderer) return;
    this.#timing = true;
    // a lost device is reported elsewhere
    await this.#renderer.time().catch(() => {});
    if (performance.now() > this.#counted + COUNT_EVERY) {
      this.fragments = await this.countFragments();
      this.#counted = performance.now();
    }
    this.#timing = false;
  }

  /** Fragments per pixel of the last frame by level; null without one. @returns {Promise<number[] | null>} */
  async countFragments() {
    if (this.#dots || this.broken) return null;
    return (await this.#renderer?.fragments().catch(() => null)) ?? null;
  }

  /** Renderer, adapter and variant in words. */
  get device() {
    const { floats, strips } = this.#renderer?.variant ?? { floats: false, strips: false };
    const variant = `${floats ? "floats" : "halves"}, ${strips ? "strips" : "batches"}`;
    const { by } = this.#sortSchedule;
    const adapter = this.#renderer?.describe() ?? "";
    return { renderer: this.name, adapter, variant, sorted: by !== "", sorted_by: by || null };
  }

  destroy() {
    this.#destroyed = this.broken = true;
    this.#abandon("the renderer was lost");
    this.#loading?.terminate();
    this.#worker?.terminate();
    this.#renderer?.destroy();
    this.#renderer = null;
  }

  /** @param {string} sentence */
  #break(sentence) {
    this.broken = true;
    this.#abandon(sentence);
    this.#listener.broken(sentence);
  }

  /** @param {Message} message @param {Worker} worker that sent it */
  #receive(message, worker) {
    // ignore more data of a scene that cannot be rendered
    if (this.broken && worker === this.#worker) return;
    if (message.kind === "failed") this.#fail(message.sentence, worker);
    else if (message.kind === "progress") {
      if (worker === this.#latest) this.#listener.progress(message.received / message.total);
    } else if (message.kind === "dots") this.#takeDots(message, worker);
    else if (message.kind === "scene") this.#take(message, worker);
    else if (message.kind === "rows") this.#takeRows(message);
    else if (message.kind === "more") this.#show(message.means);
    else if (message.kind === "order") this.#takeOrder(message.order);
    else {
      if (this.#sortSchedule.by !== "worker") worker.terminate(); // it has no work left
      // a device that fails here also fails when it renders, and reports it then
      if (!this.#loading) this.calibrated = this.#calibrate().catch(() => {});
      if (worker === this.#latest) this.#listener.loaded(message.milliseconds, message.bytes);
    }
  }

  /** @param {string} sentence @param {Worker} worker */
  #fail(sentence, worker) {
    const kept = worker === this.#loading && this.#shown !== null;
    if (worker === this.#worker) this.#abandon(sentence);
    if (worker === this.#loading) {
      this.#loading = null;
      this.request = this.#shown;
    }
    if (worker !== this.#worker || this.#sortSchedule.by !== "worker") worker.terminate();
    if (worker === this.#latest) this.#listener.failed(sentence, kept);
  }

  /** @param {Extract<Message, {kind: "dots"}>} message @param {Worker} worker */
  #takeDots({ dots, ...cameras }, worker) {
    if (this.patient && !this.count) {
      this.#dots = true; // until the scene: compile its shaders meanwhile
      void this.#warmUp();
      return;
    }
    this.#sortSchedule.reset("");
    const taken = this.#replace(worker, dots.background, () => this.#renderer?.setDots(dots));
    if (!taken) return;
    this.#dots = true;
    this.#setCameras(cameras);
    this.logits = new Float32Array(dots.means.length / 3);
    this.#show(dots.means);
    if (!this.#reloaded) this.#listener.arrived();
  }

  /** @param {Extract<Message, {kind: "scene"}>} message @param {Worker} worker */
  #take({ data, means, ...cameras }, worker) {
    const more = worker === this.#worker; // of the scene that is shown
    this.#sortSchedule.reset(data.sorted ? "worker" : this.#sorting ? "page" : "");
    data.sorted = this.#sortSchedule.by !== "";
    const taken = this.#replace(worker, data.background, () => {
      if (!this.#renderer) return;
      this.#renderer.setDots(null);
      this.#renderer.setScene(data);
      this.#renderer.levelSigma = this.#levels ?? usualLevelSigma(data.footprint);
    });
    if (!taken) return;
    this.#dots = false;
    this.#setCameras(cameras);
    this.logits = new Float32Array(data.count);
    this.total = data.count;
    this.#lobeStride = strides(data).lobes;
    if (this.editable && data.lobes instanceof Uint32Array) this.#lobes = data.lobes;
    recordLogits(this.logits, this.#lobeStride, 0, data.lobes);
    this.#show(means);
    if (!more && !this.#reloaded) this.#listener.arrived();
  }

  /**
   * Pass another scene to the renderer; report it if that fails.
   *
   * @param {Worker} worker whose scene it is
   * @param {Vector} background read in every frame
   * @param {() => void} give
   */
  #replace(worker, background, give) {
    if (worker !== this.#worker) {
      this.#worker?.terminate();
      this.#abandon("another scene was opened");
    }
    this.#worker = worker;
    if (worker === this.#loading) {
      this.#reloaded = this.request === this.#shown && this.count > 0;
      this.#shown = this.request;
      this.#loading = null;
    }
    this.#background = [...background];
    this.#drawn = background;
    this.background = this.#chosen;
    if (this.#renderer?.lost) {
      this.#break(this.#renderer.lost);
      return false;
    }
    try {
      give();
    } catch (error) {
      worker.terminate();
      this.#worker = null; // its messages that are on the way would hide the error
      this.#sortSchedule.reset("");
      this.count = 0;
      this.#listener.failed(messageOf(error));
      return false;
    }
    this.broken = false;
    return true;
  }

  /** @param {import("../load/worker.js").Cameras} cameras */
  #setCameras({ views, near, up, notes }) {
    this.views = views;
    this.near = near;
    this.up = up;
    this.notes = notes;
  }

  /** Render the first Gaussians of the scene, as many as there are means. @param {StoredMeans} means */
  #show(means) {
    this.#storedMeans = means;
    this.count = ("stored" in means ? means.stored : means).length / 3;
    this.#renderer?.show(this.count);
    this.#sortSchedule.invalidate();
    this.#listener.changed();
  }

  /** @param {Extract<Message, {kind: "rows"}>} message */
  #takeRows({ part, from, numbers }) {
    this.#renderer?.update(part, from, numbers);
    if (part === "lobes") {
      if (this.#lobes.length) this.#lobes.set(numbers, from * this.#lobeStride);
      recordLogits(this.logits, this.#lobeStride, from, numbers);
    }
    this.#listener.changed();
  }

  /** @param {Uint32Array<ArrayBuffer>} order */
  #takeOrder(order) {
    this.#sortSchedule.received();
    this.#renderer?.setOrder(order);
    this.#waiting?.resolve();
    this.#waiting = null;
    this.#listener.ordered();
  }

  /** Request another order if the scene is sorted and the direction has changed. @param {Camera} camera */
  #requestOrder(camera) {
    const forward = this.#sortSchedule.neededDirection(camera);
    if (forward === null) return;
    if (this.#sortSchedule.by === "page") this.#renderer?.setOrder(backToFront(this.means, forward));
    else this.#worker?.postMessage({ forward });
  }
}

/** @param {unknown} error */
const messageOf = (error) => (error instanceof Error ? error.message : String(error));
