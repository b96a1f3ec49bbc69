/** The place of a scene in the space of a headset: its size, orientation and position, and how they change. */

import { parsedFloor } from "./framing.js";
import { turnedFromUsual } from "./up.js";
import { cross, dot, length, minus, plus, turned, unit } from "./vector.js";

/** @typedef {import("./pose.js").Pose} Pose */
/** @typedef {import("./vector.js").Vector} Vector */
/**
 * A similarity: a point `x` of the scene is at `scale axes x + at`.
 *
 * @typedef {object} Place
 * @property {Vector[]} axes rows of a rotation
 * @property {number} scale metres per unit of the scene
 * @property {Vector} at metres
 */
/**
 * @typedef {object} Head the visitor's head in the reference space
 * @property {Vector} eye metres; the floor is at y = 0
 * @property {Vector} forward
 */

/** @type {Vector} */
const UP = [0, 1, 0];
export const EYE_HEIGHT = 1.6; // metres above the floor: of someone who takes photos standing
const MINIATURE = 0.6; // metres across
const AHEAD = 0.8; // metres from the visitor to a miniature
const BELOW = 0.35; // metres of its centre below the eye
const DISTANCE = 2; // metres from the first view to its target in scenes without a floor
const WIDEST = 1; // largest tangent of half a view that a miniature shows
const JUMP = 2; // most that the size changes by in a frame: tracking may jump

/** @param {Place} place @param {Vector} point of the scene @returns {Vector} metres */
export function placed({ axes, scale, at }, point) {
  const turnedPoint = /** @type {Vector} */ (axes.map((row) => dot(row, point)));
  return plus(at, turnedPoint, scale);
}

/**
 * The rotation that makes `up` point up and lets `forward` have the heading of `wanted`.
 *
 * @param {Vector} up of the scene, length 1
 * @param {Vector} forward in the scene
 * @param {Vector} wanted in the reference space
 * @returns {Vector[]} rows
 */
function upright(up, forward, wanted) {
  const across = cross(forward, up);
  const right = unit(length(across) > 1e-6 ? across : turnedFromUsual([1, 0, 0], up));
  const back = cross(right, up);
  const ahead = levelled(wanted);
  const beside = cross(ahead, UP);
  // columns: where right, up and back of the scene go
  return [0, 1, 2].map((i) => {
    const row = plus(plus([0, 0, 0], right, beside[i]), up, UP[i]);
    return plus(row, back, -ahead[i]);
  });
}

/** A direction without its height, length 1; straight up or down: ahead. @param {Vector} direction @returns {Vector} */
export function levelled([x, , z]) {
  return Math.hypot(x, z) > 1e-3 ? unit([x, 0, z]) : [0, 0, -1];
}

/**
 * The plane that a visitor stands on, of a scene with a floor or without.
 *
 * @param {Pose} start the first view
 * @param {Record<string, unknown>} notes of the file
 * @returns {{up: Vector, height: number, scale: number}} height of the first view's eye, units; metres per unit
 */
function floorOf(start, notes) {
  const floor = parsedFloor(notes.floor);
  const height = floor ? dot(floor.normal, start.eye) - floor.offset : 0;
  if (floor && height > 0) return { up: floor.normal, height, scale: EYE_HEIGHT / height };
  const scale = DISTANCE / start.reach;
  return { up: start.up, height: EYE_HEIGHT / scale, scale };
}

/**
 * Let the visitor stand at the first view, on the floor: its eye is as high as that of someone who takes photos.
 *
 * @param {Pose} start
 * @param {Record<string, unknown>} notes
 * @param {Head} head
 * @returns {Place}
 */
export function standing(start, notes, head) {
  const { up, height, scale } = floorOf(start, notes);
  const axes = upright(up, start.forward, head.forward);
  const foot = plus(start.eye, up, -height);
  const at = minus([head.eye[0], 0, head.eye[2]], placed({ axes, scale, at: [0, 0, 0] }, foot));
  return { axes, scale, at };
}

/**
 * The sphere of the scene that a miniature shows: what the first view shows of its target.
 *
 * @param {Pose} start
 * @returns {{center: Vector, radius: number}} units
 */
export function subjectOf({ eye, target, box }) {
  const slope = Math.min(WIDEST, ...(box ?? [0.5, 0.5]));
  return { center: target, radius: slope * length(minus(target, eye)) };
}

/**
 * Put a miniature of the scene in front of the visitor.
 *
 * @param {Pose} start
 * @param {Record<string, unknown>} notes
 * @param {Head} head
 * @param {Vector | null} [surface] a point of a real surface to put it on
 * @returns {Place}
 */
export function miniature(start, notes, head, surface = null) {
  const { center, radius } = subjectOf(start);
  const { up, height } = floorOf(start, notes);
  const scale = MINIATURE / (2 * radius);
  const axes = upright(up, start.forward, head.forward);
  // on a surface, the scene's floor lies there, or the lowest part that is shown
  const lift = Math.min(radius, dot(up, minus(center, plus(start.eye, up, -height))));
  const free = plus(plus(head.eye, levelled(head.forward), AHEAD), UP, -BELOW);
  const wanted = surface ? plus(surface, UP, scale * Math.max(0, lift)) : free;
  return { axes, scale, at: minus(wanted, placed({ axes, scale, at: [0, 0, 0] }, center)) };
}

/** @param {Place} place @param {Vector} step metres @returns {Place} */
export const moved = (place, step) => ({ ...place, at: plus(place.at, step) });

/**
 * Turn the scene around a vertical axis and change its size, around a point.
 *
 * @param {Place} place
 * @param {Vector} pivot metres
 * @param {number} angle radians, counterclockwise from above
 * @param {number} [factor] of the size
 * @returns {Place}
 */
export function turnedAround({ axes, scale, at }, pivot, angle, factor = 1) {
  const columns = [0, 1, 2].map((j) => turned([axes[0][j], axes[1][j], axes[2][j]], UP, angle));
  const rows = [0, 1, 2].map((i) => /** @type {Vector} */ (columns.map((column) => column[i])));
  return { axes: rows, scale: factor * scale, at: plus(pivot, turned(minus(at, pivot), UP, angle), factor) };
}

/**
 * Follow two hands that hold the scene: it moves, turns around a vertical axis, and changes its size.
 *
 * @param {Place} place
 * @param {Vector[]} before both hands, metres
 * @param {Vector[]} now
 * @param {Vector} [axis] around which the turn of the hands is measured, length 1
 * @returns {Place}
 */
export function stretched(place, before, now, axis = UP) {
  const [from, to] = [minus(before[1], before[0]), minus(now[1], now[0])];
  const flat = plus(from, axis, -dot(from, axis));
  const angle = Math.atan2(dot(axis, cross(flat, to)), dot(flat, to));
  const middle = (/** @type {Vector[]} */ [a, b]) => plus(a, minus(b, a), 0.5);
  const factor = Math.min(JUMP, Math.max(1 / JUMP, length(to) / length(from) || 1));
  return moved(turnedAround(place, middle(before), angle, factor), minus(middle(now), middle(before)));
}
