import assert from "node:assert/strict";
import test from "node:test";
import { isDeepStrictEqual } from "node:util";

import { SceneError } from "../../viewer/src/mgs/error.js";
import { COMPLETE } from "../../viewer/src/mgs/stream_decoder.js";
import { worldMeans } from "../../viewer/src/mgs/positions.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { pieces, randomNumbers } from "./pieces.js";
import { openScene, sceneOf } from "./whole.js";
import { layeredScene, seal } from "./write.js";

const PARTS = ["shapes", "colors", "lobes"];
const LAYERS = [40, 100, 1, 9000];
const { fields, shared, own, alone } = layeredScene(LAYERS);
const BYTES = seal(fields, [...shared, ...own.flat()], 3);
const ENDS = endsOf(BYTES, own);
/** The scene that each number of layers is, packed. */
const COARSER = LAYERS.map((_, i) => joinedWords(alone.slice(0, i + 1)));

/** Where the layers end in the file. */
function endsOf(bytes, own) {
  const lengths = own.map((streams) => streams.reduce((sum, [, , data]) => sum + Math.ceil(data.length / 8) * 8, 0));
  return lengths.map((_, i) => bytes.length - lengths.slice(i + 1).reduce((a, b) => a + b, 0));
}

/** Words of some scenes one behind the other. */
function joinedWords(scenes) {
  const all = scenes.map(({ fields, streams }) => openScene(seal(fields, streams)).words);
  return Object.fromEntries(PARTS.map((part) => [part, all.flatMap((words) => [...words[part]])]));
}

function wordsOf({ words }) {
  return Object.fromEntries(PARTS.map((part) => [part, [...words[part]]]));
}

/** What a page shows that the worker's messages come to. */
class Page {
  shown = 0;
  words = null;
  dots = null;
  sentence = "";
  done = false;
  onChange = () => {};

  receive(message) {
    if (message.kind === "dots") this.dots = message.dots;
    else if (message.kind === "scene") {
      const { data, means } = message;
      this.shown = worldMeans(means).length / 3;
      this.words = data;
      this.size = data.count;
    } else if (message.kind === "rows") {
      const stride = this.words[message.part].length / this.size;
      this.words[message.part].set(message.numbers, stride * message.from);
    } else if (message.kind === "more") {
      const { length } = worldMeans(message.means);
      assert.ok(length > 3 * this.shown);
      this.shown = length / 3;
    } else if (message.kind === "failed") this.sentence = message.sentence;
    else if (message.kind === "done") this.done = true;
    this.onChange(message);
  }

  /** Words of the Gaussians that are drawn. */
  get drawn() {
    const entries = PARTS.map((part) => {
      const stride = this.words[part].length / this.size;
      return [part, [...this.words[part].subarray(0, stride * this.shown)]];
    });
    return Object.fromEntries(entries);
  }
}

let page = new Page();
globalThis.self = {
  location: { href: "worker.js" },
  postMessage: (message, { transfer }) => page.receive(structuredClone(message, { transfer })),
};
globalThis.Worker = undefined;
await import("../../viewer/src/load/worker.js");

/** Loads bytes as the worker does that a page starts. @param {BlobPart} bytes */
async function loaded(bytes) {
  page = new Page();
  await globalThis.self.onmessage({ data: { file: new Blob([bytes]) } });
  return page;
}

test("LOD levels decode like separate files, whole and in pieces", () => {
  assert.deepEqual(wordsOf(openScene(BYTES)), COARSER[3]);
  const random = randomNumbers(7);
  for (let i = 0; i < 5; i++) {
    const reader = new SceneReader();
    for (const piece of pieces(BYTES, random)) {
      reader.append(piece);
      while (reader.step());
    }
    reader.end();
    assert.deepEqual(wordsOf(sceneOf(reader)), COARSER[3]);
  }
});

test("dots of the first level come first, in the mean colour", async () => {
  const kinds = [];
  page = new Page();
  page.onChange = ({ kind }) => kinds.push(kind);
  await globalThis.self.onmessage({ data: { file: new Blob([BYTES]) } });
  assert.deepEqual(kinds.filter((kind) => kind !== "progress").slice(0, 2), ["dots", "scene"]);
  const { header, scene } = openScene(BYTES);
  const { means, color, side, background } = page.dots;
  assert.deepEqual(means, scene.means.subarray(0, 3 * LAYERS[0]));
  assert.deepEqual(background, [...header.background]);
  assert.ok(side > 0 && color.length === 3 && color.every(Number.isFinite));
});

test("streams in another order give the same scene", async () => {
  const streams = [...own.flat().reverse(), ...[...shared].reverse()];
  const { drawn, sentence } = await loaded(seal(fields, streams, 3));
  assert.equal(sentence, "");
  assert.deepEqual(drawn, COARSER[3]);
});

test("a file that ends after a level is read as a coarser scene", () => {
  ENDS.forEach((end, i) => {
    const reader = new SceneReader();
    reader.append(BYTES.subarray(0, end));
    while (reader.step());
    const stages = reader.decoder.levels.map(({ stage }) => stage);
    assert.deepEqual(stages, LAYERS.map((_, j) => (j <= i ? COMPLETE : 0)));
    assert.deepEqual(wordsOf(sceneOf(reader)), COARSER[i]);
    if (i < LAYERS.length - 1) assert.throws(() => reader.end(), /ends inside its stream 'positions@\d'/);
    else reader.end();
  });
});

test("a file that ends after a level is shown as a coarser scene, with an error", async () => {
  for (const [i, end] of ENDS.entries()) {
    const { drawn, sentence, done } = await loaded(BYTES.subarray(0, end));
    assert.deepEqual(drawn, COARSER[i]);
    assert.equal(/ends inside its stream 'positions@\d'.* cut short/.test(sentence), i < LAYERS.length - 1);
    assert.equal(done, i === LAYERS.length - 1);
  }
});

test("a file that ends inside a level shows that level only if it has colours", async () => {
  const length = (/** @type {unknown[]} */ [, , data]) => Math.ceil(/** @type {Uint8Array} */ (data).length / 8) * 8;
  for (const i of [0, 2]) {
    const layer = own[i + 1];
    const lobes = layer.findIndex(([name]) => /** @type {string} */ (name).startsWith("lobes"));
    const behind = (/** @type {number} */ count) =>
      ENDS[i] + layer.slice(0, count).reduce((sum, stream) => sum + length(stream), 0);
    for (const end of [behind(lobes - 1), behind(lobes), ENDS[i + 1] - 1]) {
      const { drawn, sentence } = await loaded(BYTES.subarray(0, end));
      const reader = new SceneReader();
      reader.append(BYTES.subarray(0, end));
      while (reader.step());
      const whole = wordsOf(sceneOf(reader));
      const shown = LAYERS.slice(0, i + (end === behind(lobes - 1) ? 1 : 2)).reduce((sum, size) => sum + size);
      for (const [part, words] of Object.entries(drawn)) {
        assert.equal(words.length, (shown / LAYERS[0]) * COARSER[0][part].length);
        assert.deepEqual(words, whole[part].slice(0, words.length), part);
      }
      assert.match(sentence, /cut short/);
    }
  }
});

test("a level is shown before the next one arrives", { timeout: 60_000 }, async () => {
  page = new Page();
  const seen = (/** @type {number} */ i) =>
    new Promise((resolve) => {
      page.onChange = () => page.words && isDeepStrictEqual(page.drawn, COARSER[i]) && resolve(null);
    });
  let layer = 0;
  const body = new ReadableStream({
    async pull(controller) {
      const start = layer ? ENDS[layer - 1] : 0;
      controller.enqueue(BYTES.slice(start, ENDS[layer]));
      if (layer < LAYERS.length - 1) await seen(layer++);
      else controller.close();
    },
  });
  globalThis.fetch = async () => ({ ok: true, body, headers: new Headers() });
  await globalThis.self.onmessage({ data: { url: "slow" } });
  assert.equal(page.sentence, "");
  assert.deepEqual(page.drawn, COARSER[3]);
});

test("a level that has not arrived gets no memory", async () => {
  const far = ["positions@1", "morton-class", new Uint8Array(2 ** 26)];
  const behind = own[1].slice(1);
  const claim = { ...fields, count: 2 ** 26, layers: [40, 2 ** 26 - 40] };
  const bytes = seal(claim, [...shared, ...own[0], far, ...behind], 3);
  const rest = behind.reduce((sum, [, , data]) => sum + Math.ceil(data.length / 8) * 8, 0);
  const start = bytes.subarray(0, bytes.length - 2 ** 26 - rest);
  const reader = new SceneReader();
  reader.append(start);
  while (reader.step());
  const [first, second] = reader.decoder.levels;
  assert.equal(first.stage, COMPLETE);
  assert.equal(second.positions, null);
  const { size, dots } = await loaded(start);
  assert.equal(size, undefined);
  assert.equal(dots.means.length, 3 * 40);
});

test("impossible LOD levels are refused in one sentence", () => {
  const count = fields.count;
  const wrong = [
    undefined, null, [], {}, "40", 40, count, [count - 1], [count, 1], [0, count], [-1, count + 1],
    [40.5, count - 40.5], [String(count)], [null, count], [[count]], new Array(9).fill(count / 9),
  ]; // prettier-ignore
  wrong.push([...new Array(8).fill(1), count - 8], [1e300], [2 ** 53, count - 2 ** 53]);
  for (const layers of wrong) {
    const bytes = seal({ ...fields, layers }, [...shared, ...own.flat()], 3);
    const refused = (error) => error instanceof SceneError && /'layers' .* missing or invalid/.test(error.message);
    assert.throws(() => openScene(bytes), refused, JSON.stringify(layers));
  }
});

test("each stream of a level must exist once; others are ignored", () => {
  const streams = [...shared, ...own.flat()];
  const without = (name) => streams.filter(([other]) => other !== name);
  for (const name of ["positions@1", "scale.0", "scale.2@3", "lobes.1@2", "rotation.1@1"]) {
    const refused = (error) => error instanceof SceneError && error.message === `the .mgs file lacks its stream '${name}'`;
    assert.throws(() => openScene(seal(fields, without(name), 3)), refused);
  }
  assert.throws(() => openScene(seal(fields, [...streams, own[1][0]], 3)), /two streams called 'positions@1'/);
  // rows of another layer are too few or too many
  const swapped = streams.map(([name, ...rest]) => [{ "scale.0@1": "scale.0@3", "scale.0@3": "scale.0@1" }[name] ?? name, ...rest]);
  assert.throws(() => openScene(seal(fields, swapped, 3)), SceneError);
  const more = [["positions@4", "new", Uint8Array.of(1)], ["positions@0", "new", Uint8Array.of(2)]];
  assert.deepEqual(wordsOf(openScene(seal(fields, [...streams, ...more], 3))), COARSER[3]);
});

test("version 2 ignores the field layers; versions after 4 are refused", () => {
  const [first] = alone;
  const expected = openScene(seal(first.fields, first.streams));
  for (const layers of [null, [], [1, 2], "x"]) {
    assert.deepEqual(openScene(seal({ ...first.fields, layers }, first.streams)), expected);
  }
  assert.throws(() => openScene(seal(first.fields, first.streams, 3)), /'layers'/);
  for (const major of [1, 5]) {
    assert.throws(() => openScene(seal(fields, [...shared, ...own.flat()], major)), /reads 2\.x to 4\.x/);
  }
});
