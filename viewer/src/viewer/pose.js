/** The camera pose and its movements: orbit, look around, pan, dolly, fly. */

import { USUAL, turnedFromUsual, upOfCameras } from "./up.js";
import { cross, dot, length, minus, plus, turned, unit } from "./vector.js";

/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("./vector.js").Vector} Vector */

const POLE = 0.02; // smallest angle to straight up or down, radians
/** Box of the pose for a scene without cameras. @type {[number, number]} */
const AROUND = [0.42, 0.42];
const NEAREST = 1e-3; // smallest distance to the target, as a share of the first one

/** A camera pose: eye, target, and the world's up direction. */
export class Pose {
  /**
   * @param {Vector} eye
   * @param {Vector} target centre of the orbit
   * @param {Vector} up of the world
   */
  constructor(eye, target, up) {
    this.eye = eye;
    this.target = target;
    this.up = unit(up);
    this.reach = length(minus(target, eye)) || 1;
    /** Tangents of half the width and height that must be in the picture; null: as a training camera. @type {[number, number] | null} */
    this.box = null;
  }

  /** A first view that a file notes. @param {import("./framing.js").Start} start @param {Vector} up */
  static fromStart({ eye, target, box }, up) {
    const made = new Pose(eye, target, up);
    made.box = box;
    return made;
  }

  /**
   * The pose of a training camera; the target is the point that all cameras look at.
   *
   * @param {View[]} views at least one
   * @param {number} [index]
   * @param {Vector | null} [up] null: as the views tell
   */
  static fromViews(views, index = 0, up = null) {
    const axes = views.map(axesOf);
    const { eye, forward } = axes[index];
    const distance = dot(minus(meeting(axes), eye), forward);
    // lines of sight of outward or parallel cameras do not meet: look one step ahead
    const step = Math.max(...axes.map((other) => length(minus(other.eye, eye))), 0) || 1;
    return new Pose(eye, plus(eye, forward, distance > NEAREST * step ? distance : step), up ?? upOfCameras(axes));
  }

  /**
   * A pose for a scene without cameras: from the side, with most of the scene in view.
   *
   * @param {Float32Array} means of Gaussians, 3 each
   * @param {Vector} [up]
   */
  static around(means, up = USUAL) {
    /** @type {number[][]} */
    const ends = [0, 1, 2].map((axis) => {
      const sorted = means.filter((_, i) => i % 3 === axis).sort();
      const at = (/** @type {number} */ share) => sorted[Math.floor(share * (sorted.length - 1))] ?? 0;
      return [at(0.15), at(0.5), at(0.85)];
    });
    const target = /** @type {Vector} */ (ends.map(([, middle]) => middle));
    const size = Math.max(...ends.map(([low, , high]) => high - low)) || 1;
    const made = new Pose(plus(target, turnedFromUsual([0, -0.3, -1], up), 1.5 * size), target, up);
    made.box = AROUND;
    return made;
  }

  /** @returns {Vector} */
  get forward() {
    return unit(minus(this.target, this.eye));
  }

  /** @returns {Vector} */
  get right() {
    return unit(cross(this.forward, this.up));
  }

  copy() {
    const made = new Pose(this.eye, this.target, this.up);
    made.reach = this.reach;
    made.box = this.box;
    return made;
  }

  /** Orbit around the target. @param {number} across radians @param {number} down radians */
  orbit(across, down) {
    const back = this.#swung(minus(this.eye, this.target), across, down);
    this.eye = plus(this.target, back);
  }

  /** Rotate the camera at its place. @param {number} across radians @param {number} down radians */
  look(across, down) {
    const ahead = this.#swung(minus(this.eye, this.target), across, down);
    this.target = minus(this.eye, ahead);
  }

  /**
   * Move eye and target.
   *
   * @param {number} right world units
   * @param {number} down
   * @param {number} forward
   */
  move(right, down, forward) {
    const below = cross(this.forward, this.right);
    let step = plus([0, 0, 0], this.right, right);
    step = plus(plus(step, below, down), this.forward, forward);
    this.eye = plus(this.eye, step);
    this.target = plus(this.target, step);
  }

  /** Move eye and target along the horizontal plane. @param {number} right world units @param {number} forward */
  walk(right, forward) {
    const ahead = unit(cross(this.up, this.right));
    const step = plus(plus([0, 0, 0], this.right, right), ahead, forward);
    this.eye = plus(this.eye, step);
    this.target = plus(this.target, step);
  }

  /** Change the distance to the target. @param {number} factor of the distance to the target */
  dolly(factor) {
    const back = minus(this.eye, this.target);
    const distance = Math.max(length(back) * factor, NEAREST * this.reach);
    this.eye = plus(this.target, unit(back), distance);
  }

  /** Look at another point. @param {Vector} place */
  focus(place) {
    if (length(minus(place, this.eye)) > 0) this.target = place;
  }

  /** World to camera, 16 numbers row by row, OpenCV axes. */
  viewmat() {
    const { forward, right, eye } = this;
    const down = cross(forward, right);
    const row = (/** @type {Vector} */ axis) => [...axis, -dot(axis, eye)];
    return [...row(right), ...row(down), ...row(forward), 0, 0, 0, 1];
  }

  /** @param {Vector} back from the target to the eye @param {number} across @param {number} down */
  #swung(back, across, down) {
    const polar = Math.acos(Math.min(1, Math.max(-1, dot(unit(back), this.up))));
    const swing = Math.min(Math.max(polar - down, POLE), Math.PI - POLE) - polar;
    return turned(turned(back, this.right, swing), this.up, -across);
  }
}

/**
 * A camera of the given size that shows the pose's box. Without a box it has about the field of view of a
 * training camera: for other aspect ratios, the geometric mean of fitting the whole image and filling the screen.
 *
 * @param {Pose} pose
 * @param {View | null} view whose field of view to take; 50 degrees without one
 * @param {number} width pixels
 * @param {number} height pixels
 * @param {number} near
 * @param {number | null} [fov] degrees to take instead of the box's or the view's
 * @returns {Camera}
 */
export function cameraOf(pose, view, width, height, near, fov = null) {
  const slope = Math.tan(((fov ?? 50) * Math.PI) / 360);
  const known = fov === null ? view : null;
  const byWidth = known ? (width * known.K[0]) / known.width : width / (2 * slope);
  const byHeight = known ? (height * known.K[4]) / known.height : height / (2 * slope);
  const box = fov === null ? pose.box : null;
  const focal = box ? Math.min(width / (2 * box[0]), height / (2 * box[1])) : Math.sqrt(byWidth * byHeight);
  const center = { cx: width / 2, cy: height / 2 };
  return { viewmat: pose.viewmat(), fx: focal, fy: focal, ...center, width, height, near };
}

/** @param {View} view @returns {{eye: Vector, right: Vector, forward: Vector, down: Vector}} */
function axesOf({ viewmat: m }) {
  const row = (/** @type {number} */ i) => /** @type {Vector} */ ([m[4 * i], m[4 * i + 1], m[4 * i + 2]]);
  const [right, down, forward] = [row(0), row(1), row(2)];
  let eye = plus([0, 0, 0], right, -m[3]);
  eye = plus(plus(eye, down, -m[7]), forward, -m[11]);
  return { eye, right, forward, down };
}

/**
 * The point nearest to all lines of sight, by least squares.
 *
 * @param {{eye: Vector, forward: Vector}[]} axes
 * @returns {Vector}
 */
function meeting(axes) {
  // sum of (I - f f^T) (x - eye) = 0; a little of I itself where all look in parallel
  const matrix = [1e-3, 0, 0, 0, 1e-3, 0, 0, 0, 1e-3];
  /** @type {Vector} */
  let sum = [0, 0, 0];
  for (const { eye, forward: f } of axes) {
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++) matrix[3 * i + j] += (i === j ? 1 : 0) - f[i] * f[j];
    }
    sum = plus(plus(sum, eye, 1 + 1e-3 / axes.length), f, -dot(f, eye));
  }
  const column = (/** @type {number} */ j) => /** @type {Vector} */ ([matrix[j], matrix[3 + j], matrix[6 + j]]);
  const [a, b, c] = [column(0), column(1), column(2)];
  const volume = dot(a, cross(b, c));
  return [
    dot(sum, cross(b, c)) / volume,
    dot(a, cross(sum, c)) / volume,
    dot(a, cross(b, sum)) / volume,
  ];
}
