import assert from "node:assert/strict";
import test from "node:test";

import { BLOCK, Network, defined, makeLayer } from "../../mobilegs/view/web/mgs/dense.js";
import { fromHalf, toHalf } from "../../mobilegs/view/web/mgs/half.js";
import { simdIn } from "../../mobilegs/view/web/mgs/simd.js";
import { randomNumbers } from "./pieces.js";

const random = randomNumbers(3);
const some = (length) => Float32Array.from({ length }, () => 4 * random() - 2);

test("SIMD does what a layer is defined to do", () => {
  assert.notEqual(simdIn(BLOCK, new WebAssembly.Memory({ initial: 1 })), null);
  for (const [inputs, rows, slope, offset] of [
    [96, 64, 0, false],
    [64, 13, 1, false],
    [16, 64, 0.01, true],
    [1, 1, 0, true],
    [256, 256, 0, true],
    [0, 5, 1, true],
  ]) {
    const layer = makeLayer(some(inputs * rows), inputs, offset || inputs === 0 ? some(rows) : undefined);
    const values = some(inputs * BLOCK);
    const [fast, plain] = [false, true].map((plain) => {
      const network = new Network([layer], [inputs, layer.outputs], plain);
      network.blocks[0].set(values);
      network.apply(network.layers[0], network.blocks[0], network.blocks[1], slope);
      return network.blocks[1];
    });
    for (let row = 0; row < BLOCK; row++) {
      for (let o = 0; o < rows; o++) {
        let sum = layer.offsets[o];
        const weights = (i) => layer.weights[(o - (o % 4)) * inputs + 4 * i + (o % 4)];
        for (let i = 0; i < inputs; i++) sum += weights(i) * values[i * BLOCK + row];
        const expected = sum > 0 ? sum : slope * sum;
        const at = o * BLOCK + row;
        assert.ok(Math.abs(plain[at] - expected) <= 1e-6 * (1 + Math.abs(expected)));
        assert.ok(Math.abs(fast[at] - expected) <= 1e-5 * (1 + inputs / 16), `${fast[at]} ${expected}`);
      }
      for (let o = rows; o < layer.outputs; o++) assert.equal(fast[o * BLOCK + row], 0);
    }
  }
});

test("a network with one input more reads what lies behind the others", () => {
  const [first, second] = [makeLayer(some(8), 2), makeLayer(some(20), 5)];
  const network = new Network([first, second], [2, 5, 4]);
  const [values, hidden, result] = network.blocks;
  values.set(some(values.length));
  network.apply(network.layers[0], values, hidden, 0);
  hidden.set(some(BLOCK), 4 * BLOCK);
  network.apply(network.layers[1], hidden, result, 1);
  const expected = new Float32Array(result.length);
  defined(second, hidden, expected, 1);
  for (let i = 0; i < result.length; i++) assert.ok(Math.abs(result[i] - expected[i]) < 1e-5);
});

test("every half is its own nearest half, and others round to even", () => {
  for (let bits = 0; bits < 65536; bits++) {
    if ((bits & 0x7c00) !== 0x7c00) assert.equal(toHalf(fromHalf(bits)) & 0x7fff, bits & 0x7fff);
  }
  for (const [value, expected] of [
    [1 + 2 ** -11, 1],
    [1 + 3 * 2 ** -11, 1 + 2 ** -9],
    [-(1 + 2 ** -11) - 1e-6, -(1 + 2 ** -10)],
    [2 ** -25, 0],
    [3 * 2 ** -25, 2 ** -23],
    [2 ** -14 - 2 ** -26, 2 ** -14],
    [65519, 65504],
    [1e30, 65504],
    [-1e9, -65504],
  ]) {
    assert.equal(fromHalf(toHalf(value)), expected);
  }
});
