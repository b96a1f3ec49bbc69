/** A scene in a canvas: how it arrives, what it is drawn with, and in which order if it needs one. */

import { loadingWorker } from "../files.js";
import { farFirst } from "../load/order.js";
import { centersOf } from "../mgs/positions.js";
import { knownVariant, warmUp, warmUpDots } from "../render/calibrate.js";
import { chooseRenderer } from "../render/choose.js";
import { strides } from "../render/types.js";
import { fastestHere, storage } from "./fastest.js";
import { Ordering } from "./ordering.js";
import { noteLogits } from "./pick.js";

/** @typedef {import("../load/worker.js").Message} Message */
/** @typedef {import("../load/worker.js").Request} Request */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../mgs/positions.js").Places} Places */
/** @typedef {import("../render/choose.js").Choice} Choice */
/** @typedef {import("../render/choose.js").Renderer} Renderer */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("./vector.js").Vector} Vector */
/**
 * @typedef {object} Told what a layer tells
 * @property {(share: number) => void} progress of the file, 0 to 1; NaN while its size is not known
 * @property {() => void} arrived there is another scene, of which more may come
 * @property {() => void} changed there is more to see of it
 * @property {() => void} ordered it has the order that it was last seen to need
 * @property {(milliseconds: number, bytes: number) => void} loaded everything is decoded
 * @property {(sentence: string, kept?: boolean) => void} failed `kept`: the scene before stays
 * @property {(sentence: string) => void} broken what draws cannot go on
 */

const AFTER = 50; // milliseconds that a first picture has to come onto the screen

export class Layer {
  /** Gaussians of the scene. */
  count = 0;
  /** The cameras that it was taken with, as far as its file has them. @type {View[]} */
  views = [];
  near = 0.2;
  /** What a double click looks through, beside `centers`: logits of mean opacities. */
  logits = new Float32Array(0);
  /** What is on its way, else what is shown. @type {Request | null} */
  request = null;
  /** Settles when it is known how to draw fastest: it takes its time behind the first scene. */
  calibrated = Promise.resolve();

  name = ""; // of the renderer
  /** Whether it failed with the scene that is there. */
  broken = false;

  #places = /** @type {Places} */ (new Float32Array(0));
  #variant;
  #measured = false; // or known, or about to be
  #sorting;
  #told;
  /** @type {Renderer | null} */
  #renderer = null;
  /** Of the scene that is shown. @type {Worker | null} */
  #worker = null;
  /** Of the one that shall take its place. @type {Worker | null} */
  #coming = null;
  /** Of what was asked for last. @type {Worker | null} */
  #last = null;
  /** Whether there is a way to draw. */
  #ready = Promise.resolve(false);
  #destroyed = false;
  /** @type {Request | null} */
  #shown = null;
  #again = false; // the scene was there before, and the renderer had lost it
  #lobeStride = 2;
  /** Behind everything: what the scene says, what was wished for, and what the renderer reads. */
  #own = [0, 0, 0];
  /** @type {Vector | null} */
  #wished = null;
  #drawn = [0, 0, 0];
  #ordering = new Ordering();
  #timing = false;
  #dots = false; // whether they are all that there is to draw
  #warm = false; // whether the shaders of scenes are compiled, or about to be

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Told} told
   * @param {Variant | null} variant how to draw; null: as the device is fastest
   * @param {boolean} sorting whether scenes that add up are drawn sorted all the same
   */
  constructor(canvas, told, variant, sorting) {
    this.canvas = canvas;
    this.#told = told;
    this.#variant = variant;
    this.#sorting = sorting;
  }

  /** Looks for a way to draw. @param {Choice} choice @returns {Promise<boolean>} whether there is */
  begin(choice) {
    return (this.#ready = this.#open(choice));
  }

  /** @param {Choice} choice @returns {Promise<boolean>} */
  async #open(choice) {
    try {
      const { name, renderer } = await chooseRenderer(this.canvas, choice);
      if (this.#destroyed) {
        renderer.destroy();
        return false;
      }
      renderer.onLost = (sentence) => this.#break(sentence);
      if ("onRestored" in renderer) {
        renderer.onRestored = () => this.request && this.load(this.request);
      }
      const wished = renderer.variants.find(
        ({ floats, strips }) => floats === this.#variant?.floats && strips === this.#variant.strips,
      );
      const known = wished ?? knownVariant(renderer, storage());
      if (known) renderer.variant = known;
      this.#measured = known !== null;
      this.#renderer = renderer;
      this.name = name;
      warmUpDots(renderer);
      return true;
    } catch (error) {
      this.#told.failed(sentenceOf(error));
      return false;
    }
  }

  /** Finds out how to draw. */
  async #calibrate() {
    if (this.#measured || this.broken) return;
    this.#measured = true;
    const choice = this.name === "WebGPU" ? "webgpu" : "webgl";
    const variant = await fastestHere(choice);
    if (this.#renderer) this.#renderer.variant = variant;
    this.#told.changed();
  }

  /**
   * Loads a scene in the place of the one before, which stays if that fails. It may begin while
   * there is nothing to draw with yet.
   *
   * @param {Request} request
   * @param {boolean} [again] in a thread of the viewer's own, after one that the page had begun
   */
  load(request, again = false) {
    this.#coming?.terminate();
    this.request = request;
    const worker = loadingWorker(request, async ({ data }) => {
      if (!(await this.#ready)) {
        worker.terminate();
        return;
      }
      // what an old worker has sent before its end still arrives
      if (worker === this.#coming || worker === this.#worker) this.#receive(data, worker);
    });
    worker.onerror = (event) => {
      event.preventDefault();
      if (!again && worker === this.#coming) this.load(request, true);
      else this.#fail("the viewer's own files could not be loaded: reload the page", worker);
    };
    this.#coming = this.#last = worker;
  }

  /** Throws if it cannot. @param {Camera} camera whose near plane the scene may have another opinion of */
  draw(camera) {
    if (this.#worker === null) return;
    const seen = { ...camera, near: this.near };
    if (this.#dots) {
      this.#renderer?.drawDots(seen);
      void this.#warmUp();
      return;
    }
    this.#askOrder(camera);
    this.#renderer?.draw(seen);
  }

  /** Has the shaders of scenes compiled, behind the first picture of dots. */
  async #warmUp() {
    const renderer = this.#renderer;
    if (this.#warm || this.#sorting || !renderer) return;
    this.#warm = true;
    await new Promise((later) => setTimeout(later, AFTER));
    // a device that fails here fails elsewhere as well
    if (this.#dots && !this.#destroyed) await warmUp(renderer).catch(() => {});
  }

  /** Draws; what goes wrong is told, once. @param {Camera} camera */
  drawOrTell(camera) {
    if (this.broken) return;
    try {
      this.draw(camera);
    } catch (error) {
      this.#break(sentenceOf(error));
    }
  }

  /** Waits until everything that was asked for is drawn. */
  async finished() {
    await this.#renderer?.finished();
  }

  /** A picture as numbers, as renderers give it. @param {Camera} camera @returns {Promise<Float32Array>} */
  pixels(camera) {
    const shown = this.#worker && !this.#dots ? this.#renderer?.pixels(camera) : null;
    return shown ?? Promise.reject(new Error("nothing can be drawn"));
  }

  /** Of the scene, or what was wished for. @returns {Vector} sRGB in [0, 1] */
  get background() {
    return /** @type {Vector} */ (this.#wished ?? this.#own);
  }

  /** @param {Vector | null} color sRGB in [0, 1], or null for the scene's own */
  set background(color) {
    this.#wished = color;
    // renderers keep this very array, and read it for every frame
    this.background.forEach((value, i) => (this.#drawn[i] = value));
  }

  /** Centres of the Gaussians that are drawn, x, y, z each: in the world once somebody asks for them. */
  get centers() {
    return (this.#places = centersOf(this.#places));
  }

  /** Milliseconds of the passes of a frame that was timed; null where the device does not tell. */
  get milliseconds() {
    return this.#renderer?.milliseconds ?? null;
  }

  /** Asks what the passes of the last frame took, unless that is being found out. */
  async time() {
    if (this.#timing || !this.#renderer) return;
    this.#timing = true;
    // a device that is lost meanwhile says so itself
    await this.#renderer.time().catch(() => {});
    this.#timing = false;
  }

  /** What draws, in words. */
  get device() {
    const { floats, strips } = this.#renderer?.variant ?? { floats: false, strips: false };
    const variant = `${floats ? "floats" : "halves"}, ${strips ? "strips" : "batches"}`;
    const sorted = this.#ordering.by !== "";
    return { renderer: this.name, adapter: this.#renderer?.describe() ?? "", variant, sorted };
  }

  destroy() {
    this.#destroyed = this.broken = true;
    this.#coming?.terminate();
    this.#worker?.terminate();
    this.#renderer?.destroy();
    this.#renderer = null;
  }

  /** @param {string} sentence */
  #break(sentence) {
    this.broken = true;
    this.#told.broken(sentence);
  }

  /** @param {Message} message @param {Worker} worker that sent it */
  #receive(message, worker) {
    // what else there is to say of a scene that cannot be drawn is of no use
    if (this.broken && worker === this.#worker) return;
    if (message.kind === "failed") this.#fail(message.sentence, worker);
    else if (message.kind === "progress") {
      if (worker === this.#last) this.#told.progress(message.received / message.total);
    } else if (message.kind === "dots") this.#takeDots(message, worker);
    else if (message.kind === "scene") this.#take(message, worker);
    else if (message.kind === "rows") this.#takeRows(message);
    else if (message.kind === "more") this.#show(message.places);
    else if (message.kind === "order") this.#takeOrder(message.order);
    else {
      if (this.#ordering.by !== "worker") worker.terminate(); // it has nothing left to do
      // a device that fails here fails elsewhere as well, and is told of then
      if (!this.#coming) this.calibrated = this.#calibrate().catch(() => {});
      if (worker === this.#last) this.#told.loaded(message.milliseconds, message.bytes);
    }
  }

  /** @param {string} sentence @param {Worker} worker */
  #fail(sentence, worker) {
    const kept = worker === this.#coming && this.#shown !== null;
    if (worker === this.#coming) {
      this.#coming = null;
      this.request = this.#shown;
    }
    if (worker !== this.#worker || this.#ordering.by !== "worker") worker.terminate();
    if (worker === this.#last) this.#told.failed(sentence, kept);
  }

  /** @param {Extract<Message, {kind: "dots"}>} message @param {Worker} worker */
  #takeDots({ dots, views, near }, worker) {
    this.#ordering.begin("");
    const taken = this.#replace(worker, dots.background, () => this.#renderer?.setDots(dots));
    if (!taken) return;
    this.#dots = true;
    this.#lookFrom(views, near);
    this.logits = new Float32Array(dots.centers.length / 3);
    this.#show(dots.centers);
    if (!this.#again) this.#told.arrived();
  }

  /** @param {Extract<Message, {kind: "scene"}>} message @param {Worker} worker */
  #take({ data, places, views, near }, worker) {
    const more = worker === this.#worker; // of the scene that is shown
    this.#ordering.begin(data.sorted ? "worker" : this.#sorting ? "page" : "");
    data.sorted = this.#ordering.by !== "";
    const taken = this.#replace(worker, data.background, () => {
      this.#renderer?.setDots(null);
      this.#renderer?.setScene(data);
    });
    if (!taken) return;
    this.#dots = false;
    this.#lookFrom(views, near);
    this.logits = new Float32Array(data.count);
    this.#lobeStride = strides(data).lobes;
    noteLogits(this.logits, this.#lobeStride, 0, data.lobes);
    this.#show(places);
    if (!more && !this.#again) this.#told.arrived();
  }

  /**
   * Gives the renderer something else to draw, and tells if it does not take it.
   *
   * @param {Worker} worker whose scene it is
   * @param {Vector} background read for every frame
   * @param {() => void} give
   */
  #replace(worker, background, give) {
    if (worker !== this.#worker) this.#worker?.terminate();
    this.#worker = worker;
    if (worker === this.#coming) {
      this.#again = this.request === this.#shown && this.count > 0;
      this.#shown = this.request;
      this.#coming = null;
    }
    this.#own = [...background];
    this.#drawn = background;
    this.background = this.#wished;
    if (this.#renderer?.lost) {
      this.#break(this.#renderer.lost);
      return false;
    }
    try {
      give();
    } catch (error) {
      worker.terminate();
      this.count = 0;
      this.#told.failed(sentenceOf(error));
      return false;
    }
    this.broken = false;
    return true;
  }

  /** @param {View[]} views @param {number} near */
  #lookFrom(views, near) {
    this.views = views;
    this.near = near;
  }

  /** Draws the Gaussians that are at these places, the first ones of the scene. @param {Places} places */
  #show(places) {
    this.#places = places;
    this.count = ("stored" in places ? places.stored : places).length / 3;
    this.#renderer?.show(this.count);
    this.#ordering.renew();
    this.#told.changed();
  }

  /** @param {Extract<Message, {kind: "rows"}>} message */
  #takeRows({ part, from, numbers }) {
    this.#renderer?.update(part, from, numbers);
    if (part === "lobes") noteLogits(this.logits, this.#lobeStride, from, numbers);
    this.#told.changed();
  }

  /** @param {Uint32Array<ArrayBuffer>} order */
  #takeOrder(order) {
    this.#ordering.arrived();
    this.#renderer?.setOrder(order);
    this.#told.ordered();
  }

  /** Asks for another order when the scene needs one and is seen from another side. @param {Camera} camera */
  #askOrder(camera) {
    const forward = this.#ordering.needed(camera);
    if (forward === null) return;
    if (this.#ordering.by === "page") this.#renderer?.setOrder(farFirst(this.centers, forward));
    else this.#worker?.postMessage({ forward });
  }
}

/** @param {unknown} error */
const sentenceOf = (error) => (error instanceof Error ? error.message : String(error));
