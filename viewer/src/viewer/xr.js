/**
 * Shows the scene in a headset, or through a phone's camera: a session of WebXR. It draws with WebGL2, since few
 * browsers have the draft for WebGPU.
 */

import { Hands } from "./xr_hands.js";
import { FramePace } from "./xr_pace.js";
import { EYE_HEIGHT, miniature, placed, standing, subjectOf } from "./xr_place.js";
import { cameraOfEye } from "./xr_camera.js";

/** @typedef {import("./scene_view.js").SceneView} SceneView */
/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./xr_place.js").Head} Head */
/** @typedef {import("./xr_place.js").Place} Place */
/** @typedef {"immersive-vr" | "immersive-ar"} Mode */

const USUAL_RATE = 60; // frames per second of headsets that do not tell theirs
const PAUSE = 0.1; // most seconds that a frame counts for movements
/** Features that a session has if the device offers them. @type {Record<Mode, string[]>} */
const FEATURES = {
  "immersive-vr": ["local-floor", "hand-tracking"],
  "immersive-ar": ["local-floor", "hand-tracking", "hit-test"],
};

/**
 * Start a session, or end the one that runs.
 *
 * @param {Viewer} viewer
 * @param {Mode} mode
 * @param {HTMLElement} button looks pressed during the session
 * @returns {Promise<void>} rejects with a message for visitors
 */
export async function present(viewer, mode, button) {
  if (viewer.session) return viewer.session.end();
  if (!viewer.count) throw new Error("a session can start once the scene is shown");
  const session = await request(mode);
  viewer.session = session;
  button.setAttribute("aria-pressed", "true");
  const ended = new Promise((resolve) => session.addEventListener("end", resolve, { once: true })).then(() => {
    viewer.session = null;
    button.setAttribute("aria-pressed", "false");
    viewer.redraw();
  });
  /** @type {(reason: Error) => void} */
  let fail = () => {};
  const failed = new Promise((_, reject) => (fail = reject));
  const augmented = mode === "immersive-ar";
  const { sceneView, own } = await viewer.webglView(augmented, (sentence) => fail(new Error(sentence)));
  try {
    await Promise.race([ended, failed, begin(session, viewer, sceneView, augmented)]);
    await Promise.race([ended, failed]);
  } finally {
    if (viewer.session === session) await session.end();
    if (own) viewer.background = viewer.choices.background;
    else sceneView.destroy();
  }
}

/** @param {Mode} mode @returns {Promise<XRSession>} */
async function request(mode) {
  try {
    return await /** @type {XRSystem} */ (navigator.xr).requestSession(mode, { optionalFeatures: FEATURES[mode] });
  } catch (error) {
    throw new Error(`the session cannot start: ${/** @type {Error} */ (error).message}`);
  }
}

/**
 * Start to draw.
 *
 * @param {XRSession} session
 * @param {Viewer} viewer
 * @param {SceneView} sceneView
 * @param {boolean} augmented whether the room is visible behind the scene
 */
async function begin(session, viewer, sceneView, augmented) {
  const gl = sceneView.context;
  if (!gl) throw new Error("this browser cannot draw with WebGL2 here");
  await gl.makeXRCompatible();
  const space = await floorSpace(session);
  // its images are premultiplied by alpha where the background is black
  if (augmented) sceneView.background = [0, 0, 0];
  else sceneView.background = viewer.choices.background;
  new Presentation(session, viewer, sceneView, gl, space, augmented);
}

/** A space whose floor is at y = 0. @param {XRSession} session @returns {Promise<XRReferenceSpace>} */
async function floorSpace(session) {
  try {
    return await session.requestReferenceSpace("local-floor");
  } catch {
    const local = await session.requestReferenceSpace("local");
    return local.getOffsetReferenceSpace(new XRRigidTransform({ y: -EYE_HEIGHT }));
  }
}

/** Draws the frames of a session. */
class Presentation {
  #session;
  #viewer;
  #sceneView;
  #gl;
  #space;
  #augmented;
  #hands;
  #pace;
  /** @type {XRWebGLLayer} */
  #layer;
  #layerScale = 1;
  /** The scene's place; null: the visitor comes to the first view. @type {Place | null} */
  #place = null;
  #kept = false; // whether a miniature stays where it is, rather than on the surface that the visitor looks at
  /** @type {XRHitTestSource | null} */
  #surfaces = null;
  #last = NaN; // time of the last frame

  /**
   * @param {XRSession} session
   * @param {Viewer} viewer
   * @param {SceneView} sceneView
   * @param {WebGL2RenderingContext} gl
   * @param {XRReferenceSpace} space
   * @param {boolean} augmented
   */
  constructor(session, viewer, sceneView, gl, space, augmented) {
    this.#session = session;
    this.#viewer = viewer;
    this.#sceneView = sceneView;
    this.#gl = gl;
    this.#space = space;
    this.#augmented = augmented;
    this.#hands = new Hands(session);
    this.#pace = new FramePace(session.frameRate ?? USUAL_RATE, viewer.scale);
    this.#layer = this.#newLayer();
    session.addEventListener("frameratechange", () => (this.#pace.rate = session.frameRate ?? USUAL_RATE));
    session.addEventListener("visibilitychange", () => {
      this.#hands.release();
      this.#pace.forget();
      this.#last = NaN;
    });
    space.addEventListener("reset", () => (this.#place = null)); // the visitor faces another way
    if (augmented) void this.#findSurfaces();
    session.requestAnimationFrame(this.#frame);
  }

  /** A framebuffer for the session, of the scale that the pace asks for if viewports have none of their own. */
  #newLayer() {
    this.#layerScale = "requestViewportScale" in XRView.prototype ? 1 : this.#pace.step.scale;
    const options = { antialias: false, depth: false, framebufferScaleFactor: this.#layerScale };
    const layer = new XRWebGLLayer(this.#session, this.#gl, options);
    void this.#session.updateRenderState({ baseLayer: layer });
    return layer;
  }

  /** Look for surfaces that a miniature can stand on. */
  async #findSurfaces() {
    try {
      const space = await this.#session.requestReferenceSpace("viewer");
      this.#surfaces = (await this.#session.requestHitTestSource?.({ space })) ?? null;
    } catch {
      // the device finds none: the miniature floats
    }
  }

  #frame = (/** @type {number} */ time, /** @type {XRFrame} */ frame) => {
    const [session, space] = [this.#session, this.#space];
    if (this.#sceneView.broken) return void session.end(); // the page says why
    session.requestAnimationFrame(this.#frame);
    const since = time - this.#last;
    this.#last = time;
    const pose = session.visibilityState === "hidden" ? null : frame.getViewerPose(space);
    if (!pose) return;
    if (since > 0 && session.visibilityState === "visible") this.#pace.note(since);
    const { position, matrix } = pose.transform;
    /** @type {Head} */
    const head = {
      eye: [position.x, position.y, position.z],
      forward: [-matrix[8], -matrix[9], -matrix[10]],
    };
    this.#place = this.#moved(this.#place ?? this.#firstPlace(head, frame), frame, head, Math.min(since / 1000, PAUSE) || 0);
    this.#draw(pose.views, this.#place ?? this.#firstPlace(head, frame));
  };

  /** @param {Head} head @param {XRFrame} frame @returns {Place} */
  #firstPlace(head, frame) {
    const { start, notes } = this.#viewer;
    if (!this.#augmented) return standing(start, notes, head);
    const [hit] = this.#surfaces ? frame.getHitTestResults(this.#surfaces) : [];
    const at = hit?.getPose(this.#space)?.transform.position;
    return miniature(start, notes, head, at ? [at.x, at.y, at.z] : null);
  }

  /**
   * The scene's place after what the visitor's hands did; null: the first place again.
   *
   * @param {Place} place
   * @param {XRFrame} frame
   * @param {Head} head
   * @param {number} seconds
   */
  #moved(place, frame, head, seconds) {
    const [hands, session] = [this.#hands, this.#session];
    const center = placed(place, subjectOf(this.#viewer.start).center);
    this.#kept ||= hands.holding;
    const held = hands.pull(frame, this.#space, place, center, head);
    const after = hands.steer(session.inputSources, seconds, held, head, this.#augmented ? center : null);
    if (after === null) this.#kept = false;
    // a miniature follows the visitor's eye over surfaces until a hand holds it
    return this.#surfaces && !this.#kept ? null : after;
  }

  /** @param {readonly XRView[]} views @param {Place} place */
  #draw(views, place) {
    const { scale, coarseness } = this.#pace.step;
    const viewports = "requestViewportScale" in XRView.prototype;
    if (!viewports && scale !== this.#layerScale) this.#layer = this.#newLayer();
    const { depthNear } = this.#session.renderState;
    const { framebuffer } = this.#layer;
    const eyes = views.flatMap((view) => {
      if (viewports) view.requestViewportScale(scale);
      const { x, y, width, height } = this.#layer.getViewport(view) ?? { x: 0, y: 0, width: 0, height: 0 };
      if (!width || !height) return [];
      return [{ camera: cameraOfEye(view, { width, height }, place, depthNear), target: { framebuffer, x, y } }];
    });
    const { center, radius } = subjectOf(this.#viewer.start);
    const crop = this.#augmented ? [...center, radius] : null;
    if (eyes.length) this.#sceneView.drawEyes(eyes, coarseness, crop);
  }
}
