import assert from "node:assert/strict";
import { test } from "node:test";
import { LoadProgress, namesOf } from "../../viewer/src/viewer/load_progress.js";
import { parsePlan } from "../../viewer/src/viewer/bench.js";
import { poseFromHash, poseToHash } from "../../viewer/src/viewer/pose_hash.js";
import { colorOf, hexOf } from "../../viewer/src/viewer/color.js";
import { pointUnder } from "../../viewer/src/viewer/pick.js";
import { Pose, cameraOf } from "../../viewer/src/viewer/pose.js";
import { Resolution } from "../../viewer/src/viewer/resolution.js";

const near = (/** @type {number[]} */ a, /** @type {number[]} */ b) =>
  a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-9, `${a} is not ${b}`));

test("the benchmark's duration and size come from the URL", () => {
  const screen = { width: 700, height: 400 };
  assert.deepEqual(parsePlan("", screen), { seconds: 60, ...screen });
  assert.deepEqual(parsePlan("5", screen), { seconds: 5, ...screen });
  assert.deepEqual(parsePlan("1600x1063", screen), { seconds: 60, width: 1600, height: 1063 });
  assert.deepEqual(parsePlan("5,1600x1063", screen), { seconds: 5, width: 1600, height: 1063 });
  assert.deepEqual(parsePlan("nonsense", screen), { seconds: 60, ...screen });
});

test("the view matrix puts the target on the z axis", () => {
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

test("an orbit keeps its distance and stops at the poles", () => {
  const pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  for (let i = 0; i < 100; i++) pose.orbit((2 * Math.PI) / 100, 0);
  near(pose.eye, [0, 0, -3]);
  for (let i = 0; i < 50; i++) pose.orbit(0, 0.3);
  near([Math.hypot(...pose.eye)], [3]);
  assert.ok(pose.eye[1] < -2.9 && pose.viewmat().every(Number.isFinite));
});

test("a pose survives the URL", () => {
  const pose = new Pose([0.125, -2, 3], [0, 1, 0], [0, -1, 0]);
  const read = poseFromHash(`#${poseToHash(pose)}`);
  assert.deepEqual([read?.eye, read?.target], [pose.eye, pose.target]);
  for (const [eye, at] of [[[450012.34, 3, -8], [450016.5, 4, -8]], [[1200, 0, 0.02], [1200, 0, 0]], [[0, 9e6, 0], [0, 0, 0]]]) {
    const far = new Pose(/** @type {any} */ (eye), /** @type {any} */ (at), [0, 0, 1]);
    const { eye: x, target: y } = /** @type {Pose} */ (poseFromHash(poseToHash(far)));
    const apart = Math.hypot(...eye.map((one, k) => one - at[k]));
    assert.ok(eye.every((one, k) => Math.abs(one - x[k]) < 1e-4 * apart && Math.abs(at[k] - y[k]) < 1e-4 * apart));
  }
  for (const text of ["", "#eye=1,2", "#eye=1,2,x&at=0,0,0&up=0,1,0", "#eye=1,1,1&at=1,1,1&up=0,1,0"]) {
    assert.equal(poseFromHash(text), null);
  }
});

test("the target is the point that the cameras look at", () => {
  const target = [0.5, -0.25, 2];
  const views = [[4, 0, 0], [0, 1, -3], [-2, -1, 1]].map((eye) => {
    const pose = new Pose(/** @type {any} */ (eye), /** @type {any} */ (target), [0, -1, 0]);
    return { viewmat: Float32Array.from(pose.viewmat()), K: new Float32Array(9), width: 4, height: 3 };
  });
  const pose = Pose.fromViews(views);
  pose.target.forEach((x, i) => assert.ok(Math.abs(x - target[i]) < 0.02));
});

/** Frames of a device that takes `full` milliseconds at full size, and at least `least`. */
function draw(resolution, full, least, frames) {
  const scales = [];
  for (let i = 0; i < frames; i++) {
    resolution.note(Math.max(full * resolution.scale ** 2, least));
    scales.push(resolution.scale);
  }
  return scales;
}

test("a slow device lowers the resolution only during movements", () => {
  const resolution = new Resolution(null);
  assert.deepEqual(draw(resolution, 400, 16, 4), [1, 1, 0.5, 0.5]); // it is seen at once
  assert.deepEqual(resolution.size(100, 50, 1, true), { width: 50, height: 25 });
  assert.deepEqual(resolution.size(100, 50, 3, false), { width: 200, height: 100 });
  draw(resolution, 8, 8, 6000);
  assert.equal(resolution.scale, 1);
});

test("a nearly fast enough device lowers the resolution a little", () => {
  const resolution = new Resolution(null);
  draw(resolution, 34, 16, 60);
  assert.equal(resolution.scale, 0.7); // 17 milliseconds
  draw(resolution, 34, 16, 3000);
  const late = draw(resolution, 34, 16, 3000);
  assert.ok(late.filter((scale) => scale !== 0.7).length < 150, "it tries more pixels now and then, seldom");
});

test("a 30 Hz screen keeps the full resolution", () => {
  const resolution = new Resolution(null);
  draw(resolution, 8, 33.3, 60);
  assert.equal(resolution.scale, 1);
  draw(resolution, 60, 33.3, 60); // now it is the device
  assert.ok(resolution.scale < 0.8);
});

test("one slow frame changes nothing", () => {
  const resolution = new Resolution(null);
  for (let i = 0; i < 200; i++) resolution.note(i % 20 === 7 ? 300 : 16.7);
  assert.equal(resolution.scale, 1);
});

test("a fixed scale stays", () => {
  const resolution = new Resolution(0.8);
  draw(resolution, 400, 400, 50);
  assert.equal(resolution.scale, 0.8);
});

test("the up direction comes from level cameras", () => {
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

test("CSS colours are parsed", () => {
  assert.deepEqual(colorOf("ff8000"), [1, 128 / 255, 0]);
  assert.deepEqual(colorOf(" #F80 "), [1, 136 / 255, 0]);
  for (const text of [null, "#12", "#12345", "#1234567"]) assert.equal(colorOf(text), null);
  assert.equal(hexOf([1, 0.5, 0]), "#ff8000");
  assert.equal(hexOf([-1, 2, 0]), "#00ff00");
});

test("names of two scenes are the shortest different ends of their paths", () => {
  assert.deepEqual(namesOf("http://x/a/scene.mgs", "b.ply"), ["scene.mgs", "b.ply"]);
  assert.deepEqual(namesOf("runs/a/scene.mgs", "runs/b/scene.mgs"), ["a/scene.mgs", "b/scene.mgs"]);
  assert.deepEqual(namesOf("/a.mgs", "/a.mgs"), ["a.mgs", "a.mgs"]);
  assert.deepEqual(namesOf("my%20garden.mgs", "100%.ply"), ["my garden.mgs", "100%.ply"]);
  assert.deepEqual(namesOf("a.mgs", ""), ["a.mgs", ""]);
});

test("two scenes have the worse state and the mean share", () => {
  const progress = new LoadProgress();
  assert.deepEqual([progress.state, progress.busy, progress.sentence], ["", false, ""]);
  progress.begin(0, "a.mgs");
  progress.note(0, { share: 0.5 });
  assert.deepEqual([progress.state, progress.share], ["loading", 0.5]);
  progress.begin(1, "b.ply");
  assert.ok(progress.busy && Number.isNaN(progress.share)); // of the other nothing is known
  progress.fail(1, "it is broken", false);
  assert.deepEqual([progress.state, progress.share, progress.busy], ["failed", 0.75, true]);
  assert.equal(progress.sentence, "b.ply: it is broken");
  progress.note(0, { share: 1, state: "loaded" });
  assert.deepEqual([progress.state, progress.busy], ["failed", false]);
  progress.begin(1);
  assert.deepEqual([progress.state, progress.sentence], ["loaded", ""]);
  progress.fail(0, "alone", false);
  assert.equal(progress.sentence, "alone");
});

test("a failed scene is named in the error and keeps the previous name", () => {
  const progress = new LoadProgress();
  for (const [side, name] of ["a.mgs", "b.ply"].entries()) {
    progress.begin(side, name);
    progress.note(side, { share: 1, state: "loaded" });
  }
  progress.begin(0, "photo.jpg");
  assert.deepEqual(progress.names, ["photo.jpg", "b.ply"]);
  progress.fail(0, "this is no scene", true);
  assert.deepEqual(progress.names, ["a.mgs", "b.ply"]);
  assert.equal(progress.sentence, "photo.jpg: this is no scene");
});

test("the field of view lies between the width's and the height's", () => {
  const pose = new Pose([0, 0, -3], [0, 0, 0], [0, -1, 0]);
  assert.equal(cameraOf(pose, null, 200, 200, 0.1, 90).fx.toFixed(6), "100.000000");
  const view = { viewmat: new Float32Array(16), K: new Float32Array([80, 0, 0, 0, 90]), width: 100, height: 50 };
  near([cameraOf(pose, view, 100, 50, 0.1).fx], [Math.sqrt(80 * 90)]);
  near([cameraOf(pose, view, 400, 100, 0.1, 90).fx], [100]);
});

test("picking finds the nearest mean that is not faint", () => {
  const camera = { viewmat: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], fx: 100, fy: 100, cx: 50, cy: 40 };
  const at = (means, logits) =>
    pointUnder(Float32Array.from(means.flat()), Float32Array.from(logits), { ...camera, near: 0.5 }, 50, 40);
  const row = [[0, 0, 6], [0, 0, 4], [0, 0, 2], [3, 0, 1], [0, 0, 0.2]];
  assert.deepEqual(at(row, [1, 1, -1, 1, 1]), [0, 0, 4]);
  assert.deepEqual(at(row.slice(0, 1), [1, 0, 0, 0, 0]), [0, 0, 6]);
  assert.equal(at(row.slice(3), [1, 1, 1]), null);
  assert.equal(at([], [0, 0]), null);
});
