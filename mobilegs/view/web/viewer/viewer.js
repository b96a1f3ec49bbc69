/** A scene in a canvas: loads it, draws what changes, follows the input. */

import { loadingWorker } from "../files.js";
import { chooseRenderer } from "../render/choose.js";
import { Input } from "./input.js";
import { placeUnder } from "./pick.js";
import { Pose, cameraOf } from "./pose.js";
import { Resolution } from "./resolution.js";
import { dot } from "./vector.js";

/** @typedef {import("../load/worker.js").Message} Message */
/** @typedef {import("../load/worker.js").Request} Request */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/choose.js").Choice} Choice */
/** @typedef {import("../render/choose.js").Renderer} Renderer */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("./vector.js").Vector} Vector */
/**
 * @typedef {object} Listener what a viewer tells
 * @property {(share: number) => void} progress of the file, 0 to 1; NaN while its size is not known
 * @property {(milliseconds: number) => void} loaded everything is decoded
 * @property {(sentence: string) => void} failed
 * @property {(stats: Stats) => void} drawn
 */
/**
 * @typedef {object} Stats
 * @property {string} renderer
 * @property {number} count Gaussians
 * @property {number} width pixels drawn
 * @property {number} height
 * @property {number} milliseconds from one frame to the next, while something moves
 * @property {Record<string, number> | null} passes milliseconds of the device, where it tells
 */

const LINGER = 150; // milliseconds after an input in which things still count as moving
const SAME_SIDE = Math.cos((0.5 * Math.PI) / 180); // an order serves all directions as near as that

export class Viewer {
  /** What dragging does. @type {"orbit" | "fly"} */
  mode = "orbit";
  /** @type {Pose} */
  pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  /** Whether the device is asked what each pass took. */
  timed = false;

  #canvas;
  #listener;
  #resolution;
  /** @type {Renderer | null} */
  #renderer = null;
  #name = "";
  /** Of the scene that is shown. @type {Worker | null} */
  #worker = null;
  /** Of the one that shall take its place. @type {Worker | null} */
  #coming = null;
  /** What was asked for last. @type {Request | null} */
  #request = null;
  #destroyed = false;
  #input;
  #start = this.pose;
  /** @type {View[]} */
  #views = [];
  #near = 0.2;
  #count = 0;
  /** What a double click looks through: centres and logits of mean opacities. */
  #centers = new Float32Array(0);
  #logits = new Float32Array(0);
  #lobeStride = 2;
  #sorted = false; // whether the scene needs an order
  #ordering = false; // whether one was asked for
  /** Direction of looking that the order is for. @type {Vector | null} */
  #ordered = null;
  #placed = false; // the pose was set from outside
  #asked = 0; // animation frame
  #last = 0; // time of the last frame
  #touched = -Infinity; // time of the last input
  #moving = false; // whether the last frame followed input
  #rest = 0; // timer that draws sharply when nothing moves any more
  #resize;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Listener} listener
   * @param {{scale?: number | null}} [options]
   */
  constructor(canvas, listener, { scale = null } = {}) {
    this.#canvas = canvas;
    this.#listener = listener;
    this.#resolution = new Resolution(scale);
    this.#input = new Input(canvas, {
      pose: () => this.pose,
      mode: () => this.mode,
      changed: () => {
        this.#touched = performance.now();
        this.redraw();
      },
      focus: (x, y) => this.#focus(x, y),
    });
    this.#resize = new ResizeObserver(() => this.redraw());
    this.#resize.observe(canvas);
  }

  /** Looks for a way to draw. @param {Choice} choice @returns {Promise<boolean>} whether there is */
  async begin(choice) {
    try {
      const { name, renderer } = await chooseRenderer(this.#canvas, choice);
      if (this.#destroyed) {
        renderer.destroy();
        return false;
      }
      renderer.onLost = (sentence) => this.#listener.failed(sentence);
      if ("onRestored" in renderer) {
        renderer.onRestored = () => this.#request && this.load(this.#request);
      }
      this.#renderer = renderer;
      this.#name = name;
      return true;
    } catch (error) {
      this.#listener.failed(error instanceof Error ? error.message : String(error));
      return false;
    }
  }

  /** Loads a scene in the place of the one before, which stays if that fails. @param {Request} request */
  load(request) {
    this.#coming?.terminate();
    if (this.#request && this.#request !== request) this.#placed = false; // that was another place
    this.#request = request;
    const worker = loadingWorker();
    worker.onmessage = ({ data }) => {
      // what an old worker has sent before its end still arrives
      if (worker === this.#coming || worker === this.#worker) this.#receive(data, worker);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      this.#listener.failed("the viewer's own files could not be loaded: reload the page");
    };
    this.#coming = worker;
    worker.postMessage(request);
  }

  /** Draws soon. */
  redraw() {
    if (!this.#asked) this.#asked = requestAnimationFrame((time) => this.#frame(time));
  }

  /** Back to where the scene was first seen from, or to another training camera. @param {number} [index] */
  reset(index) {
    const views = this.#views;
    this.pose =
      index === undefined || views.length === 0
        ? this.#start.copy()
        : Pose.fromViews(views, ((index % views.length) + views.length) % views.length);
    this.redraw();
  }

  /** Takes a pose that scenes that arrive later keep. @param {Pose} pose */
  place(pose) {
    this.pose = pose;
    this.#placed = true;
    this.redraw();
  }

  /** The camera of a frame of the given size. @param {number} width @param {number} height @returns {Camera} */
  camera(width, height) {
    return cameraOf(this.pose, this.#views[0] ?? null, width, height, this.#near);
  }

  /** The cameras that the scene was taken with, as far as its file has them. */
  get views() {
    return this.#views;
  }

  /** Gaussians of the scene. */
  get count() {
    return this.#count;
  }

  /** What draws, in words. */
  get device() {
    return { renderer: this.#name, adapter: this.#renderer?.describe() ?? "" };
  }

  /** Draws a frame of a given size and waits until it is done. @param {number} width @param {number} height */
  async drawAndWait(width, height) {
    this.#askOrder();
    this.#renderer?.draw(this.camera(width, height));
    await this.#renderer?.finished();
  }

  /** Milliseconds that each pass of the last frame took; null where the device does not tell. */
  async passes() {
    if (!this.#renderer || !("time" in this.#renderer)) return null;
    await this.#renderer.time();
    return this.#renderer.milliseconds;
  }

  /** A picture as numbers, as renderers give it. @param {Camera} camera @returns {Promise<Float32Array>} */
  pixels(camera) {
    return this.#renderer?.pixels(camera) ?? Promise.reject(new Error("nothing can be drawn"));
  }

  /** The picture at its present size, as a PNG. @returns {Promise<Blob | null>} */
  screenshot() {
    this.#draw();
    return new Promise((resolve) => this.#canvas.toBlob(resolve, "image/png"));
  }

  destroy() {
    this.#destroyed = true;
    cancelAnimationFrame(this.#asked);
    clearTimeout(this.#rest);
    this.#coming?.terminate();
    this.#worker?.terminate();
    this.#input.destroy();
    this.#resize.disconnect();
    this.#renderer?.destroy();
    this.#renderer = null;
  }

  /** @param {Message} message @param {Worker} worker that sent it */
  #receive(message, worker) {
    if (message.kind === "failed") this.#listener.failed(message.sentence);
    else if (message.kind === "progress") this.#listener.progress(message.received / message.total);
    else if (message.kind === "scene") this.#take(message, worker);
    else if (message.kind === "rows") this.#takeRows(message);
    else if (message.kind === "order") this.#takeOrder(message.order);
    else this.#listener.loaded(message.milliseconds);
  }

  /** @param {Extract<Message, {kind: "scene"}>} message @param {Worker} worker */
  #take({ data, views, near }, worker) {
    const { count, shapes } = data;
    this.#worker?.terminate();
    this.#worker = worker;
    this.#coming = null;
    try {
      this.#renderer?.setScene(data);
    } catch (error) {
      worker.terminate();
      this.#count = 0;
      this.#listener.failed(error instanceof Error ? error.message : String(error));
      return;
    }
    this.#count = count;
    this.#near = near;
    this.#views = views;
    this.#sorted = data.sorted;
    this.#ordered = null;
    this.#ordering = false;
    this.#centers = new Float32Array(3 * count);
    for (let i = 0; i < 3 * count; i++) this.#centers[i] = shapes[4 * i + 3];
    this.#logits = new Float32Array(count);
    this.#lobeStride = 2 * data.lobeSize;
    this.#noteLobes(0, data.lobes);
    this.#start = views.length ? Pose.fromViews(views) : Pose.around(this.#centers);
    if (!this.#placed) this.reset();
    this.redraw();
  }

  /** @param {Extract<Message, {kind: "rows"}>} message */
  #takeRows({ part, from, numbers }) {
    this.#renderer?.update(part, from, numbers);
    if (part === "lobes") this.#noteLobes(from, numbers);
    this.redraw();
  }

  /** @param {Uint32Array<ArrayBuffer>} order */
  #takeOrder(order) {
    this.#ordering = false;
    this.#renderer?.setOrder(order);
    this.redraw();
  }

  /** Asks for another order when the scene needs one and is seen from another side. */
  #askOrder() {
    const { forward } = this.pose;
    const turned = this.#ordered === null || dot(forward, this.#ordered) < SAME_SIDE;
    if (!this.#sorted || this.#ordering || !turned) return;
    this.#ordering = true;
    this.#ordered = forward;
    this.#worker?.postMessage({ forward });
  }

  /** @param {number} from @param {Float32Array} lobes */
  #noteLobes(from, lobes) {
    const stride = this.#lobeStride;
    for (let i = 0; i * stride < lobes.length; i++) this.#logits[from + i] = lobes[i * stride];
  }

  /** @param {number} time */
  #frame(time) {
    this.#asked = 0;
    const since = time - this.#last;
    this.#last = time;
    const followed = this.#moving; // then the time between the two frames is that of one
    this.#moving = performance.now() - this.#touched < LINGER || this.#input.busy;
    if (!this.#moving) this.#resolution.pause();
    else if (followed) this.#resolution.note(since);
    this.#input.advance(Math.min(since, 100) / 1000);
    const { width, height } = this.#draw();
    clearTimeout(this.#rest);
    if (this.#moving) this.#rest = setTimeout(() => this.redraw(), 2 * LINGER);
    if (this.#renderer && this.#count) {
      const passes = "milliseconds" in this.#renderer ? this.#renderer.milliseconds : null;
      const milliseconds = this.#moving && followed ? since : 0;
      this.#listener.drawn({ renderer: this.#name, count: this.#count, width, height, milliseconds, passes });
      if (this.timed && "time" in this.#renderer) void this.#renderer.time();
    }
    if (this.#input.busy) this.redraw();
  }

  #draw() {
    const { clientWidth, clientHeight } = this.#canvas;
    this.#askOrder();
    const size = this.#resolution.size(clientWidth, clientHeight, devicePixelRatio, this.#moving);
    if (clientWidth && clientHeight) this.#renderer?.draw(this.camera(size.width, size.height));
    return size;
  }

  /** @param {number} x @param {number} y CSS pixels */
  #focus(x, y) {
    const { clientWidth, clientHeight } = this.#canvas;
    const camera = this.camera(clientWidth, clientHeight);
    const place = placeUnder(this.#centers, this.#logits, camera, x, y);
    if (place) this.pose.focus(place);
    this.redraw();
  }
}
