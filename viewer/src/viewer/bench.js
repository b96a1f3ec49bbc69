/**
 * Benchmark: renders a fixed camera path at a fixed size, in batches between two finished queues.
 *
 * A batch begins when the GPU has nothing left to do, and ends when it has drawn the last frame. A phone's GPU takes
 * milliseconds to answer, so that waiting for each frame would measure the answers, and not waiting the queue.
 * A frame of a sorted scene has the order of its own camera: sorting is part of the frame, and timed
 * apart. Phones slow down as they heat up, so rates are reported for the first seconds (cold), the last
 * ones (steady), and each second. They count whole frames and do not depend on the screen's refresh rate.
 */

import { Pose } from "./pose.js";
import { minus, plus } from "./vector.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {{seconds: number, width: number, height: number}} Plan */
/** @typedef {{from: number, to: number, frames: number, orders: number[]}} Batch milliseconds, since the start and of sorting each frame */
/** @typedef {{from: number, to: number, passes: Record<string, number>}} Sample of the passes of a frame */
/** @typedef {{percent: number, charging: boolean}} Battery */
/**
 * @typedef {object} Rate frames of a part of the run; times are milliseconds
 * @property {number} frames
 * @property {number} fps
 * @property {number} milliseconds of a frame, median of the batches
 * @property {number} milliseconds95 that one batch in twenty exceeds
 * @property {number | null} order median of sorting, which is part of the frame; null: not sorted
 * @property {Record<string, number> | null} passes medians on the GPU; null where it has no timer
 */
/**
 * @typedef {object} Measured
 * @property {number} path frames until the path repeats
 * @property {number} batch most frames of a batch
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
const BATCH = 250; // milliseconds that a batch should take
const MOST = 128; // frames of a batch: a queue has an end

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
  const began = performance.now();
  let drawn = 0;
  /** Frames from an empty queue to an empty queue. @param {number} frames @returns {Promise<Batch>} */
  const draw = async (frames) => {
    const from = performance.now();
    const orders = [];
    for (let i = 0; i < frames; i++) {
      viewer.pose = poseAt(viewer, start, drawn++);
      orders.push((await viewer.drawAt(width, height)) ?? []);
    }
    await viewer.finished();
    return { from: from - began, to: performance.now() - began, frames, orders: orders.flat() };
  };
  const warm = await draw(WARM);
  await viewer.passes(); // some timers start with the first request
  const first = performance.now() - began;
  const end = first + 1000 * seconds;
  /** @type {Batch[]} */
  const batches = [];
  /** @type {Sample[]} */
  const samples = [];
  /** @type {number[][]} */
  const counts = [];
  for (let last = warm; last.to < end; ) {
    const size = Math.round((BATCH * last.frames) / (last.to - last.from));
    await viewer.finished();
    last = await draw(Math.min(Math.max(1, size), MOST));
    batches.push(last);
    progress(Math.min(1, (last.to - first) / (1000 * seconds)));
    const passes = await viewer.passes();
    if (passes) samples.push({ from: last.from, to: last.to, passes: { ...passes } });
    if (last.to - first > COUNT_EVERY * counts.length) {
      const count = await viewer.fragments();
      if (count) counts.push(count);
    }
    // let the page handle events and show the progress
    await new Promise((resolve) => requestAnimationFrame(resolve));
  }
  const span = 1000 * Math.min(SPAN, seconds / 2);
  const { to } = batches[batches.length - 1];
  const rate = (/** @type {(one: {from: number, to: number}) => boolean} */ within) =>
    rateOf(batches.filter(within), samples.filter(within));
  return {
    path: pathOf(viewer),
    batch: Math.max(...batches.map(({ frames }) => frames)),
    cold: rate((one) => one.from < first + span),
    steady: rate((one) => one.to > to - span),
    whole: rate(() => true),
    fps_by_second: Array.from({ length: seconds }, (_, second) =>
      // the last batch ends after the last second
      fpsOf(batches.filter((one) => Math.min(Math.floor((one.to - first) / 1000), seconds - 1) === second)),
    ),
    fragments: counts.length
      ? counts[0].map((_, level) => round(counts.reduce((sum, count) => sum + count[level], 0) / counts.length))
      : null,
  };
}

const round = (/** @type {number} */ value) => Number(value.toFixed(2));

/** Frames per second of drawing; null without frames. @param {Batch[]} batches */
function fpsOf(batches) {
  const [frames, total] = batches.reduce(([sum, took], { from, to, frames }) => [sum + frames, took + to - from], [0, 0]);
  return frames ? round((1000 * frames) / total) : null;
}

/** The value that a share of the values does not exceed. @param {number[]} values @param {number} share */
function quantile(values, share) {
  const sorted = values.slice().sort((a, b) => a - b);
  return round(sorted[Math.floor(share * (sorted.length - 1))] ?? NaN);
}

/** @param {Batch[]} batches @param {Sample[]} samples @returns {Rate} */
function rateOf(batches, samples) {
  const times = batches.map(({ from, to, frames }) => (to - from) / frames);
  const orders = batches.flatMap(({ orders }) => orders);
  const names = [...new Set(samples.flatMap(({ passes }) => Object.keys(passes)))];
  const medianOf = (/** @type {string} */ name) => quantile(samples.flatMap(({ passes }) => passes[name] ?? []), 0.5);
  return {
    frames: batches.reduce((sum, { frames }) => sum + frames, 0),
    fps: fpsOf(batches) ?? NaN,
    milliseconds: quantile(times, 0.5),
    milliseconds95: quantile(times, 0.95),
    order: orders.length ? quantile(orders, 0.5) : null,
    passes: names.length ? Object.fromEntries(names.map((name) => [name, medianOf(name)])) : null,
  };
}
