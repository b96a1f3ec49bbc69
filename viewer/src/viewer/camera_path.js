/** Flights of the camera: to a place, and along the path that a file's notes hold. */

import { length, minus, plus, unit } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */
/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{eye: Vector, target: Vector, up?: Vector}} Key pose on a path */
/** @typedef {Record<string, unknown>} Notes */

const FLIGHT = 0.9; // seconds of a flight to a place
const LEG = 3; // seconds between two key poses
const NUMBER = /^-?\d{1,12}(\.\d{1,12})?$/;
const NOTES_MAX = 64;
/** Inputs that stop a flight. */
const STOPS = ["pointerdown", "wheel", "keydown"];

/** The texts of a note and of those that continue it: `path`, `path.2`, ... @param {Notes} notes @param {string} name */
export function continued(notes, name) {
  const texts = [];
  for (let number = 1; number <= NOTES_MAX; number++) {
    const text = notes[number === 1 ? name : `${name}.${number}`];
    if (typeof text !== "string") break;
    texts.push(text);
  }
  return texts;
}

/** The key poses of a file's path; none if a pose is not six numbers. @param {Notes} notes @returns {Key[]} */
export function parsedPath(notes) {
  const poses = continued(notes, "path").flatMap((text) => text.split(";"));
  const keys = poses.map((pose) => {
    const words = pose.trim().split(/\s+/);
    const numbers = words.length === 6 && words.every((word) => NUMBER.test(word)) ? words.map(Number) : [];
    return { eye: /** @type {Vector} */ (numbers.slice(0, 3)), target: /** @type {Vector} */ (numbers.slice(3)) };
  });
  const valid = keys.every(({ eye, target }) => eye.length === 3 && length(minus(target, eye)) > 0);
  return valid ? keys : [];
}

/**
 * The pose at a place of a smooth curve through all keys (Catmull-Rom).
 *
 * @param {Key[]} keys at least one
 * @param {number} at from 0, the first key, to the last one's index
 * @returns {Key}
 */
export function poseAt(keys, at) {
  const from = Math.min(Math.floor(at), Math.max(keys.length - 2, 0));
  const t = at - from;
  const key = (/** @type {number} */ i) => keys[Math.min(Math.max(i, 0), keys.length - 1)];
  const [a, b, c, d] = [-1, 0, 1, 2].map((step) => key(from + step));
  const curve = (/** @type {"eye" | "target"} */ part) =>
    /** @type {Vector} */ (
      b[part].map((value, k) => {
        const [p, q, r] = [a[part][k], c[part][k], d[part][k]];
        const slope = (q - p) / 2;
        const bend = (r - value) / 2;
        const square = 3 * (q - value) - 2 * slope - bend;
        return value + t * (slope + t * (square + t * (2 * (value - q) + slope + bend)));
      })
    );
  return { eye: curve("eye"), target: curve("target") };
}

/**
 * Fly to a pose.
 *
 * @param {Viewer} viewer
 * @param {EventTarget} input whose inputs stop the flight
 * @param {Key} to
 * @param {{seconds?: number, signal?: AbortSignal}} [options]
 * @returns {Promise<boolean>} whether it arrived
 */
export function flyTo(viewer, input, to, { seconds: duration = FLIGHT, signal } = {}) {
  const { eye, target, up } = viewer.pose;
  return new Promise((resolve) => {
    const stop = animate(viewer, input, (seconds) => {
      const share = duration > 0 ? Math.min(seconds / duration, 1) : 1;
      const eased = share * share * (3 - 2 * share);
      const key = poseAt([{ eye, target }, to], eased);
      if (to.up) key.up = unit(plus(up, minus(to.up, up), eased));
      return { key, last: share === 1 };
    }, resolve);
    if (signal?.aborted) stop();
    signal?.addEventListener("abort", stop, { once: true });
  });
}

/**
 * Fly along a path and back, again and again.
 *
 * @param {Viewer} viewer
 * @param {EventTarget} input whose inputs stop the flight
 * @param {Key[]} keys at least two
 * @returns {() => void} stops it
 */
export function play(viewer, input, keys) {
  const legs = keys.length - 1;
  return animate(viewer, input, (seconds) => {
    const swing = (1 - Math.cos((Math.PI * seconds) / (LEG * legs))) / 2; // slow at both ends
    return { key: poseAt(keys, legs * swing), last: false };
  });
}

/** The controller that stops the flight of a viewer, for another flight. @type {WeakMap<Viewer, AbortController>} */
const flights = new WeakMap();

/**
 * @param {Viewer} viewer
 * @param {EventTarget} input
 * @param {(seconds: number) => {key: Key, last: boolean}} at the pose after some seconds
 * @param {(arrived: boolean) => void} [ended]
 * @returns {() => void} stops it
 */
function animate(viewer, input, at, ended = () => {}) {
  const started = performance.now();
  const over = new AbortController();
  flights.get(viewer)?.abort();
  flights.set(viewer, over);
  over.signal.addEventListener("abort", () => ended(false));
  for (const kind of STOPS) input.addEventListener(kind, () => over.abort(), { signal: over.signal, capture: true });
  const step = () => {
    if (over.signal.aborted) return;
    const { key, last } = at((performance.now() - started) / 1000);
    const pose = viewer.pose.copy();
    pose.eye = key.eye;
    pose.target = key.target;
    pose.up = key.up ?? pose.up;
    viewer.place(pose);
    if (!last) return void requestAnimationFrame(step);
    ended(true);
    over.abort();
  };
  step();
  return () => over.abort();
}
