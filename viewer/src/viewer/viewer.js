/** Renders one or two scenes with one camera, and follows the input. */

import { excessOf, firstPose, limitsFor, parsedFloor, resist, spring } from "./framing.js";
import { Input } from "./input.js";
import { SceneView } from "./scene_view.js";
import { pointUnder } from "./pick.js";
import { Pose, cameraOf } from "./pose.js";
import { Resolution } from "./resolution.js";
import { supersamplingFor } from "./supersampling.js";
import { AXES, USUAL, nextAxis, parsedUp } from "./up.js";
import { dot, plus } from "./vector.js";

/** @typedef {import("../load/worker.js").Request} Request */
/** @typedef {import("../render/create_renderer.js").Choice} Choice */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../render/types.js").Variant} Variant */
/** @typedef {import("./stats.js").Stats} Stats */
/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {"orbit" | "fly" | "walk"} Mode the effect of dragging and of keys */
/** @typedef {0 | 1} Side 0: the scene; 1: the one that it is compared with */
/**
 * @typedef {object} Listener callbacks of a viewer
 * @property {(side: Side, share: number) => void} progress share of a file, 0 to 1; NaN while its size
 *     is unknown
 * @property {(side: Side, milliseconds: number, bytes: number) => void} loaded everything is decoded
 * @property {(side: Side, sentence: string, kept?: boolean) => void} failed `kept`: the previous scene stays
 * @property {(side: Side, sentence: string) => void} broken the renderer cannot continue
 * @property {(stats: Stats) => void} drawn
 */

const PATIENCE = 100; // milliseconds between frames of a scene that is loading and does not move
const LINGER = 150; // milliseconds after an input during which the scene counts as moving
const GRAVITY = 6; // rate at which the eye returns to its height, per second
const EARLY = 0.2; // share of a scene's Gaussians that looks worse than a poster: less than a quarter
const IDLE = (9 * Math.PI) / 180; // radians per second of automatic rotation

export class Viewer {
  /** @type {Pose} */
  pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  /** Field of view in degrees; null: that of the training cameras. @type {number | null} */
  fov = null;
  /** True if each pass is timed. */
  timed = false;
  /** True if the scene rotates by itself; the first input stops it. */
  turning = false;
  /** True if only `drawAt` renders. */
  measured = false;
  /** The session of WebXR that shows the scene; null: the page shows it. @type {XRSession | null} */
  session = null;
  #listener;
  #canvas;
  #variant;
  #levels;
  #first;
  /** @type {SceneView | null} */
  #second = null;
  /** @type {Choice} */
  #choice = "auto";
  /** @type {Vector | null} */
  #chosen = null; // background
  /** Name of the axis that points up instead of the scene's own direction. @type {string | null} */
  #up = null;
  /** @type {Record<string, string>} */
  #given = {};
  #resolution;
  #input;
  #start = this.pose;
  #placed = false; // the pose was set from outside
  #atStart = true; // nobody has moved since the first view
  /** Limits of the camera; null: none. @type {import("./framing.js").Limits | null} */
  #limits = null;
  #swing = { way: 1, speed: 1, excess: 0 }; // of automatic rotation
  /** @type {Mode} */
  #mode = "orbit";
  /** The plane in which the eye walks: its normal and offset. @type {{normal: Vector, offset: number} | null} */
  #ground = null;
  #visible = true;
  #requested = 0; // animation frame
  #last = 0; // time of the last frame
  #touched = -Infinity; // time of the last input
  #moving = false; // whether the last frame followed input
  #soon = 0; // timer of a delayed frame
  #rest = 0; // timer of the sharp frame after a movement
  #resize;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Listener} listener
   * @param {{variant?: Variant | null, levels?: number | null, editable?: boolean, patient?: boolean}} [options] variant
   *     null: the fastest on this device; levels: `levelSigma` of the renderer, null: that of the scene; editable:
   *     whether `hide` has an effect; patient: nothing is shown before the first LOD level
   */
  constructor(canvas, listener, { variant = null, levels = null, editable = false, patient = false } = {}) {
    this.#canvas = canvas;
    this.#listener = listener;
    this.#variant = variant;
    this.#levels = levels;
    this.#resolution = new Resolution(null);
    this.#first = this.#sceneView(canvas, 0, false);
    this.#first.editable = editable;
    this.#first.patient = patient;
    this.#input = new Input(canvas, {
      pose: () => this.pose,
      mode: () => this.mode,
      held: () => (this.turning = false),
      changed: () => {
        this.#touched = performance.now();
        this.turning = this.#atStart = false;
        if (this.#limits) resist(this.pose, this.#limits, this.mode);
        this.redraw();
      },
      focus: (x, y) => this.#focus(x, y),
    });
    this.#resize = new ResizeObserver(() => {
      // a rotated phone shows another first view
      if (this.count) this.#atStart ? this.#return() : this.#prepare();
      this.redraw();
    });
    this.#resize.observe(canvas);
  }

  /** Create a renderer. @param {Choice} choice @returns {Promise<boolean>} whether it succeeded */
  begin(choice) {
    this.#choice = choice;
    return this.#first.begin(choice);
  }

  /** Load a scene; the previous one stays if that fails. @param {Request} request */
  load(request) {
    if (this.#first.request) {
      this.#placed = false; // pose and axis belonged to the previous scene
      this.#up = null;
    }
    this.#first.load(request);
  }

  /**
   * Render a second scene with the same camera.
   *
   * @param {HTMLCanvasElement} canvas as large as the first one
   * @param {Request} request
   * @param {boolean} sorting whether a sort-free scene is rendered sorted
   */
  async compare(canvas, request, sorting) {
    this.endComparison();
    const sceneView = this.#sceneView(canvas, 1, sorting);
    sceneView.background = this.#chosen;
    this.#second = sceneView;
    await this.#first.calibrated; // the second view uses the stored result
    if (sceneView !== this.#second) return;
    if ((await sceneView.begin(this.#choice)) && sceneView === this.#second) sceneView.load(request);
  }

  /** End the comparison. */
  endComparison() {
    this.#second?.destroy();
    this.#second = null;
  }

  /** True if the visitor may see the canvas: nothing is drawn while it is scrolled away. @param {boolean} visible */
  set visible(visible) {
    this.#visible = visible;
    if (visible) this.redraw();
  }

  /** Render in the next animation frame. */
  redraw() {
    if (!this.#requested && !this.measured && !this.session && this.#visible) this.#requested = requestAnimationFrame((time) => this.#frame(time));
  }

  /** Return to the first pose, or to a training camera. @param {number} [index] */
  reset(index) {
    const { views } = this;
    this.#atStart = index === undefined || views.length === 0;
    if (this.#atStart) this.#return();
    else {
      const one = /** @type {number} */ (index) % views.length;
      this.pose = Pose.fromViews(views, (one + views.length) % views.length, this.#direction);
    }
    this.redraw();
  }

  /** Return to the first view of a screen of this shape, and find the limits. */
  #return() {
    this.#prepare();
    this.pose = this.#start.copy();
  }

  /** Find the first view and the limits of the scene. */
  #prepare() {
    this.#start = this.#firstPose();
    const { clientWidth, clientHeight } = this.#canvas;
    this.#limits = this.#up === null ? limitsFor(this.notes, clientWidth, clientHeight) : null;
  }

  /** Name of the axis that points up; null: the scene's own direction. */
  get up() {
    return this.#up;
  }

  /** Let another axis point up, and return to the first pose. @param {string | null} name */
  set up(name) {
    const chosen = name !== null && AXES.has(name) ? name : null;
    if (chosen === this.#up) return;
    this.#up = chosen;
    if (this.#first.count) this.reset();
  }

  /** Let the next axis point up. @returns {string} its name, or the empty text for the scene's own direction */
  turnUp() {
    const { views } = this;
    const own = this.#ownUp ?? (views.length ? Pose.fromViews(views).up : USUAL);
    this.up = nextAxis(this.#up, own);
    return this.#up ?? "";
  }

  /** Set the pose, also for a scene that is still loading. @param {Pose} pose */
  place(pose) {
    this.pose = pose;
    pose.box ??= this.#start.box;
    this.#placed = true;
    this.#atStart = false;
    this.redraw();
  }

  /** The effect of dragging and of keys. @returns {Mode} */
  get mode() {
    return this.#mode;
  }

  /** Walking keeps the eye at its height above the floor: that of the first view, if the file notes a floor. @param {Mode} mode */
  set mode(mode) {
    this.#mode = mode;
    const floor = mode === "walk" ? parsedFloor(this.notes.floor) : null;
    const eye = floor ? this.#start.eye : this.pose.eye;
    const normal = floor?.normal ?? this.pose.up;
    this.#ground = mode === "walk" ? { normal, offset: dot(eye, normal) } : null;
    this.redraw();
  }

  /** Walk, as a stick is pushed. @param {number} right -1 to 1 @param {number} forward */
  stride(right, forward) {
    this.#input.stride = [right, forward];
    this.redraw();
  }

  /** The camera of a frame of the given size. @param {number} width @param {number} height @returns {Camera} */
  camera(width, height) {
    return cameraOf(this.pose, this.views[0] ?? null, width, height, this.#first.near, this.fov);
  }

  /** Training cameras of the scene, or else of the second one. */
  get views() {
    return this.#first.views.length ? this.#first.views : (this.#second?.views ?? []);
  }

  /** Notes of the scene's file, or those given instead. */
  get notes() {
    return { ...this.#first.notes, ...this.#given };
  }

  /** Notes to use instead of those of the file: `start`, `start_portrait`, `limits`, `up`. @param {Record<string, string>} notes */
  set given(notes) {
    const same = JSON.stringify(notes) === JSON.stringify(this.#given);
    this.#given = notes;
    if (same || !this.count) return;
    if (this.#atStart) this.reset();
    else this.#prepare();
  }

  /** Gaussians of the scene. */
  get count() {
    return this.#first.count;
  }

  /** Means of the Gaussians, world units, 3 each, in the order of the file. */
  get means() {
    return this.#first.means;
  }

  /** Do not render the Gaussians whose byte is not 0. @param {Uint8Array} hidden one byte per Gaussian */
  hide(hidden) {
    this.#first.hide(hidden);
  }

  /** The point of the scene under a pixel. @param {number} x @param {number} y CSS pixels @returns {Vector | null} */
  pointAt(x, y) {
    const { clientWidth, clientHeight } = this.#canvas;
    const { means, logits } = this.#first;
    return pointUnder(means, logits, this.camera(clientWidth, clientHeight), x, y);
  }

  /** Resolves when the fastest variant is known, after the first scene has loaded. */
  get calibrated() {
    return this.#first.calibrated;
  }

  /** Source of the scene that is loading or shown. @returns {string | Blob | null} */
  get source() {
    const { request } = this.#first;
    if (request === null || "forward" in request) return null;
    return "url" in request ? request.url : request.file;
  }

  /** Renderer, adapter and variant in words. */
  get device() {
    return this.#first.device;
  }

  /** Rendered share of the screen's resolution, per side; null: chosen by the frame time. */
  get scale() {
    return this.#resolution.fixed;
  }

  set scale(share) {
    this.#resolution = new Resolution(share);
    this.redraw();
  }

  /** The visitor's settings, for a viewer that replaces this one. */
  get choices() {
    const { mode, fov, turning, scale, timed, up } = this;
    return { mode, fov, turning, scale, timed, up, background: this.#chosen };
  }

  /** The background. @returns {Vector} sRGB in [0, 1] */
  get background() {
    return this.#first.background;
  }

  /** @param {Vector | null} color sRGB in [0, 1], or null for each scene's own */
  set background(color) {
    this.#chosen = color;
    for (const sceneView of this.#sceneViews) sceneView.background = color;
    this.redraw();
  }

  /**
   * Render a frame of a given size, a sorted scene in the order of its camera. `finished` tells when it is done.
   *
   * @param {number} width
   * @param {number} height
   * @returns {Promise<number | null>} milliseconds of sorting; null: the scene is not sorted
   */
  async drawAt(width, height) {
    const camera = this.camera(width, height);
    const order = await this.#first.sort(camera);
    this.#first.draw(camera);
    return order;
  }

  /** Wait until all submitted work is rendered; throws an Error if it cannot be. */
  async finished() {
    await this.#first.finished();
    if (this.#first.broken) throw new Error("the renderer was lost");
  }

  /** Milliseconds of each pass of the last frame; null where the device has no timer. */
  async passes() {
    await this.#first.time();
    return this.#first.milliseconds;
  }

  /** Fragments per pixel of the last frame by level; null without one. */
  fragments() {
    return this.#first.countFragments();
  }

  /** The image as RGBA floats. @param {Camera} camera @param {Side} [side] */
  pixels(camera, side = 0) {
    const sceneView = this.#sceneViews[side];
    return sceneView?.pixels(camera) ?? Promise.reject(new Error("there is no other scene"));
  }

  /**
   * The image at its present size, as a PNG.
   *
   * @param {number} [share] of the width that shows the first of two scenes
   * @returns {Promise<Blob | null>}
   */
  screenshot(share = 1) {
    return new Promise((resolve) => this.copy(share).toBlob(resolve, "image/png"));
  }

  /** The image at its present size. @param {number} [share] of the width that shows the first of two scenes */
  copy(share = 1) {
    const { width, height } = this.#draw();
    const picture = document.createElement("canvas");
    [picture.width, picture.height] = [width, height];
    const context = picture.getContext("2d");
    this.#sceneViews.forEach(({ canvas }, side) => {
      const from = side * Math.round(share * width);
      const across = width - from;
      if (across > 0) context?.drawImage(canvas, from, 0, across, height, from, 0, across, height);
    });
    return picture;
  }

  /** The pose of the first view. */
  get start() {
    return this.#start.copy();
  }

  /**
   * A view of the scene that draws with WebGL2, for WebXR: the page's own, or one that loads the scene again.
   *
   * @param {boolean} patient whether it shows nothing before the first LOD level
   * @param {(sentence: string) => void} failed called with a message when it cannot continue
   * @returns {Promise<{sceneView: SceneView, own: boolean}>} the caller destroys it unless it is the page's own
   */
  async webglView(patient, failed) {
    const { context, request } = this.#first;
    if (context) return { sceneView: this.#first, own: true };
    const none = () => {};
    const listener = { progress: none, arrived: none, changed: none, ordered: none, loaded: none, failed, broken: failed };
    // a measurement of variants would stop the session
    const variant = this.#variant ?? { floats: false, strips: false };
    const sceneView = new SceneView(document.createElement("canvas"), listener, variant, false, this.#levels);
    sceneView.patient = patient;
    if ((await sceneView.begin("webgl")) && request) sceneView.load(request);
    return { sceneView, own: false };
  }

  destroy() {
    void this.session?.end();
    cancelAnimationFrame(this.#requested);
    clearTimeout(this.#rest);
    clearTimeout(this.#soon);
    this.#input.destroy();
    this.#resize.disconnect();
    for (const sceneView of this.#sceneViews) sceneView.destroy();
  }

  get #sceneViews() {
    return this.#second ? [this.#first, this.#second] : [this.#first];
  }

  /** @param {HTMLCanvasElement} canvas @param {Side} side @param {boolean} sorting */
  #sceneView(canvas, side, sorting) {
    /** @type {import("./scene_view.js").SceneListener} */
    const listener = {
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
    return new SceneView(canvas, listener, this.#variant, sorting, this.#levels);
  }

  /** @param {Side} side */
  #arrived(side) {
    const { views } = this;
    // the second scene sets the pose only if the first has no cameras and nobody has moved yet
    const asked = side === 0 || (!this.#first.views.length && this.#touched === -Infinity);
    if (asked && (views.length || this.#first.count)) {
      this.#prepare();
      if (this.#placed) this.pose.box ??= this.#start.box;
      else this.reset();
    }
    this.redraw();
  }

  /** As `first_pose` in mobilegs/viewpoints/pose.py. */
  #firstPose() {
    const { clientWidth, clientHeight } = this.#canvas;
    const known = this.#up === null ? { notes: this.notes, views: this.views } : { notes: {}, views: [] };
    const scene = { ...known, up: this.#direction, means: () => this.#first.means };
    return firstPose(scene, clientWidth, clientHeight);
  }

  /** The upward direction that notes give, or else the file. */
  get #ownUp() {
    return parsedUp(this.notes.up) ?? this.#first.up;
  }

  /** The chosen upward direction, or else that of the file; null: as the views tell. */
  get #direction() {
    return AXES.get(this.#up ?? "") ?? this.#ownUp;
  }

  /** @param {number} time */
  #frame(time) {
    this.#requested = 0;
    clearTimeout(this.#soon);
    this.#soon = 0;
    const since = time - this.#last;
    this.#last = time;
    const followed = this.#moving; // then `since` is a frame time
    const turning = this.turning && this.count > 0;
    this.#moving = performance.now() - this.#touched < LINGER || this.#input.busy || turning;
    if (this.#moving && followed) this.#resolution.note(since);
    const seconds = Math.min(since, 100) / 1000;
    this.#input.advance(seconds);
    if (turning) this.#rotate(seconds);
    const returning = this.#springs(seconds);
    const { width, height } = this.#draw();
    clearTimeout(this.#rest);
    if (this.#moving) this.#rest = setTimeout(() => this.redraw(), 2 * LINGER);
    if (this.count && !this.#first.broken) {
      const { name, count, milliseconds: passes, fragments } = this.#first;
      const milliseconds = this.#moving && followed ? since : 0;
      const compared = this.#second?.count ?? 0;
      const early = this.#first.patient && this.#atStart && count < EARLY * this.#first.total;
      this.#listener.drawn({ renderer: name, count, compared, early, width, height, milliseconds, passes, fragments });
      if (this.timed) void this.#first.time();
    }
    const falling = this.#falls(seconds);
    if (this.#input.busy || turning || returning || falling) this.redraw();
  }

  /** Rotate by itself; at a limit, back again. @param {number} seconds */
  #rotate(seconds) {
    const swing = this.#swing;
    swing.speed += (swing.way - swing.speed) * (1 - Math.exp(-2 * seconds));
    this.pose.orbit(IDLE * seconds * swing.speed, 0);
    this.#atStart = false;
    const excess = this.#limits ? excessOf(this.pose, this.#limits) : 0;
    if (excess > swing.excess && swing.way * swing.speed > 0) swing.way = -swing.way;
    swing.excess = excess;
  }

  /** Return to the height of walking. @param {number} seconds @returns {boolean} whether more frames follow */
  #falls(seconds) {
    if (!this.#ground) return false;
    const { normal, offset } = this.#ground;
    const high = dot(this.pose.eye, normal) - offset;
    if (Math.abs(high) < 1e-4 * this.pose.reach) return false;
    const step = -high * (1 - Math.exp(-GRAVITY * seconds));
    this.pose.eye = plus(this.pose.eye, normal, step);
    this.pose.target = plus(this.pose.target, normal, step);
    return true;
  }

  /** Return to the limits after an input. @param {number} seconds @returns {boolean} whether more frames follow */
  #springs(seconds) {
    const idle = this.#limits && this.#touched > -Infinity && !this.turning;
    if (!idle || this.#input.held) return false;
    return spring(this.pose, /** @type {import("./framing.js").Limits} */ (this.#limits), this.mode, seconds);
  }

  #draw() {
    const { clientWidth, clientHeight } = this.#canvas;
    const size = this.#resolution.size(clientWidth, clientHeight, devicePixelRatio, this.#moving);
    if (clientWidth && clientHeight) {
      const camera = this.camera(size.width, size.height);
      // a device that reduces the resolution has no time for more pixels
      const supersampling = this.#resolution.reduced(this.#moving) ? 1 : supersamplingFor(camera, this.views);
      for (const sceneView of this.#sceneViews) sceneView.drawOrReport(camera, supersampling);
    }
    return size;
  }

  /** @param {number} x @param {number} y CSS pixels */
  #focus(x, y) {
    const place = this.pointAt(x, y);
    if (place) this.pose.focus(place);
    this.redraw();
  }
}
