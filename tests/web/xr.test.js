import assert from "node:assert/strict";
import { test } from "node:test";

import { lensOf } from "../../viewer/src/viewer/xr_camera.js";
import { Hands } from "../../viewer/src/viewer/xr_hands.js";
import { FramePace } from "../../viewer/src/viewer/xr_pace.js";
import { placed } from "../../viewer/src/viewer/xr_place.js";

const PERIOD = 1000 / 72;
const PLACE = { axes: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], scale: 2, at: [0, 1, -1] }; // prettier-ignore
const HEAD = { eye: [0, 1.6, 0], forward: [0, 0, -1] };

/** Frames of so many periods, for half a second each time. */
function show(pace, periods, times) {
  for (let i = 0; i < times * 36; i++) pace.note(periods * PERIOD);
}

test("fewer pixels and coarser levels while frames are late, more after calm", () => {
  const pace = new FramePace(72, null);
  assert.deepEqual(pace.step, { scale: 0.7, coarseness: 0.6 });
  show(pace, 1, 20);
  assert.deepEqual(pace.step, { scale: 1, coarseness: 1 });
  show(pace, 2, 1);
  assert.deepEqual(pace.step, { scale: 1, coarseness: 0.6 });
  show(pace, 2, 10);
  assert.deepEqual(pace.step, { scale: 0.4, coarseness: 0.6 });
  // after it had to draw less, it waits longer before it tries more
  show(pace, 1, 10);
  assert.deepEqual(pace.step, { scale: 0.4, coarseness: 0.6 });
});

test("a frame that is late now and then changes nothing", () => {
  const pace = new FramePace(72, null);
  for (let i = 0; i < 720; i++) pace.note(PERIOD * (i % 12 ? 1 : 2));
  assert.deepEqual(pace.step, { scale: 0.7, coarseness: 0.6 });
});

test("the rate of the headset decides", () => {
  const pace = new FramePace(120, null);
  show(pace, 1, 2); // 72 frames per second
  assert.equal(pace.step.scale < 0.7, true);
  const fixed = new FramePace(120, 0.5);
  show(fixed, 4, 4);
  assert.deepEqual(fixed.step, { scale: 0.5, coarseness: 1 });
});

test("a projection's lens", () => {
  const near = 0.1;
  const [left, right, down, up] = [-0.12, 0.08, -0.1, 0.09]; // of the near plane
  const matrix = new Array(16).fill(0);
  matrix[0] = (2 * near) / (right - left);
  matrix[5] = (2 * near) / (up - down);
  matrix[8] = (right + left) / (right - left);
  matrix[9] = (up + down) / (up - down);
  const { fx, fy, cx, cy } = lensOf(matrix, 200, 190);
  const pixels = [cx + (fx * left) / near, cx + (fx * right) / near, cy - (fy * up) / near, cy - (fy * down) / near];
  for (const [i, edge] of [0, 200, 0, 190].entries()) assert.ok(Math.abs(pixels[i] - edge) < 1e-9);
});

/** A session whose events the test sends, and fingers on a screen that looks along -z from (0, 1.6, 0). */
function phone() {
  const session = new EventTarget();
  const send = (name, more) => session.dispatchEvent(Object.assign(new Event(name), more));
  const finger = () => ({ targetRayMode: "screen", gripSpace: null, targetRaySpace: {} });
  const press = (source) => send("selectstart", { inputSource: source });
  const at = (source, x, y) => {
    const size = Math.hypot(x, y, 1);
    const position = { x: 0, y: 1.6, z: 0 };
    source.targetRaySpace.transform = { position, matrix: [0, 0, 0, 0, 0, 0, 0, 0, -x / size, -y / size, 1 / size] };
  };
  const frame = { getPose: (space) => space };
  return { session, send, finger, press, at, frame };
}

test("fingers move, turn and enlarge a miniature", () => {
  const { session, send, finger, press, at, frame } = phone();
  const hands = new Hands(session);
  const [one, other] = [finger(), finger()];
  const pull = (place) => hands.pull(frame, null, place, [0, 1.6, -1], HEAD);
  press(one);
  at(one, 0, 0);
  assert.deepEqual(pull(PLACE), PLACE);
  at(one, 0.1, 0);
  const moved = pull(PLACE);
  assert.ok(Math.abs(moved.at[0] - 0.1) < 0.01 && Math.abs(moved.at[1] - 1) < 1e-9);

  press(other);
  at(one, -0.1, 0);
  at(other, 0.1, 0);
  pull(PLACE);
  // a quarter turn counterclockwise on the screen, and twice as far from each other
  at(one, 0, -0.2);
  at(other, 0, 0.2);
  const turned = pull(PLACE);
  assert.ok(Math.abs(turned.scale - 4) < 0.1);
  const middle = [0, 0.3, 0]; // at (0, 1.6, -1)
  const beside = [0.5, 0.3, 0]; // right of it
  const [a, b] = [middle, beside].map((point) => placed(turned, point));
  assert.ok(Math.abs(b[2] - a[2] + 2) < 0.1 && Math.abs(b[0] - a[0]) < 1e-6);

  send("inputsourceschange", { removed: [one, other] });
  assert.equal(hands.holding, false);
});

test("an eye's ray holds nothing", () => {
  const { session, send } = phone();
  const hands = new Hands(session);
  send("selectstart", { inputSource: { targetRayMode: "gaze" } });
  assert.equal(hands.holding, false);
});
