import assert from "node:assert/strict";
import test from "node:test";

import { SceneError } from "../../mobilegs/view/web/mgs/error.js";
import { SceneReader, openScene, readScene } from "../../mobilegs/view/web/mgs/reader.js";
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

test("whatever prefix of a file is there can be drawn once there are positions", () => {
  const { fields, streams } = smallScene();
  const bytes = seal(fields, streams);
  const { scene: whole } = openScene(bytes);
  const reader = new SceneReader();
  let first = null;
  arrivals(bytes, streams).forEach((piece, i) => {
    reader.append(piece);
    assert.equal(reader.header.count, 40);
    assert.equal(reader.total, bytes.length);
    while (reader.step());
    const name = i === 0 ? "" : streams[i - 1][0];
    if (name === "positions") first = reader.scene;
    assert.equal(reader.scene, first, `after ${name}`);
    if (reader.scene === null) return;
    assertDrawable(reader.scene);
    for (const part of PARTS) {
      const same = reader.scene[part].every((value, j) => value === whole[part][j]);
      assert.equal(reader.has(part), same, `${part} after ${name}`);
    }
  });
  reader.end();
  assert.ok(reader.complete && PARTS.every((part) => reader.has(part)));
});

test("streams in another order give the same scene", () => {
  const { fields, streams } = smallScene();
  const reversed = openScene(seal(fields, [...streams].reverse()));
  assert.deepEqual(reversed, openScene(seal(fields, streams)));
});

test("every number of a scene is computed once, and in steps", () => {
  const { fields, streams } = smallScene(5000);
  const reader = new SceneReader();
  reader.append(seal(fields, streams));
  const computed = { sh: 0, lobes: 0 };
  let steps = 0;
  for (let update; (update = reader.step()); steps++) {
    if (update.changed.length !== 1 || !(update.changed[0] in computed)) continue;
    computed[update.changed[0]] += update.to - update.from;
  }
  // lobes: first the base opacity, then all
  assert.deepEqual(computed, { sh: 5000, lobes: 10000 });
  assert.ok(steps > streams.length + 6);
});

test("what has not arrived gets no memory for its Gaussians, whatever the header says", () => {
  const { fields, streams } = smallScene(5000);
  streams.push(["new", "new", new Uint8Array(2 ** 26)]);
  const bytes = seal({ ...fields, count: 2 ** 26 }, streams);
  const reader = new SceneReader();
  reader.append(bytes.subarray(0, bytes.length - 2 ** 26));
  while (reader.step());
  assert.equal(reader.scene, null);
  assert.ok(reader.received < 100_000 && reader.total > 2 ** 26);
});

test("a response is read while it arrives", async () => {
  const { fields, streams } = smallScene();
  const bytes = seal(fields, streams);
  const updates = [];
  const onUpdate = async (reader, update) => {
    await null;
    updates.push([reader.received, ...update.changed]);
  };
  const found = await readScene(new Blob([bytes]).stream(), onUpdate);
  assert.deepEqual(found, openScene(bytes));
  assert.deepEqual(updates.at(-1), [bytes.length, "lobes"]);
});

test("reading stops at the first contradiction, and the source is told", async () => {
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

test("a quaternion without length stays one", () => {
  const { fields, streams } = smallScene();
  const books = streams[2][2];
  books.fill(0, 2 * 8 * 3, 2 * 8 * 7);
  const { scene } = openScene(seal(fields, streams));
  assert.ok(scene.quats.every((value) => value === 0));
  assert.ok(scene.lobes.every(Number.isFinite));
});

test("codecs, weights and scales that cannot be are refused in one sentence", () => {
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
