/**
 * Benchmark: renders a fixed camera path at a fixed size and waits for every frame.
 *
 * A frame of a sorted scene has the order of its own camera: sorting is part of the frame, and timed
 * apart. Phones slow down as they heat up, so rates are reported for the first seconds (cold), the last
 * ones (steady), and each second. They count whole frames and do not depend on the screen's refresh rate.
 */

import { Pose } from "./pose.js";
import { minus, plus } from "./vector.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{seconds: number, width: number, height: number}} Plan */
/** @typedef {{from: number, to: number, order: number | null}} Frame milliseconds, since the start and of sorting */
/** @typedef {{from: number, to: number, passes: Record<string, number>}} Sample of the passes of a frame */
/** @typedef {{percent: number, charging: boolean}} Battery */
/**
 * @typedef {object} Rate frames of a part of the run; times are milliseconds
 * @property {number} frames
 * @property {number} fps
 * @property {number} milliseconds median of a frame
 * @property {number} milliseconds95 that one frame in twenty exceeds
 * @property {number | null} order median of sorting, which is part of the frame; null: not sorted
 * @property {Record<string, number> | null} passes medians on the GPU; null where it has no timer
 */
/**
 * @typedef {object} Measured
 * @property {number} path frames until the path repeats
 * @property {Rate} cold
 * @property {Rate} steady
 * @property {Rate} whole
 * @property {(number | null)[]} fps_by_second null: no frame ended in that second
 * @property {number[] | null} fragments mean per pixel, by level; null if none were counted
 * @property {{start: Battery, end: Battery} | null} battery null where the browser does not tell
 * @property {boolean} interrupted whether the page was hidden
 */

const BETWEEN = 40; // frames from one training camera to the next
const TURN = 480; // frames of an orbit around a scene without cameras
const WARM = 10; // frames that are not counted, while shaders are compiled
const SPAN = 10; // most seconds that the cold and the steady rate are measured over
const COUNT_EVERY = 1000; // milliseconds between two counts of fragments
const PAUSE = 250; // milliseconds between two samples of the passes

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

/** Frames until the path repeats. @param {Viewer} viewer */
const pathOf = ({ views }) => (views.length < 2 ? TURN : BETWEEN * views.length);

/**
 * The pose of a frame: along the training cameras, or around the scene. It depends on the frame's number
 * alone, not on time.
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
 * @returns {Promise<Measured>}
 */
export async function runBench(viewer, plan, progress) {
  const start = viewer.pose.copy();
  let interrupted = document.hidden; // browsers render nothing in hidden pages
  const onHidden = () => (interrupted ||= document.hidden);
  document.addEventListener("visibilitychange", onHidden);
  viewer.measured = true;
  try {
    const before = await battery();
    const found = await measure(viewer, start, plan, progress);
    const after = await battery();
    return { ...found, battery: before && after && { start: before, end: after }, interrupted };
  } finally {
    document.removeEventListener("visibilitychange", onHidden);
    viewer.measured = false;
    viewer.place(start);
  }
}

/** @returns {Promise<Battery | null>} */
async function battery() {
  const found = await /** @type {any} */ (navigator).getBattery?.().catch(() => null);
  return found ? { percent: Math.round(100 * found.level), charging: found.charging } : null;
}

/** @param {Viewer} viewer @param {Pose} start @param {Plan} plan @param {(share: number) => void} progress */
async function measure(viewer, start, { seconds, width, height }, progress) {
  /** @type {Frame[]} */
  const frames = [];
  /** @type {Sample[]} */
  const samples = [];
  for (let frame = 0; frame < WARM; frame++) {
    viewer.pose = poseAt(viewer, start, frame);
    await viewer.drawAndWait(width, height);
  }
  await viewer.passes(); // some timers start with the first request
  const began = performance.now();
  /** @type {number[][]} */
  const counts = [];
  let sampled = 0;
  for (let frame = WARM, to = 0; to < 1000 * seconds; frame++) {
    viewer.pose = poseAt(viewer, start, frame);
    const from = performance.now() - began;
    const order = await viewer.drawAndWait(width, height);
    to = performance.now() - began;
    frames.push({ from, to, order });
    progress(Math.min(1, to / (1000 * seconds)));
    if (to - sampled < PAUSE) continue;
    const passes = await viewer.passes();
    if (passes) samples.push({ from, to, passes: { ...passes } });
    if (to > COUNT_EVERY * counts.length) {
      const count = await viewer.fragments();
      if (count) counts.push(count);
    }
    // let the page handle events and show the progress
    await new Promise((resolve) => requestAnimationFrame(resolve));
    sampled = performance.now() - began;
  }
  const span = 1000 * Math.min(SPAN, seconds / 2);
  const end = frames[frames.length - 1].to;
  const rate = (/** @type {(one: {from: number, to: number}) => boolean} */ within) =>
    rateOf(frames.filter(within), samples.filter(within));
  return {
    path: pathOf(viewer),
    cold: rate(({ from }) => from < span),
    steady: rate(({ to }) => to > end - span),
    whole: rate(() => true),
    fps_by_second: Array.from({ length: seconds }, (_, second) =>
      // the last frame ends after the last second
      fpsOf(frames.filter(({ to }) => Math.min(Math.floor(to / 1000), seconds - 1) === second)),
    ),
    fragments: counts.length
      ? counts[0].map((_, level) => round(counts.reduce((sum, count) => sum + count[level], 0) / counts.length))
      : null,
  };
}

const round = (/** @type {number} */ value) => Number(value.toFixed(2));

/** Frames per second of drawing; null without frames. @param {Frame[]} frames */
function fpsOf(frames) {
  const total = frames.reduce((sum, { from, to }) => sum + to - from, 0);
  return frames.length ? round((1000 * frames.length) / total) : null;
}

/** The value that a share of the values does not exceed. @param {number[]} values @param {number} share */
function quantile(values, share) {
  const sorted = values.slice().sort((a, b) => a - b);
  return round(sorted[Math.floor(share * (sorted.length - 1))] ?? NaN);
}

/** @param {Frame[]} frames @param {Sample[]} samples @returns {Rate} */
function rateOf(frames, samples) {
  const times = frames.map(({ from, to }) => to - from);
  const orders = frames.flatMap(({ order }) => order ?? []);
  const names = [...new Set(samples.flatMap(({ passes }) => Object.keys(passes)))];
  const medianOf = (/** @type {string} */ name) => quantile(samples.flatMap(({ passes }) => passes[name] ?? []), 0.5);
  return {
    frames: times.length,
    fps: fpsOf(frames) ?? NaN,
    milliseconds: quantile(times, 0.5),
    milliseconds95: quantile(times, 0.95),
    order: orders.length ? quantile(orders, 0.5) : null,
    passes: names.length ? Object.fromEntries(names.map((name) => [name, medianOf(name)])) : null,
  };
}
