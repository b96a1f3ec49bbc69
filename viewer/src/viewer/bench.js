/**
 * Benchmark: renders a fixed camera path at a fixed size and waits for every frame.
 *
 * It reports two rates, since phones slow down as they heat up: cold, from the first seconds, and steady,
 * from the last ones. Both count whole frames and do not depend on the screen's refresh rate.
 */

import { Pose } from "./pose.js";
import { minus, plus } from "./vector.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{seconds: number, width: number, height: number}} Plan */
/** @typedef {{frames: number, fps: number, milliseconds: number, milliseconds95: number}} Rate */

const BETWEEN = 40; // frames from one training camera to the next
const TURN = 480; // frames of an orbit around a scene without cameras
const WARM = 10; // frames that are not counted, while shaders are compiled
const SPAN = 10; // most seconds that each rate is measured over

/**
 * Parse the URL parameter `bench`: `60`, or `60,1600x1063`.
 *
 * @param {string} text
 * @param {{width: number, height: number}} screen device pixels
 * @returns {Plan}
 */
export function parsePlan(text, screen) {
  const [, seconds, width, height] = /^(?:(\d+)(?:,|$))?(?:(\d+)x(\d+))?$/.exec(text) ?? [];
  return {
    seconds: Math.min(Math.max(Number(seconds) || 60, 1), 3600),
    width: Math.min(Number(width) || screen.width, 8192),
    height: Math.min(Number(height) || screen.height, 8192),
  };
}

/**
 * The pose of a frame: along the training cameras, or around the scene.
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
 * Run the benchmark. Nothing else renders meanwhile; the pose is restored at the end.
 *
 * @param {Viewer} viewer with a complete scene
 * @param {Plan} plan
 * @param {(share: number) => void} progress
 */
export async function runBench(viewer, plan, progress) {
  const start = viewer.pose.copy();
  viewer.measured = true;
  try {
    return await measure(viewer, start, plan, progress);
  } finally {
    viewer.measured = false;
    viewer.place(start);
  }
}

/** @param {Viewer} viewer @param {Pose} start @param {Plan} plan @param {(share: number) => void} progress */
async function measure(viewer, start, { seconds, width, height }, progress) {
  /** @type {{at: number, duration: number}[]} */
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
    frames.push({ at, duration: now - before });
    progress(Math.min(1, at / (1000 * seconds)));
    // let the page handle events and show the progress
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

/** @param {{duration: number}[]} frames @returns {Rate} */
function rateOf(frames) {
  const times = frames.map(({ duration }) => duration).sort((a, b) => a - b);
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
