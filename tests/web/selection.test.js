/** The editor's selections: regions, lassos, and what can be undone. */

import assert from "node:assert/strict";
import test from "node:test";

import { History, below, inBox, inLasso, inSphere, inverted, seenByFewer } from "../../viewer/src/edit/selection.js";

const MEANS = Float32Array.from([0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3]);
/** @type {import("../../viewer/src/render/types.js").Camera} */
const CAMERA = {
  viewmat: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 4, 0, 0, 0, 1],
  fx: 100, fy: 100, cx: 50, cy: 50, width: 100, height: 100, near: 0.2,
}; // prettier-ignore

test("regions select what they contain", () => {
  const half = Math.SQRT1_2;
  /** @type {import("../../viewer/src/edit/selection.js").Box} */
  const box = { center: [0, 0, 0], half: [1, 1, 1], axes: [[half, half, 0], [-half, half, 0], [0, 0, 1]] }; // prettier-ignore
  assert.deepEqual([...inBox(MEANS, box)], [1, 1, 0, 0]);
  assert.deepEqual([...inSphere(MEANS, [0, 0, 2], 2)], [1, 0, 0, 1]);
  assert.deepEqual([...below(MEANS, [0, 1, 0], 1)], [1, 1, 0, 1]);
  assert.deepEqual([...inverted(below(MEANS, [0, 1, 0], 1))], [0, 0, 1, 0]);
  assert.deepEqual([...seenByFewer(Uint16Array.from([0, 1, 2, 3]), 2)], [1, 1, 0, 0]);
});

test("a lasso selects at any depth before the camera", () => {
  /** @type {[number, number][]} */
  const square = [[40, 40], [60, 40], [60, 60], [40, 60]]; // prettier-ignore
  assert.deepEqual([...inLasso(MEANS, CAMERA, square)], [1, 0, 0, 1]);
  assert.deepEqual([...inLasso(Float32Array.from([0, 0, -9]), CAMERA, square)], [0]);
});

test("steps are undone and done again", () => {
  const history = new History(12);
  const mask = (/** @type {number[]} */ ...rows) => Uint8Array.from({ length: 12 }, (_, i) => Number(rows.includes(i)));
  assert.equal(history.remove(mask(0, 9)), 2);
  assert.equal(history.remove(mask(9, 11)), 1);
  assert.equal(history.remove(mask(9)), 0);
  assert.equal(history.bits, btoa(String.fromCharCode(1, 2 + 8)));
  assert.deepEqual([...history.with(mask(1))], [...mask(0, 1, 9, 11)]);
  history.undo();
  assert.deepEqual([history.removed, history.canUndo, history.canRedo], [2, true, true]);
  history.undo();
  history.undo();
  assert.deepEqual([history.removed, history.canUndo], [0, false]);
  history.redo();
  assert.deepEqual([...history.hidden], [...mask(0, 9)]);
  history.remove(mask(3));
  assert.equal(history.canRedo, false);
});
