/** Compressed texts of the npm package. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { gzipSync } from "node:zlib";

import { fromDigits, toDigits, unpacked } from "../../viewer/src/package/unpacked.js";
import { randomNumbers } from "./pieces.js";

test("bytes of every length come back from their digits", () => {
  const random = randomNumbers(1);
  for (let length = 0; length < 40; length++) {
    const bytes = Uint8Array.from({ length }, (_, i) => (i % 7 ? 256 * random() : 255));
    const text = toDigits(bytes);
    assert.deepEqual(fromDigits(text), bytes);
    assert.equal(text.length, 1 + 5 * Math.ceil(length / 4));
    assert.equal(JSON.stringify(text).length, text.length + 2); // nothing is escaped
  }
});

test("a text comes back", async () => {
  const text = "Gaussians, 高斯".repeat(100);
  assert.equal(await unpacked(toDigits(gzipSync(text))), text);
});
