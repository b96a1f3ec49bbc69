/** One or two scenes seen by one camera: follows the input, draws what changes. */

import { Input } from "./input.js";
import { Layer } from "./layer.js";
import { placeUnder } from "./pick.js";
import { Pose, cameraOf } from "./pose.js";
import { Resolution } from "./resolution.js";

/** @typedef {import("../load/worker.js").Request} Request */
/** @typedef {import("../render/choose.js").Choice} Choice */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {0 | 1} Side the scene, or the one that it is compared with */
/**
 * @typedef {object} Listener what a viewer tells
 * @property {(side: Side, share: number) => void} progress of a file, 0 to 1; NaN while its size is
 *     not known
 * @property {(side: Side, milliseconds: number, bytes: number) => void} loaded everything is decoded
 * @property {(side: Side, sentence: string, kept?: boolean) => void} failed `kept`: the scene before stays
 * @property {(side: Side, sentence: string) => void} broken what draws cannot go on
 * @property {(stats: Stats) => void} drawn
 */
/**
 * @typedef {object} Stats
 * @property {string} renderer
 * @property {number} count Gaussians
 * @property {number} compared Gaussians of the other scene, or 0
 * @property {number} width pixels drawn
 * @property {number} height
 * @property {number} milliseconds from one frame to the next, while something moves
 * @property {Record<string, number> | null} passes milliseconds of the device, where it tells
 */

const PATIENCE = 100; // milliseconds between pictures of a scene that arrives and nobody moves
const LINGER = 150; // milliseconds after an input in which things still count as moving
const IDLE = (9 * Math.PI) / 180; // radians a second that a scene turns by itself

export class Viewer {
  /** What dragging does. @type {"orbit" | "fly"} */
  mode = "orbit";
  /** @type {Pose} */
  pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  /** Field of view in degrees, or null for that of the cameras. @type {number | null} */
  fov = null;
  /** Whether the device is asked what each pass took. */
  timed = false;
  /** Whether the scene turns by itself, until the first input. */
  turning = false;
  /** Whether frames are drawn for `drawAndWait` alone. */
  measured = false;

  #listener;
  #canvas;
  #variant;
  #first;
  /** @type {Layer | null} */
  #second = null;
  /** @type {Choice} */
  #choice = "auto";
  /** @type {Vector | null} */
  #wished = null; // background
  #resolution;
  #input;
  #start = this.pose;
  #placed = false; // the pose was set from outside
  #asked = 0; // animation frame
  #last = 0; // time of the last frame
  #touched = -Infinity; // time of the last input
  #moving = false; // whether the last frame followed input
  #soon = 0; // timer of a picture that can wait
  #rest = 0; // timer that draws sharply when nothing moves any more
  #resize;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Listener} listener
   * @param {{variant?: Variant | null}} [options] how to draw; null: as the device is fastest
   */
  constructor(canvas, listener, { variant = null } = {}) {
    this.#canvas = canvas;
    this.#listener = listener;
    this.#variant = variant;
    this.#resolution = new Resolution(null);
    this.#first = this.#layer(canvas, 0, false);
    this.#input = new Input(canvas, {
      pose: () => this.pose,
      mode: () => this.mode,
      held: () => (this.turning = false),
      changed: () => {
        this.#touched = performance.now();
        this.turning = false;
        this.redraw();
      },
      focus: (x, y) => this.#focus(x, y),
    });
    this.#resize = new ResizeObserver(() => this.redraw());
    this.#resize.observe(canvas);
  }

  /** Looks for a way to draw. @param {Choice} choice @returns {Promise<boolean>} whether there is */
  begin(choice) {
    this.#choice = choice;
    return this.#first.begin(choice);
  }

  /** Loads a scene in the place of the one before, which stays if that fails. @param {Request} request */
  load(request) {
    if (this.#first.request) this.#placed = false; // that was another place
    this.#first.load(request);
  }

  /**
   * Draws another scene as well, seen by the same camera.
   *
   * @param {HTMLCanvasElement} canvas as large as the first one
   * @param {Request} request
   * @param {boolean} sorting whether a scene that adds up is drawn sorted all the same
   */
  async compare(canvas, request, sorting) {
    this.alone();
    const layer = this.#layer(canvas, 1, sorting);
    layer.background = this.#wished;
    this.#second = layer;
    await this.#first.calibrated; // which a second one remembers
    if (layer !== this.#second) return;
    if ((await layer.begin(this.#choice)) && layer === this.#second) layer.load(request);
  }

  /** Ends the comparison. */
  alone() {
    this.#second?.destroy();
    this.#second = null;
  }

  /** Draws soon. */
  redraw() {
    if (!this.#asked && !this.measured) this.#asked = requestAnimationFrame((time) => this.#frame(time));
  }

  /** Back to where the scene was first seen from, or to another training camera. @param {number} [index] */
  reset(index) {
    const { views } = this;
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
    return cameraOf(this.pose, this.views[0] ?? null, width, height, this.#first.near, this.fov);
  }

  /** The cameras that the scene was taken with, as far as its file has them, or the other's. */
  get views() {
    return this.#first.views.length ? this.#first.views : (this.#second?.views ?? []);
  }

  /** Gaussians of the scene. */
  get count() {
    return this.#first.count;
  }

  /** Settles when it is known how to draw fastest: not before a scene is there. */
  get calibrated() {
    return this.#first.calibrated;
  }

  /** Where the scene comes from that is shown or on its way. @returns {string | Blob | null} */
  get source() {
    const { request } = this.#first;
    if (request === null || "forward" in request) return null;
    return "url" in request ? request.url : request.file;
  }

  /** What draws, in words. */
  get device() {
    return this.#first.device;
  }

  /** Share of the screen's pixels that is drawn, by side; null for as many as can be. */
  get scale() {
    return this.#resolution.fixed;
  }

  set scale(share) {
    this.#resolution = new Resolution(share);
    this.redraw();
  }

  /** What was chosen for it, for another viewer to take over. */
  get choices() {
    const { mode, fov, turning, scale, timed } = this;
    return { mode, fov, turning, scale, timed, background: this.#wished };
  }

  /** What lies behind the scene. @returns {Vector} sRGB in [0, 1] */
  get background() {
    return this.#first.background;
  }

  /** @param {Vector | null} color sRGB in [0, 1], or null for what each scene says */
  set background(color) {
    this.#wished = color;
    for (const layer of this.#layers) layer.background = color;
    this.redraw();
  }

  /** Draws a frame of a given size and waits until it is done; throws if it cannot. @param {number} width @param {number} height */
  async drawAndWait(width, height) {
    this.#first.draw(this.camera(width, height));
    await this.finished();
    if (this.#first.broken) throw new Error("what drew the scene was lost meanwhile");
  }

  /** Waits until everything that was asked for is drawn. */
  async finished() {
    await this.#first.finished();
  }

  /** Milliseconds that each pass of the last frame took; null where the device does not tell. */
  async passes() {
    await this.#first.time();
    return this.#first.milliseconds;
  }

  /** A picture as numbers, as renderers give it. @param {Camera} camera @param {Side} [side] */
  pixels(camera, side = 0) {
    const layer = this.#layers[side];
    return layer?.pixels(camera) ?? Promise.reject(new Error("there is no other scene"));
  }

  /**
   * The picture at its present size, as a PNG.
   *
   * @param {number} [share] of its width that shows the first of two scenes
   * @returns {Promise<Blob | null>}
   */
  screenshot(share = 1) {
    const { width, height } = this.#draw();
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = [width, height];
    const context = picture.getContext("2d");
    this.#layers.forEach(({ canvas }, side) => {
      const from = side * Math.round(share * width);
      const across = width - from;
      if (across > 0) context?.drawImage(canvas, from, 0, across, height, from, 0, across, height);
    });
    return new Promise((resolve) => picture.toBlob(resolve, "image/png"));
  }

  destroy() {
    cancelAnimationFrame(this.#asked);
    clearTimeout(this.#rest);
    clearTimeout(this.#soon);
    this.#input.destroy();
    this.#resize.disconnect();
    for (const layer of this.#layers) layer.destroy();
  }

  get #layers() {
    return this.#second ? [this.#first, this.#second] : [this.#first];
  }

  /** @param {HTMLCanvasElement} canvas @param {Side} side @param {boolean} sorting */
  #layer(canvas, side, sorting) {
    /** @type {import("./layer.js").Told} */
    const told = {
      progress: (share) => this.#listener.progress(side, share),
      arrived: () => this.#arrived(side),
      changed: () => {
        this.#soon ||= setTimeout(() => this.redraw(), PATIENCE);
      },
      ordered: () => this.redraw(),
      loaded: (milliseconds, bytes) => {
        this.#listener.loaded(side, milliseconds, bytes);
        this.redraw();
      },
      failed: (sentence, kept) => this.#listener.failed(side, sentence, kept),
      broken: (sentence) => this.#listener.broken(side, sentence),
    };
    return new Layer(canvas, told, this.#variant, sorting);
  }

  /** @param {Side} side */
  #arrived(side) {
    const { views } = this;
    // the other scene has a say only where the first has no cameras, and before anybody has moved
    const asked = side === 0 || (!this.#first.views.length && this.#touched === -Infinity);
    if (asked && (views.length || this.#first.count)) {
      this.#start = views.length ? Pose.fromViews(views) : Pose.around(this.#first.centers);
      if (!this.#placed) this.reset();
    }
    this.redraw();
  }

  /** @param {number} time */
  #frame(time) {
    this.#asked = 0;
    clearTimeout(this.#soon);
    this.#soon = 0;
    const since = time - this.#last;
    this.#last = time;
    const followed = this.#moving; // then the time between the two frames is that of one
    const turning = this.turning && this.count > 0;
    this.#moving = performance.now() - this.#touched < LINGER || this.#input.busy || turning;
    if (this.#moving && followed) this.#resolution.note(since);
    const seconds = Math.min(since, 100) / 1000;
    this.#input.advance(seconds);
    if (turning) this.pose.orbit(IDLE * seconds, 0);
    const { width, height } = this.#draw();
    clearTimeout(this.#rest);
    if (this.#moving) this.#rest = setTimeout(() => this.redraw(), 2 * LINGER);
    if (this.count && !this.#first.broken) {
      const { name, count, milliseconds: passes } = this.#first;
      const milliseconds = this.#moving && followed ? since : 0;
      const compared = this.#second?.count ?? 0;
      this.#listener.drawn({ renderer: name, count, compared, width, height, milliseconds, passes });
      if (this.timed) void this.#first.time();
    }
    if (this.#input.busy || turning) this.redraw();
  }

  #draw() {
    const { clientWidth, clientHeight } = this.#canvas;
    const size = this.#resolution.size(clientWidth, clientHeight, devicePixelRatio, this.#moving);
    if (clientWidth && clientHeight) {
      const camera = this.camera(size.width, size.height);
      for (const layer of this.#layers) layer.drawOrTell(camera);
    }
    return size;
  }

  /** @param {number} x @param {number} y CSS pixels */
  #focus(x, y) {
    const { clientWidth, clientHeight } = this.#canvas;
    const { centers, logits } = this.#first;
    const place = placeUnder(centers, logits, this.camera(clientWidth, clientHeight), x, y);
    if (place) this.pose.focus(place);
    this.redraw();
  }
}
