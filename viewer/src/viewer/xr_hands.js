/** Controllers, hands and fingers: they hold the scene, walk and turn. */

import { levelled, moved, stretched, turnedAround } from "./xr_place.js";
import { cross, length, minus, plus } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./xr_place.js").Head} Head */
/** @typedef {import("./xr_place.js").Place} Place */

const SPEED = 1.5; // metres per second
const DEAD = 0.15; // push of a stick that counts as none
const [PUSHED, RELEASED] = [0.7, 0.3]; // of a stick that turns the visitor
const SNAP = Math.PI / 6; // radians
const REACH = [0.3, 5]; // metres from a ray's origin to what it holds
const PRESS = 3; // the button of a stick

/** The gestures of the visitor's hands. */
export class Hands {
  /** Sources that hold the scene, with their points in the last frame. @type {Map<XRInputSource, Vector | null>} */
  #held = new Map();
  /** Distances of what rays hold. @type {WeakMap<XRInputSource, number>} */
  #reaches = new WeakMap();
  /** Sticks that have turned the visitor and were not released since. @type {Set<XRHandedness>} */
  #snapped = new Set();
  #pressed = false; // whether a stick is pressed down

  /** @param {XRSession} session */
  constructor(session) {
    for (const name of /** @type {const} */ (["select", "squeeze"])) {
      session.addEventListener(`${name}start`, ({ inputSource }) => {
        // what the eye holds would follow the head
        if (inputSource.targetRayMode !== "gaze") this.#held.set(inputSource, null);
      });
      session.addEventListener(`${name}end`, ({ inputSource }) => this.#held.delete(inputSource));
    }
    session.addEventListener("inputsourceschange", ({ removed }) => removed.forEach((one) => this.#held.delete(one)));
  }

  /** True while a hand holds the scene. */
  get holding() {
    return this.#held.size > 0;
  }

  /** Let everything go. */
  release() {
    this.#held.clear();
  }

  /**
   * Let the scene follow the hands that hold it: one moves it, two also turn it and change its size.
   *
   * @param {XRFrame} frame
   * @param {XRReferenceSpace} space
   * @param {Place} place
   * @param {Vector} center what rays hold, metres
   * @param {Head} head
   * @returns {Place}
   */
  pull(frame, space, place, center, head) {
    const pairs = [...this.#held].map(([source, before]) => {
      const now = this.#pointOf(source, frame, space, center);
      this.#held.set(source, now);
      return { source, before, now };
    });
    const hands = pairs.filter(({ before, now }) => before && now).slice(0, 2);
    const [before, now] = /** @type {const} */ (["before", "now"]).map((when) =>
      hands.map((hand) => /** @type {Vector} */ (hand[when])),
    );
    if (hands.length === 0) return place;
    if (hands.length === 1) return moved(place, minus(now[0], before[0]));
    // fingers turn in the plane of the screen
    const flat = hands[0].source.targetRayMode === "screen";
    return stretched(place, before, now, flat ? minus([0, 0, 0], head.forward) : undefined);
  }

  /**
   * Walk and turn by sticks. The left one moves the visitor, others turn it, and both go forward and back.
   *
   * @param {Iterable<XRInputSource>} sources
   * @param {number} seconds
   * @param {Place} place
   * @param {Head} head
   * @param {Vector | null} miniature its centre, which turns in place of the visitor; null: the visitor moves
   * @returns {Place | null} null: a stick was pressed, which asks for the first place
   */
  steer(sources, seconds, place, head, miniature) {
    const ahead = levelled(head.forward);
    const beside = cross(ahead, [0, 1, 0]);
    let pressed = false;
    for (const { gamepad, handedness } of sources) {
      if (!gamepad || gamepad.axes.length < 2) continue;
      const [x, y] = gamepad.axes.slice(-2).map((push) => (Math.abs(push) > DEAD ? push : 0));
      pressed ||= Boolean(gamepad.buttons[PRESS]?.pressed);
      const walks = handedness === "left" && !miniature;
      if (!walks) {
        const turns = Math.abs(x) > PUSHED && !this.#snapped.has(handedness);
        if (turns) {
          this.#snapped.add(handedness);
          place = turnedAround(place, miniature ?? head.eye, Math.sign(x) * SNAP);
        } else if (Math.abs(x) < RELEASED) this.#snapped.delete(handedness);
      }
      if (miniature) continue;
      place = moved(place, plus([0, 0, 0], ahead, y * SPEED * seconds));
      if (walks) place = moved(place, plus([0, 0, 0], beside, -x * SPEED * seconds));
    }
    const asked = pressed && !this.#pressed;
    this.#pressed = pressed;
    return asked ? null : place;
  }

  /**
   * Where a source holds the scene: at the hand, or along a ray.
   *
   * @param {XRInputSource} source
   * @param {XRFrame} frame
   * @param {XRReferenceSpace} space
   * @param {Vector} center
   * @returns {Vector | null}
   */
  #pointOf(source, frame, space, center) {
    const { gripSpace, targetRaySpace } = source;
    const pose = frame.getPose(gripSpace ?? targetRaySpace, space);
    if (!pose) return null;
    const { position, matrix } = pose.transform;
    /** @type {Vector} */
    const origin = [position.x, position.y, position.z];
    if (gripSpace) return origin;
    const reach = this.#reaches.get(source) ?? Math.min(REACH[1], Math.max(REACH[0], length(minus(center, origin))));
    this.#reaches.set(source, reach);
    return plus(origin, [matrix[8], matrix[9], matrix[10]], -reach);
  }
}
