import assert from "node:assert/strict";
import { test } from "node:test";
import { planOf } from "../../mobilegs/view/web/viewer/bench.js";
import { readPose, writePose } from "../../mobilegs/view/web/viewer/address.js";
import { Pose } from "../../mobilegs/view/web/viewer/pose.js";
import { Resolution } from "../../mobilegs/view/web/viewer/resolution.js";

const near = (/** @type {number[]} */ a, /** @type {number[]} */ b) =>
  a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-9, `${a} is not ${b}`));

test("a bench takes its seconds and its size from the address", () => {
  const screen = { width: 700, height: 400 };
  assert.deepEqual(planOf("", screen), { seconds: 60, ...screen });
  assert.deepEqual(planOf("5", screen), { seconds: 5, ...screen });
  assert.deepEqual(planOf("1600x1063", screen), { seconds: 60, width: 1600, height: 1063 });
  assert.deepEqual(planOf("5,1600x1063", screen), { seconds: 5, width: 1600, height: 1063 });
  assert.deepEqual(planOf("nonsense", screen), { seconds: 60, ...screen });
});

test("a view matrix is a rotation that brings the target before the eye", () => {
  const pose = new Pose([1, 2, 3], [4, 1, -2], [0, -1, 0]);
  const m = pose.viewmat();
  const rows = [0, 4, 8].map((i) => m.slice(i, i + 3));
  rows.forEach((a, i) =>
    rows.forEach((b, j) => near([a.reduce((sum, x, k) => sum + x * b[k], 0)], [i === j ? 1 : 0])),
  );
  const seen = rows.map((row, i) => row[0] * 4 + row[1] * 1 + row[2] * -2 + m[4 * i + 3]);
  near(seen, [0, 0, Math.sqrt(9 + 1 + 25)]);
  assert.ok(rows[1][1] > 0); // y points down, away from the sky
});

test("an orbit keeps its distance, ends where it began, and never goes over the top", () => {
  const pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  for (let i = 0; i < 100; i++) pose.orbit((2 * Math.PI) / 100, 0);
  near(pose.eye, [0, 0, -3]);
  for (let i = 0; i < 50; i++) pose.orbit(0, 0.3);
  near([Math.hypot(...pose.eye)], [3]);
  assert.ok(pose.eye[1] < -2.9 && pose.viewmat().every(Number.isFinite));
});

test("a pose survives the address", () => {
  const pose = new Pose([0.125, -2, 3], [0, 1, 0], [0, -1, 0]);
  const read = readPose(`#${writePose(pose)}`);
  assert.deepEqual([read?.eye, read?.target], [pose.eye, pose.target]);
  for (const text of ["", "#eye=1,2", "#eye=1,2,x&at=0,0,0&up=0,1,0", "#eye=1,1,1&at=1,1,1&up=0,1,0"]) {
    assert.equal(readPose(text), null);
  }
});

test("cameras that look at one place give it as the target", () => {
  const target = [0.5, -0.25, 2];
  const views = [[4, 0, 0], [0, 1, -3], [-2, -1, 1]].map((eye) => {
    const pose = new Pose(/** @type {any} */ (eye), /** @type {any} */ (target), [0, -1, 0]);
    return { viewmat: Float32Array.from(pose.viewmat()), K: new Float32Array(9), width: 4, height: 3 };
  });
  const pose = Pose.fromViews(views);
  pose.target.forEach((x, i) => assert.ok(Math.abs(x - target[i]) < 0.02));
});

test("a slow device draws less while it moves, and all of it at rest", () => {
  const resolution = new Resolution(null);
  for (let i = 0; i < 60; i++) resolution.note(400);
  assert.deepEqual(resolution.size(100, 50, 1, true), { width: 50, height: 25 });
  assert.deepEqual(resolution.size(100, 50, 3, false), { width: 200, height: 100 });
  for (let i = 0; i < 60; i++) resolution.note(8);
  assert.equal(resolution.scale, 1);
});

test("the sky is above level cameras, however they are spread", () => {
  const sky = /** @type {[number, number, number]} */ ([0.2, -0.9, 0.3]);
  const size = Math.hypot(...sky);
  const spreads = {
    ring: [0, 0.4, 0.9, 1.1, 2.5, 4].map((a) => [3 * Math.cos(a), -1.5 - 0.3 * a, 3 * Math.sin(a)]),
    row: [-1, -0.5, 0, 0.5, 1].map((x) => [x, 0.1 * x * x, -4]),
  };
  for (const [name, eyes] of Object.entries(spreads)) {
    const views = eyes.map((eye) => {
      const pose = new Pose(/** @type {any} */ (eye), [0, 0, 0], sky);
      return { viewmat: Float32Array.from(pose.viewmat()), K: new Float32Array(9), width: 4, height: 3 };
    });
    const { up } = Pose.fromViews(views);
    const cosine = up.reduce((sum, x, k) => sum + (x * sky[k]) / size, 0);
    assert.ok(cosine > (name === "ring" ? 0.999 : 0.95), `${name}: ${cosine}`);
  }
});
