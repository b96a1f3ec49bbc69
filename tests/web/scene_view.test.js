import assert from "node:assert/strict";
import { register } from "node:module";
import test, { beforeEach } from "node:test";

// in place of the modules that the build makes: each contains `{}`
const HOOK = `export const resolve = (name, context, next) =>
  name.endsWith(".packed.js")
    ? { url: 'data:text/javascript,export const text = "eNqrrgUAAXUA+Q=="', shortCircuit: true }
    : next(name, context);`;
register(`data:text/javascript,${encodeURIComponent(HOOK)}`);
const { SceneView } = await import("../../viewer/src/viewer/scene_view.js");

const TOLD = ["progress", "arrived", "ordered", "loaded", "failed", "broken"];
const COMPLETE = "complete";

/** A thread that says what a test has it say. */
class Thread {
  static all = [];
  ended = false;

  constructor() {
    Thread.all.push(this);
  }

  postMessage(request) {
    this.request = request;
  }

  terminate() {
    this.ended = true;
  }

  async says(message) {
    this.onmessage({ data: message });
    await soon();
  }
}

/** Wait until what has been begun is done: messages arrive a little later. */
const soon = () => new Promise((resolve) => setTimeout(resolve, 20));

/** The thread that an action starts, once it has its request: its program is unpacked first. */
async function startedBy(act) {
  const known = Thread.all.length;
  act();
  for (let waits = 0; waits < 500 && !Thread.all[known]?.request; waits++) await soon();
  return Thread.all.at(-1);
}

/** Something that looks like WebGL2 and draws nothing; `events` are what its canvas listens to. */
function contextOf(events) {
  const canvas = {
    width: 1,
    height: 1,
    addEventListener: (name, listener) => (events[name] = listener),
    removeEventListener() {},
  };
  const known = {
    canvas,
    getParameter: () => 8192,
    checkFramebufferStatus: () => COMPLETE,
    FRAMEBUFFER_COMPLETE: COMPLETE,
    isContextLost: () => false,
    getExtension: (name) => (/provoking|debug/.test(name) ? null : {}),
    getProgramParameter: () => true,
  };
  const get = (_, name) => known[name] ?? (/^[A-Z0-9_]+$/.test(name) ? name : () => ({}));
  return new Proxy({}, { get });
}

const dots = (count) => ({
  kind: "dots",
  dots: { means: new Float32Array(3 * count), color: [0, 0, 0], side: 1, background: [0, 0, 0] },
  views: [],
  near: 0.2,
});
const scene = (count) => ({
  kind: "scene",
  data: {
    count,
    packing: { center: [0, 0, 0], unit: 1, leastScaleBits: 0, scaleBitsSpan: 0 },
    shapes: new Uint32Array(4 * count),
    colors: new Uint32Array(4 * count),
    lobes: new Uint32Array(count),
    shSize: 4,
    lobeSize: 1,
    sorted: false,
    weighting: { index: 0, exponentMax: 4, sigma: 1, backgroundWeight: 0, alphaMin: 1 / 64 },
    background: [0, 0, 0],
  },
  means: new Float32Array(3 * count),
  views: [],
  near: 0.2,
});
const done = (bytes) => ({ kind: "done", milliseconds: 1, bytes });
const progress = (received) => ({ kind: "progress", received, total: 10 });
const failed = { kind: "failed", sentence: "this is no scene" };

/** A view that can draw, and what it tells. */
async function begun() {
  const [events, log] = [{}, []];
  const listener = Object.fromEntries(TOLD.map((name) => [name, (...words) => log.push([name, ...words].join(" "))]));
  const canvas = { width: 1, height: 1, getContext: (name) => (name === "webgl2" ? contextOf(events) : null) };
  const view = new SceneView(canvas, { ...listener, changed() {} }, { floats: false, strips: false }, false);
  assert.ok(await view.begin("webgl"));
  const asked = (url) => startedBy(() => view.load({ url }));
  return { view, log, events, asked };
}

beforeEach(() => {
  Thread.all = [];
  globalThis.Worker = Thread;
  globalThis.window = globalThis;
});

for (const [when, parts] of [
  ["shows dots", [dots(3)]],
  ["shows some of it", [dots(3), scene(7)]],
]) {
  test(`a scene requested while the previous one ${when} replaces it`, async () => {
    const { view, log, asked } = await begun();
    const first = await asked("first");
    for (const part of parts) await first.says(part);
    assert.deepEqual(log.splice(0), ["arrived"]);
    const second = await asked("second");
    await first.says(scene(7)); // it is still the one to be seen
    assert.equal(view.count, 7);
    await second.says(progress(5));
    await first.says(progress(9));
    await first.says(done(100));
    await first.says(failed);
    assert.deepEqual(log.splice(0), ["progress 0.5"]);
    await second.says(dots(2));
    await first.says(scene(7));
    await second.says(scene(5));
    await second.says(done(200));
    assert.deepEqual(log, ["arrived", "loaded 1 200"]);
    assert.equal(view.count, 5);
    assert.deepEqual(view.request, { url: "second" });
    assert.ok(first.ended && second.ended);
  });
}

test("a failed scene keeps the previous one, which is restored with its context", async () => {
  const { view, log, events, asked } = await begun();
  const first = await asked("first");
  for (const part of [scene(7), done(100)]) await first.says(part);
  const second = await asked("second");
  await second.says(failed);
  assert.deepEqual(log.splice(0), ["arrived", "loaded 1 100", "failed this is no scene true"]);
  assert.ok(second.ended && !view.broken);
  assert.equal(view.count, 7);

  events.webglcontextlost({ preventDefault() {} });
  assert.ok(view.broken);
  const again = await startedBy(() => events.webglcontextrestored());
  assert.deepEqual(again.request, { url: "first" });
  for (const part of [scene(7), done(100)]) await again.says(part);
  assert.ok(!view.broken);
  // it had arrived before
  assert.deepEqual(log.map((line) => line.split(" ")[0]), ["broken", "loaded"]);
});

test("the error of a failed file stays while the previous scene is still loading", async () => {
  const { view, log, asked } = await begun();
  const first = await asked("first");
  await first.says(scene(7));
  const second = await asked("second");
  await second.says(failed);
  for (const more of [progress(9), done(100)]) await first.says(more);
  assert.deepEqual(log, ["arrived", "failed this is no scene true"]);
  assert.equal(view.count, 7);
});

test("a scene that was loading when the context was lost arrives as a new one", async () => {
  const { view, log, events, asked } = await begun();
  await (await asked("first")).says(scene(7));
  await asked("second");
  events.webglcontextlost({ preventDefault() {} });
  const again = await startedBy(() => events.webglcontextrestored());
  assert.deepEqual(again.request, { url: "second" });
  await again.says(scene(5));
  assert.deepEqual(log.map((line) => line.split(" ")[0]), ["arrived", "broken", "arrived"]);
  assert.equal(view.count, 5);
});

test("sort waits for the order of its camera, also after an earlier request", async () => {
  const { view, log, asked } = await begun();
  const worker = await asked("first");
  const sorted = scene(7);
  sorted.data.sorted = true;
  for (const part of [sorted, done(100)]) await worker.says(part);
  assert.ok(!worker.ended);
  const order = () => ({ kind: "order", order: Uint32Array.from([0, 1, 2, 3, 4, 5, 6]) });
  const looking = (...forward) => ({ viewmat: [1, 0, 0, 0, 0, 1, 0, 0, ...forward, 0, 0, 0, 0, 1], width: 9, height: 9 });
  view.draw(looking(0, 0, 1)); // does not wait
  await soon();
  assert.deepEqual(worker.request, { forward: [0, 0, 1] });
  let took = null;
  const waiting = view.sort(looking(0, 0.001, 1)).then((milliseconds) => (took = milliseconds));
  await worker.says(order()); // of the first camera
  assert.equal(took, null);
  assert.deepEqual(worker.request, { forward: [0, 0.001, 1] }); // though the direction is nearly the same
  await worker.says(order());
  await waiting;
  assert.ok(took >= 0);

  const lost = assert.rejects(view.sort(looking(1, 0, 0)), /another scene was opened/);
  await (await asked("second")).says(scene(5));
  await lost;
  assert.equal(await view.sort(looking(1, 0, 0)), null); // it is not sorted
  assert.deepEqual(log.filter((line) => line === "ordered").length, 2);
});
