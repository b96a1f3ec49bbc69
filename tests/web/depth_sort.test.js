import assert from "node:assert/strict";
import { test } from "node:test";
import { backToFront } from "../../viewer/src/load/depth_sort.js";

/** Depths along z to centres. @param {number[]} depths */
const along = (depths) => Float32Array.from(depths.flatMap((depth) => [9, -9, depth]));

test("the farthest comes first, also behind the camera and at extreme depths", () => {
  const depths = [1, 2, -1.5, 0, 1.5, 2e5, -3e6, 1e-30, -1e-30, 1.25];
  const order = backToFront(along(depths), [0, 0, 1]);
  const sorted = [...depths.keys()].sort((a, b) => depths[b] - depths[a]);
  assert.deepEqual([...order], sorted);
});

test("random depths are sorted", () => {
  const depths = Array.from({ length: 5000 }, (_, i) => Math.fround(Math.sin(i * i) * 1000));
  const order = backToFront(along(depths), [0, 0, 1]);
  assert.equal(new Set(order).size, depths.length);
  for (let i = 1; i < order.length; i++) assert.ok(depths[order[i]] <= depths[order[i - 1]]);
});

test("an empty scene has an empty order", () => {
  assert.equal(backToFront(new Float32Array(0), [0, 0, 1]).length, 0);
});
