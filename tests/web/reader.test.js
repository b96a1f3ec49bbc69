import assert from "node:assert/strict";
import test from "node:test";

import { SceneError } from "../../viewer/src/mgs/error.js";
import { SceneReader, readScene } from "../../viewer/src/mgs/reader.js";
import { GaussianDecoder } from "../../viewer/src/mgs/gaussian_decoder.js";
import { numbersOf, openScene, sceneOf } from "./whole.js";
import { joined, seal, smallScene } from "./write.js";

const PARTS = ["means", "logScales", "quats", "sh", "lobes"];

/** The header's bytes, then each stream with its padding. */
function arrivals(bytes, streams) {
  const lengths = streams.map(([, , data]) => Math.ceil(data.length / 8) * 8);
  let start = bytes.length - lengths.reduce((sum, length) => sum + length, 0);
  const pieces = [bytes.slice(0, start)];
  for (const length of lengths) pieces.push(bytes.slice(start, (start += length)));
  return pieces;
}

function assertDrawable(scene) {
  for (const part of PARTS) assert.ok(scene[part].every(Number.isFinite), part);
  for (let i = 0; i < scene.count; i++) {
    const length = Math.hypot(...scene.quats.subarray(4 * i, 4 * i + 4));
    assert.ok(Math.abs(length - 1) < 1e-6);
  }
}

test("any prefix with scales and rotations can be rendered", () => {
  const { fields, streams } = smallScene();
  const bytes = seal(fields, streams);
  const { scene: whole } = openScene(bytes);
  const reader = new SceneReader();
  const has = { means: "positions", logScales: "scale.2", quats: "rotation.1", sh: "appearance.2", lobes: "lobes.1" };
  const stages = { "": 0, "rotation.1": 1, "opacity.0": 2, "lobes.1": 3 };
  const arrived = [];
  arrivals(bytes, streams).forEach((piece, i) => {
    reader.append(piece);
    assert.equal(reader.header.count, 40);
    assert.equal(reader.total, bytes.length);
    while (reader.step());
    arrived.push(i === 0 ? "" : streams[i - 1][0]);
    assert.equal(reader.decoder.levels[0].positions !== null, arrived.includes("positions"));
    assert.equal(reader.decoder.levels[0].stage, Math.max(...arrived.map((name) => stages[name] ?? 0)));
    if (reader.decoder.levels[0].positions === null) return;
    const { color, side } = new GaussianDecoder(reader.decoder.decoderInputs).neutral;
    assert.ok([...color, side].every(Number.isFinite));
    if (reader.decoder.levels[0].stage < 1) return;
    const { scene } = sceneOf(reader);
    assertDrawable(scene);
    for (const part of PARTS) {
      const same = scene[part].every((value, j) => value === whole[part][j]);
      assert.equal(arrived.includes(has[part]), same, `${part} after ${arrived.at(-1)}`);
    }
  });
  reader.end();
});

test("results do not depend on which rows are decoded together", () => {
  const { fields, streams } = smallScene(300);
  const reader = new SceneReader();
  reader.append(seal(fields, streams));
  while (reader.step());
  const { scene: whole } = sceneOf(reader);
  const decoder = new GaussianDecoder(structuredClone(reader.decoder.decoderInputs));
  for (const [from, to] of [[0, 1], [256, 300], [64, 224], [0, 32]]) {
    const rows = numbersOf(decoder, structuredClone(reader.decoder.levels[0].rows(from, to)));
    assert.equal(rows.count, to - from);
    for (const part of PARTS.slice(1)) {
      const width = whole[part].length / 300;
      assert.deepEqual(rows[part], whole[part].slice(width * from, width * to), part);
    }
  }
});

test("streams in another order give the same scene", () => {
  const { fields, streams } = smallScene();
  const reversed = openScene(seal(fields, [...streams].reverse()));
  assert.deepEqual(reversed, openScene(seal(fields, streams)));
});

test("a false count gets no memory", () => {
  const { fields, streams: found } = smallScene(5000);
  const streams = found.filter(([name]) => name !== "positions");
  streams.push(["positions", "morton-class", new Uint8Array(2 ** 26)]);
  const bytes = seal({ ...fields, count: 2 ** 26 }, streams);
  const reader = new SceneReader();
  reader.append(bytes.subarray(0, bytes.length - 2 ** 26));
  while (reader.step());
  assert.equal(reader.decoder.levels[0].positions, null);
  assert.ok(reader.received < 100_000 && reader.total > 2 ** 26);
});

test("a response is read while it arrives", async () => {
  const { fields, streams } = smallScene();
  const bytes = seal(fields, streams);
  let received = 0;
  let steps = 0;
  const reader = await readScene(new Blob([bytes]).stream(), async (reader) => {
    await null;
    received = reader.received;
    steps++;
  });
  assert.deepEqual(sceneOf(reader), openScene(bytes));
  assert.equal(received, bytes.length);
  assert.ok(steps > streams.length);
});

test("reading stops at the first error and cancels the source", async () => {
  const { fields, streams } = smallScene();
  const bytes = seal(fields, streams);
  bytes[1000] ^= 1;
  let cancelled = false;
  const source = new ReadableStream({
    pull: (controller) => controller.enqueue(bytes.slice()),
    cancel: () => void (cancelled = true),
  });
  await assert.rejects(readScene(source, () => {}), SceneError);
  assert.ok(cancelled);
  const short = new Blob([bytes.subarray(0, 700)]).stream();
  await assert.rejects(readScene(short, () => {}), /cut short/);
});

test("a zero quaternion stays zero", () => {
  const { fields, streams } = smallScene();
  const books = streams[2][2];
  books.fill(0, 2 * 8 * 3, 2 * 8 * 7);
  const { scene } = openScene(seal(fields, streams));
  assert.ok(scene.quats.every((value) => value === 0));
  assert.ok(scene.lobes.every(Number.isFinite));
});

test("impossible codecs, weights and scales are refused in one sentence", () => {
  /** @type {[string, (streams: [string, string, Uint8Array][]) => void, RegExp][]} */
  const damages = [
    ["codec", (s) => (s[4][1] = "zip"), /'scale.0' of the .mgs file uses the codec 'zip'/],
    ["stream", (s) => s.splice(5, 1), /lacks its stream 'scale.1'/],
    ["twice", (s) => s.push(s[4]), /two streams called 'scale.0'/],
    ["weight", (s) => s[1][2].set([0, 0x7c], 6), /'appearance-decoder' .* not finite/],
    ["scale", (s) => s[2][2].set([0xff, 0x7b], 0), /scales that are out of range/],
    ["length", (s) => (s[2][2] = s[2][2].slice(1)), /'codebooks' .* has a wrong length/],
    ["positions", (s) => (s[3][2] = joined([[255, 255, 0, 0], s[3][2].slice(4)])), /too short/],
  ];
  for (const [name, damage, sentence] of damages) {
    const { fields, streams } = smallScene();
    damage(streams);
    const refused = (error) => error instanceof SceneError && sentence.test(error.message);
    assert.throws(() => openScene(seal(fields, streams)), refused, name);
  }
});
