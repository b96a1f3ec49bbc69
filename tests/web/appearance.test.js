import assert from "node:assert/strict";
import test from "node:test";

import { AppearanceDecoder } from "../../mobilegs/view/web/mgs/appearance.js";
import { toHalf } from "../../mobilegs/view/web/mgs/half.js";
import { APPEARANCE, splitWeights, weightNumbers } from "../../mobilegs/view/web/mgs/weights.js";
import { randomNumbers } from "./pieces.js";

const COUNT = 500;
const MANY = 2 ** 20; // Gaussians that make a table worth its making

test("a table within the radius gives what the first layer is defined to give", () => {
  const random = randomNumbers(7);
  const some = (length, most) => Float32Array.from({ length }, () => most * (2 * random() - 1));
  const weights = splitWeights(some(weightNumbers(APPEARANCE), 0.3), APPEARANCE);
  const codes = {
    length: 2,
    books: [some(8, 1), some(8, 1), some(8, 1)],
    columns: [0, 1, 2].map(() => Uint16Array.from({ length: COUNT }, () => 4 * random())),
  };
  for (const exponent of [0, 11, 14]) {
    // blocks within, beyond and both; at the end 1 itself, and zeros of both signs
    const positions = Uint16Array.from({ length: 3 * COUNT }, (_, i) => {
      const most = i < 3 * 192 ? 0.5 : i < 3 * 320 ? 3 : 0.9;
      return toHalf((most * (2 * random() - 1)) / 2 ** exponent);
    });
    const one = toHalf(2 ** -exponent);
    positions.set([0x8000, 0x8000 | one, 0, one, 0, 0x8000], 3 * (COUNT - 2));
    const [tabled, plain] = [MANY, 1].map((count) => {
      const sh = new Float32Array(12 * COUNT);
      new AppearanceDecoder(weights, exponent, count).decode(positions, codes, sh);
      return sh;
    });
    const most = plain.reduce((a, b) => Math.max(a, Math.abs(b)), 0);
    tabled.forEach((value, i) => assert.ok(Math.abs(value - plain[i]) < 2e-6 * most, `${exponent} ${i}`));
    assert.notDeepEqual(tabled, plain); // they do differ in the last digits
  }
});
