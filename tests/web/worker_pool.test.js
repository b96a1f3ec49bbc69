import assert from "node:assert/strict";
import test from "node:test";

import { WorkerPool } from "../../viewer/src/load/worker_pool.js";
import { COMPLETE } from "../../viewer/src/mgs/stream_decoder.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { GaussianDecoder } from "../../viewer/src/mgs/gaussian_decoder.js";
import { packRows } from "../../viewer/src/render/pack.js";
import { openScene } from "./whole.js";
import { layeredScene, seal, smallScene } from "./write.js";

const COUNT = 100_000;
const PARTS = ["shapes", "colors", "lobes"];

/** A stand-in for Worker that runs in this thread. */
class Helper {
  static made = [];
  static brings = true;
  sent = 0;
  #decoder;
  #live = true;

  constructor() {
    Helper.made.push(this);
  }

  postMessage(message, options) {
    const { decoderInputs, rows, chunk, stage } = structuredClone(message, options);
    if (decoderInputs) this.#decoder = new GaussianDecoder(decoderInputs);
    else this.sent++;
    if (!rows || !Helper.brings) return;
    setTimeout(() => {
      if (!this.#live) return;
      this.onmessage({ data: { chunk, stage, packed: packRows(this.#decoder, rows) } });
    }, 1);
  }

  terminate() {
    this.#live = false;
  }
}

globalThis.self = { location: { href: "worker.js" } };
Object.defineProperty(globalThis, "navigator", { value: { hardwareConcurrency: 8 }, configurable: true });
globalThis.Worker = Helper;

const { fields, streams } = smallScene(COUNT);
const bytes = seal(fields, streams);
const expected = openScene(bytes).words;

/** All packed words of a pool's results. @param {WorkerPool} pool */
function wordsOf(pool) {
  const found = Object.fromEntries(PARTS.map((part) => [part, new Uint32Array(expected[part].length)]));
  for (const [from, packed] of pool.results) {
    for (const part of PARTS) found[part].set(packed[part], (expected[part].length / COUNT) * from);
  }
  return found;
}

for (const [name, Worker, brings] of [
  ["helpers do some of the rows", Helper, true],
  ["rows that helpers do not return are packed without them", Helper, false],
  ["a pool works without helpers", undefined, true],
]) {
  test(name, async () => {
    Object.assign(Helper, { made: [], brings });
    globalThis.Worker = Worker;
    const reader = new SceneReader();
    reader.append(bytes);
    while (reader.step());
    const pool = new WorkerPool([COUNT]);
    pool.start(reader.decoder);
    assert.equal(Helper.made.length, 0);
    pool.spawn();
    assert.equal(Helper.made.length, Worker ? 3 : 0);
    pool.advance(0, COMPLETE);
    assert.equal(pool.levels, 0);
    assert.ok(!pool.firstLevelReady);
    await pool.finish();
    assert.equal(pool.levels, 1);
    assert.ok(pool.firstLevelReady);
    pool.terminate();
    assert.deepEqual(wordsOf(pool), expected);
    assert.equal(Helper.made.some(({ sent }) => sent > 2), Boolean(Worker && brings));
  });
}

test("a later stage replaces an earlier result", async () => {
  Object.assign(Helper, { made: [], brings: true });
  globalThis.Worker = Helper;
  const reader = new SceneReader();
  const cut = bytes.length - 70_000; // lobes are missing
  reader.append(bytes.subarray(0, cut));
  while (reader.step());
  assert.equal(reader.decoder.levels[0].stage, 2);
  const pool = new WorkerPool([COUNT]);
  pool.start(reader.decoder);
  pool.spawn();
  pool.advance(0, 2);
  while (!pool.results.length) await new Promise((resolve) => setTimeout(resolve, 1));
  reader.append(bytes.subarray(cut));
  while (reader.step());
  pool.advance(0, reader.decoder.levels[0].stage);
  await pool.finish();
  pool.terminate();
  assert.deepEqual(wordsOf(pool), expected);
});

test("early results are copied to the output and later ones replace them", async () => {
  globalThis.Worker = undefined;
  const reader = new SceneReader();
  const cut = bytes.length - 70_000; // lobes are missing
  reader.append(bytes.subarray(0, cut));
  while (reader.step());
  const pool = new WorkerPool([COUNT]);
  pool.start(reader.decoder);
  pool.advance(0, 2);
  while (!pool.results.length) await new Promise((resolve) => setTimeout(resolve, 1));
  const early = pool.results.length;
  const room = Object.fromEntries(PARTS.map((part) => [part, new Uint32Array(expected[part].length)]));
  pool.output = room;
  assert.equal(pool.results.length, 0);
  assert.deepEqual(room.colors.subarray(0, 4 * 8192), expected.colors.subarray(0, 4 * 8192));
  reader.append(bytes.subarray(cut));
  while (reader.step());
  pool.advance(0, reader.decoder.levels[0].stage);
  await pool.finish();
  assert.equal(pool.results.length, 0);
  assert.deepEqual(room, expected);
});

test("levels are computed separately and counted from the first", async () => {
  Object.assign(Helper, { made: [], brings: true });
  globalThis.Worker = Helper;
  const sizes = [10_000, COUNT - 10_000];
  const { fields, shared, own, alone } = layeredScene(sizes);
  const reader = new SceneReader();
  reader.append(seal(fields, [...shared, ...own.flat()], 3));
  while (reader.step());
  const pool = new WorkerPool(sizes);
  pool.start(reader.decoder);
  pool.spawn();
  pool.advance(1, COMPLETE);
  while (pool.results.length < Math.ceil(sizes[1] / 8192)) await new Promise((resolve) => setTimeout(resolve, 1));
  assert.equal(pool.levels, 0);
  assert.ok(!pool.firstLevelReady); // no row of the first level was packed
  assert.ok(pool.results.every(([from]) => from >= sizes[0]));
  pool.advance(0, COMPLETE);
  await pool.finish();
  pool.terminate();
  assert.equal(pool.levels, 2);
  const words = alone.map(({ fields, streams }) => openScene(seal(fields, streams)).words);
  const found = wordsOf(pool);
  for (const part of PARTS) {
    const [first, second] = words.map((own) => own[part]);
    assert.deepEqual(found[part].subarray(0, first.length), first);
    assert.deepEqual(found[part].subarray(first.length), second);
  }
});

test("finish reports errors", async () => {
  globalThis.Worker = undefined;
  const reader = new SceneReader();
  reader.append(bytes);
  while (reader.step());
  const pool = new WorkerPool([COUNT]);
  pool.start(reader.decoder);
  reader.decoder.levels[0].rows = () => {
    throw new RangeError("no memory");
  };
  pool.advance(0, 1);
  await assert.rejects(pool.finish(), /no memory/);
});
