/** First views and limits of the camera that a file's notes tell; as mobilegs/viewpoints/framing.py. */

import { Pose } from "./pose.js";
import { USUAL, turnedFromUsual } from "./up.js";
import { dot, length, minus, plus, unit } from "./vector.js";

/** @typedef {import("./viewer.js").Mode} Mode */
/** @typedef {import("./vector.js").Vector} Vector */
/**
 * @typedef {object} Start a first view
 * @property {Vector} eye
 * @property {Vector} target
 * @property {[number, number]} box tangents of half the width and height that must be in the picture
 */
/**
 * @typedef {object} Limits of the camera, around the point that training cameras look at
 * @property {Vector} pivot that point
 * @property {number} pan greatest distance of the target from the pivot
 * @property {number} nearest distance of the camera to its target
 * @property {number} farthest
 * @property {number[][]} elevations least and greatest elevation in each sector, degrees; a sector whose least is
 *     above its greatest is closed
 */

export const FREE = "none"; // the note `limits` of a scene without limits
const NUMBER = /^-?\d{1,12}(\.\d{1,12})?$/;
const SECTORS = 24;
const GIVE = { angle: 8, share: 0.25 }; // how far a limit gives way, degrees and shares of a distance
const DEGREE = Math.PI / 180;
const RETURN = 9; // rate of the spring, per second
const REST = 1e-3; // excess at which the spring rests

/** The numbers of a note; null for anything else. @param {unknown} text @returns {number[] | null} */
function numbersOf(text) {
  const words = typeof text === "string" ? text.trim().split(/\s+/) : [];
  return words.every((word) => NUMBER.test(word)) ? words.map(Number) : null;
}

/** @param {number[]} numbers @param {number} at @returns {Vector} */
const vectorAt = (numbers, at) => [numbers[at], numbers[at + 1], numbers[at + 2]];

/** The first view of a note; null for anything else. @param {unknown} text @returns {Start | null} */
export function parsedStart(text) {
  const numbers = numbersOf(text);
  if (numbers?.length !== 8) return null;
  const [eye, target] = [vectorAt(numbers, 0), vectorAt(numbers, 3)];
  const [x, y] = numbers.slice(6);
  if (eye.every((value, i) => value === target[i]) || !(x > 0 && y > 0 && x < 1000 && y < 1000)) return null;
  return { eye, target, box: [x, y] };
}

/** The limits of a note; null for anything else. @param {unknown} text @returns {Limits | null} */
export function parsedLimits(text) {
  const numbers = numbersOf(text);
  if (numbers?.length !== 6 + 2 * SECTORS) return null;
  const [pan, nearest, farthest] = numbers.slice(3, 6);
  const angles = numbers.slice(6);
  if (!(pan >= 0 && nearest > 0 && nearest <= farthest) || angles.some((angle) => Math.abs(angle) > 90)) return null;
  const elevations = Array.from({ length: SECTORS }, (_, i) => angles.slice(2 * i, 2 * i + 2));
  const limits = { pivot: vectorAt(numbers, 0), pan, nearest, farthest, elevations };
  return elevations.some(([low, high]) => low <= high) ? limits : null;
}

/**
 * Azimuth (0 to 360) and elevation of a direction of length 1, in degrees, as `azimuth_of`.
 *
 * @param {Vector} direction
 * @param {Vector} up
 * @returns {[number, number]}
 */
export function anglesOf(direction, up) {
  const along = (/** @type {Vector} */ axis) => dot(direction, turnedFromUsual(axis, up));
  const elevation = Math.asin(Math.min(1, Math.max(-1, dot(direction, up)))) / DEGREE;
  return [(Math.atan2(along([0, 0, 1]), along([1, 0, 0])) / DEGREE + 360) % 360, elevation];
}

/** The direction of length 1 with these angles in degrees. @param {number} azimuth @param {number} elevation @param {Vector} up */
export function directionOf(azimuth, elevation, up) {
  const [a, e] = [azimuth * DEGREE, elevation * DEGREE];
  return turnedFromUsual([Math.cos(a) * Math.cos(e), -Math.sin(e), Math.sin(a) * Math.cos(e)], up);
}

/** The turn from one azimuth to another, -180 to 180 degrees. @param {number} azimuth @param {number} other */
const turnBetween = (azimuth, other) => ((((other - azimuth + 180) % 360) + 360) % 360) - 180;

/**
 * The nearest azimuth that is allowed, and its least and greatest elevation, as `Limits.range_at`.
 *
 * @param {Limits} limits
 * @param {number} azimuth degrees
 * @returns {[number, number, number]}
 */
export function rangeAt({ elevations }, azimuth) {
  const open = elevations.map(([low, high]) => low <= high);
  const place = (azimuth / 360) * SECTORS - 0.5;
  const first = Math.floor(place);
  const share = place - first;
  const [one, other] = [(first + SECTORS) % SECTORS, (first + 1) % SECTORS];
  const nearer = share < 0.5 ? one : other;
  if (open[nearer]) {
    const [from, to] = open[one] && open[other] ? [one, other] : [nearer, nearer];
    const mixed = (/** @type {0 | 1} */ k) => (1 - share) * elevations[from][k] + share * elevations[to][k];
    return [azimuth, mixed(0), mixed(1)];
  }
  let [best, sector, edge] = [Infinity, 0, 0];
  for (let i = 0; i < 2 * SECTORS; i++) {
    const at = (360 * ((i + 1) >> 1)) / SECTORS;
    const turn = Math.abs(turnBetween(azimuth, at));
    if (open[i >> 1] && turn < best) [best, sector, edge] = [turn, i >> 1, at];
  }
  return [edge, elevations[sector][0], elevations[sector][1]];
}

/**
 * The limits on a screen of this shape; null if the notes tell none, or that there are none.
 *
 * @param {Record<string, unknown>} notes
 * @param {number} width
 * @param {number} height
 * @returns {Limits | null}
 */
export function limitsFor(notes, width, height) {
  if (notes.limits === FREE) return null;
  const portrait = width < height ? parsedLimits(notes.limits_portrait) : null;
  return portrait ?? parsedLimits(notes.limits);
}

/**
 * The floor that a note tells as `nx ny nz d`: the plane of the points with `normal . x = offset`, whose normal points
 * up and has length 1; null for anything else.
 *
 * @param {unknown} text
 * @returns {{normal: Vector, offset: number} | null}
 */
export function parsedFloor(text) {
  const numbers = numbersOf(text);
  if (numbers?.length !== 4) return null;
  const normal = vectorAt(numbers, 0);
  const size = length(normal);
  return size > 0 ? { normal: unit(normal), offset: numbers[3] / size } : null;
}

/**
 * The first view on a screen of this shape; null if the notes tell none.
 *
 * @param {Record<string, unknown>} notes
 * @param {number} width
 * @param {number} height
 * @returns {Start | null}
 */
export function startFor(notes, width, height) {
  const portrait = width < height ? parsedStart(notes.start_portrait) : null;
  return portrait ?? parsedStart(notes.start);
}

/**
 * The first view of a scene on a screen of this shape: as its notes tell, or else that of a training camera.
 *
 * @param {object} scene
 * @param {Record<string, unknown>} scene.notes
 * @param {import("../mgs/header.js").View[]} scene.views
 * @param {Vector | null} scene.up null: as the views tell
 * @param {() => Float32Array} scene.means
 * @param {number} width
 * @param {number} height
 * @returns {Pose}
 */
export function firstPose({ notes, views, up, means }, width, height) {
  const start = startFor(notes, width, height);
  if (start) return Pose.fromStart(start, up ?? (views.length ? Pose.fromViews(views).up : USUAL));
  return views.length ? Pose.fromViews(views, 0, up) : Pose.around(means(), up ?? USUAL);
}

/**
 * Bring a pose nearer to its limits: what lies outside of them shrinks by `less`.
 *
 * @param {Pose} pose changed in place
 * @param {Limits} limits
 * @param {(excess: number, most: number) => number} less of an excess, and how far that limit gives way
 * @param {Mode} mode flying and walking have no limit of nearness
 * @returns {number} the largest excess that remains, as a share of how far its limit gives way
 */
export function limit(pose, limits, less, mode) {
  let left = 0;
  const reduced = (/** @type {number} */ excess, /** @type {number} */ most) => {
    const rest = less(excess, most);
    left = Math.max(left, rest / most);
    return rest;
  };
  const center = mode === "orbit" ? pose.target : limits.pivot;
  let back = minus(pose.eye, center);
  let distance = length(back);
  const { nearest, farthest, pan } = limits;
  const least = mode === "orbit" ? nearest : 0;
  if (distance > farthest) distance = farthest + reduced(distance - farthest, GIVE.share * farthest);
  else if (distance < least) distance = least - reduced(least - distance, GIVE.share * least);
  let [azimuth, elevation] = anglesOf(unit(back), pose.up);
  const [edge, low, high] = rangeAt(limits, azimuth);
  const turn = turnBetween(edge, azimuth);
  if (turn) azimuth = edge + Math.sign(turn) * reduced(Math.abs(turn), GIVE.angle);
  if (elevation > high) elevation = high + reduced(elevation - high, GIVE.angle);
  else if (elevation < low) elevation = low - reduced(low - elevation, GIVE.angle);
  back = plus([0, 0, 0], directionOf(azimuth, elevation, pose.up), distance);
  const ahead = minus(pose.target, pose.eye);
  pose.eye = plus(center, back);
  if (mode !== "orbit") {
    pose.target = plus(pose.eye, ahead);
    return left;
  }
  const aside = minus(pose.target, limits.pivot);
  const away = length(aside);
  if (away > pan) {
    const share = (pan + reduced(away - pan, GIVE.share * farthest)) / away - 1;
    pose.target = plus(pose.target, aside, share);
    pose.eye = plus(pose.eye, aside, share);
  }
  return left;
}

/** While the visitor pulls: the more a limit has given way, the less it gives. @param {Pose} pose @param {Limits} limits @param {Mode} mode */
export function resist(pose, limits, mode) {
  limit(pose, limits, (excess, most) => most * (1 - Math.exp(-excess / most)), mode);
}

/**
 * After the visitor lets go: return to the limits.
 *
 * @param {Pose} pose @param {Limits} limits @param {Mode} mode @param {number} seconds
 * @returns {boolean} whether it is still outside
 */
export function spring(pose, limits, mode, seconds) {
  const keep = Math.exp(-RETURN * seconds);
  const left = limit(pose, limits, (excess, most) => (excess < REST * most ? 0 : excess * keep), mode);
  return left > 0;
}

/** How far an orbit lies outside of its limits, as a share of how far they give way; 0 inside. @param {Pose} pose @param {Limits} limits */
export const excessOf = (pose, limits) => limit(pose.copy(), limits, (excess) => excess, "orbit");
