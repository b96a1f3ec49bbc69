import assert from "node:assert/strict";
import { test } from "node:test";
import { nearOf } from "../../viewer/src/load/near.js";

const grid = (/** @type {number} */ size, count = 27) =>
  Float32Array.from({ length: 3 * count }, (_, i) => size * ((Math.floor(i / 3 / 3 ** (i % 3)) % 3) - 1));

test("the near plane of a scene of a size of 1 or more is that of 3DGS", () => {
  assert.equal(nearOf(grid(1)), 0.2);
  assert.equal(nearOf(grid(50)), 0.2);
});

test("it follows the size of a smaller scene, wherever that lies", () => {
  const small = grid(0.05);
  assert.ok(Math.abs(nearOf(small) - 0.01) < 1e-6);
  assert.ok(Math.abs(nearOf(small.map((x) => x + 8)) - 0.01) < 1e-6);
});

test("a few Gaussians far away do not count, and a single one has a plane", () => {
  const scene = grid(0.05);
  scene.set([900, 900, 900]);
  assert.ok(Math.abs(nearOf(scene) - 0.01) < 1e-6);
  assert.ok(nearOf(new Float32Array(3)) > 0);
});
