/**
 * How fast a device draws a scene: a fixed path at a fixed size, every frame waited for.
 *
 * Two figures matter on a phone: the rate while it is cold, and the one that its heat leaves it. Both
 * count whole frames, from the camera to the picture, without the screen's own pace.
 */

import { Pose } from "./pose.js";
import { minus, plus } from "./vector.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{seconds: number, width: number, height: number}} Plan */
/** @typedef {{frames: number, fps: number, milliseconds: number, milliseconds95: number}} Rate */

const BETWEEN = 40; // frames from one training camera to the next
const TURN = 480; // frames of a turn around a scene without cameras
const WARM = 10; // frames that are not counted: shaders may still be compiled
const SPAN = 10; // seconds that each of the two rates is taken from, at most

/**
 * The plan that an address asks for: `60`, or `60,1600x1063`.
 *
 * @param {string} text
 * @param {{width: number, height: number}} screen device pixels
 * @returns {Plan}
 */
export function planOf(text, screen) {
  const [, seconds, width, height] = /^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(text) ?? [];
  return {
    seconds: Math.min(Math.max(Number(seconds) || 60, 1), 3600),
    width: Math.min(Number(width) || screen.width, 8192),
    height: Math.min(Number(height) || screen.height, 8192),
  };
}

/**
 * The pose of a frame: through the training cameras in turn, or around the scene.
 *
 * @param {Viewer} viewer
 * @param {Pose} start
 * @param {number} frame
 */
function poseAt(viewer, start, frame) {
  const { views } = viewer;
  if (views.length < 2) {
    const pose = start.copy();
    pose.orbit((2 * Math.PI * frame) / TURN, 0.2 * Math.sin((6 * Math.PI * frame) / TURN));
    return pose;
  }
  const index = Math.floor(frame / BETWEEN);
  const [from, to] = [index, index + 1].map((i) => Pose.fromViews(views, i % views.length));
  const share = (frame % BETWEEN) / BETWEEN;
  const eye = plus(from.eye, minus(to.eye, from.eye), share);
  const target = plus(from.target, minus(to.target, from.target), share);
  return new Pose(eye, target, from.up);
}

/**
 * Drives the viewer along the path; its pose is afterwards what it was. Meanwhile nothing else draws.
 *
 * @param {Viewer} viewer with a scene that is complete
 * @param {Plan} plan
 * @param {(share: number) => void} progress
 */
export async function runBench(viewer, plan, progress) {
  const start = viewer.pose.copy();
  viewer.measured = true;
  try {
    return await driven(viewer, start, plan, progress);
  } finally {
    viewer.measured = false;
    viewer.place(start);
  }
}

/** @param {Viewer} viewer @param {Pose} start @param {Plan} plan @param {(share: number) => void} progress */
async function driven(viewer, start, { seconds, width, height }, progress) {
  /** @type {{at: number, took: number}[]} */
  const frames = [];
  const draw = async (/** @type {number} */ frame) => {
    viewer.pose = poseAt(viewer, start, frame);
    await viewer.drawAndWait(width, height);
  };
  for (let frame = 0; frame < WARM; frame++) await draw(frame);
  /** @type {Record<string, number>[]} */
  const passes = [];
  const began = performance.now();
  for (let frame = WARM, at = 0; at < 1000 * seconds; frame++) {
    const before = performance.now();
    await draw(frame);
    const now = performance.now();
    at = now - began;
    frames.push({ at, took: now - before });
    progress(Math.min(1, at / (1000 * seconds)));
    // lets the page breathe, and shows that something happens
    if ((frame - WARM) % 30 !== 0) continue;
    const found = await viewer.passes();
    if (found) passes.push(found);
    await new Promise((resolve) => requestAnimationFrame(resolve));
  }
  const span = 1000 * Math.min(SPAN, seconds / 2);
  const end = frames[frames.length - 1].at;
  return {
    width,
    height,
    seconds,
    cold: rateOf(frames.filter(({ at }) => at <= span)),
    steady: rateOf(frames.filter(({ at }) => at > end - span)),
    passes: passes.length ? mediansOf(passes) : null,
  };
}

/** Milliseconds of each pass. @param {Record<string, number>[]} found */
function mediansOf(found) {
  const median = (/** @type {number[]} */ values) => values.sort((a, b) => a - b)[values.length >> 1];
  return Object.fromEntries(Object.keys(found[0]).map((pass) => [pass, median(found.map((one) => one[pass]))]));
}

/** @param {{took: number}[]} frames @returns {Rate} */
function rateOf(frames) {
  const times = frames.map(({ took }) => took).sort((a, b) => a - b);
  const total = times.reduce((sum, time) => sum + time, 0);
  const at = (/** @type {number} */ share) => times[Math.floor(share * (times.length - 1))] ?? NaN;
  const round = (/** @type {number} */ value) => Number(value.toFixed(2));
  return {
    frames: times.length,
    fps: round((1000 * times.length) / total),
    milliseconds: round(at(0.5)),
    milliseconds95: round(at(0.95)),
  };
}
