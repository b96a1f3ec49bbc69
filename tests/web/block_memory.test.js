import assert from "node:assert/strict";
import test from "node:test";

import { fromFloat16, toFloat16 } from "../../viewer/src/mgs/float16.js";
import { BLOCK, BlockMemory } from "../../viewer/src/mgs/block_memory.js";
import { kernelsIn } from "../../viewer/src/mgs/wasm.js";
import { packer } from "../../viewer/src/render/pack.js";
import { randomNumbers } from "./pieces.js";

const random = randomNumbers(3);
const some = (length) => Float32Array.from({ length }, () => 4 * random() - 2);
const KINDS = [false, true];

test("WebAssembly evaluates layers as JavaScript does", () => {
  assert.notEqual(kernelsIn(new WebAssembly.Memory({ initial: 1 })), null);
  for (const [inputs, rows, slope, offset] of [
    [96, 64, 0, false],
    [64, 13, 1, false],
    [16, 64, 0.01, true],
    [1, 1, 0, true],
    [256, 256, 0, true],
    [0, 5, 1, true],
  ]) {
    const matrix = some(inputs * rows);
    const offsets = offset || inputs === 0 ? some(rows) : new Float32Array(rows);
    const values = some(inputs * BLOCK);
    const [fast, plain] = KINDS.map((plain) => {
      const memory = new BlockMemory(plain);
      const layer = memory.layer(matrix, inputs, offset || inputs === 0 ? offsets : undefined);
      const [x, y] = [inputs, layer.outputs].map((width) => memory.block(width));
      memory.allocate();
      x.numbers.set(values);
      memory.apply(layer, x, y, slope);
      assert.equal(y.numbers.length, Math.ceil(rows / 4) * 4 * BLOCK);
      return y.numbers;
    });
    for (let row = 0; row < BLOCK; row++) {
      for (let o = 0; o < rows; o++) {
        let sum = offsets[o];
        for (let i = 0; i < inputs; i++) sum += matrix[o * inputs + i] * values[i * BLOCK + row];
        const expected = sum > 0 ? sum : slope * sum;
        const at = o * BLOCK + row;
        assert.ok(Math.abs(plain[at] - expected) <= 1e-6 * (1 + Math.abs(expected)));
        assert.ok(Math.abs(fast[at] - expected) <= 1e-5 * (1 + inputs / 16), `${fast[at]} ${expected}`);
      }
      for (let o = rows; o * BLOCK < fast.length; o++) assert.equal(fast[o * BLOCK + row], 0);
    }
  }
});

test("vectors get the length 1, and zeros stay zeros", () => {
  for (const width of [1, 3, 4, 12]) {
    const values = some(width * BLOCK);
    for (let k = 0; k < width; k++) {
      values[k * BLOCK + 5] = 0;
      values[k * BLOCK + 7] *= 1e10;
      values[k * BLOCK + 9] *= 1e-10;
    }
    for (const plain of KINDS) {
      const memory = new BlockMemory(plain);
      const [x, y] = [memory.block(width), memory.block(width)];
      const behind = memory.block(1);
      memory.allocate();
      x.numbers.set(values);
      memory.units(x, y);
      for (let row = 0; row < BLOCK; row++) {
        const own = Array.from({ length: width }, (_, k) => values[k * BLOCK + row]);
        const length = Math.hypot(...own) || 1;
        own.forEach((value, k) => assert.ok(Math.abs(y.numbers[k * BLOCK + row] - value / length) < 2e-7));
      }
      assert.ok(behind.numbers.every((value) => value === 0));
      // in its own place, too
      memory.units(x, x);
      assert.deepEqual(x.numbers, y.numbers);
    }
  }
});

test("the parts of a block are its columns", () => {
  const memory = new BlockMemory();
  const block = memory.block(5);
  const part = memory.part(block, 2, 2);
  memory.allocate();
  part.numbers.fill(7);
  assert.deepEqual([...block.numbers], Array.from({ length: 5 * BLOCK }, (_, i) => (Math.floor(i / BLOCK) % 4 >= 2 ? 7 : 0)));
});

/** A block of Gaussians as GaussianDecoder gives them. */
function someBlock(lobeDegree, change) {
  const memory = new BlockMemory();
  const widths = { scales: 3, quats: 4, sh: 12, lobes: 2 * (lobeDegree + 1) ** 2 + 2, words: 18 };
  const blocks = Object.entries(widths).map(([name, width]) => [name, memory.block(width)]);
  memory.allocate();
  const parts = Object.fromEntries(blocks.map(([name, { numbers }]) => [name, numbers]));
  for (const name of ["sh", "lobes"]) parts[name].set(some(parts[name].length));
  parts.scales.set(some(parts.scales.length).map(Math.exp));
  parts.lobes.fill(0, -2 * BLOCK);
  for (let i = 0; i < BLOCK; i++) {
    const quat = some(4);
    for (let k = 0; k < 4; k++) parts.quats[k * BLOCK + i] = quat[k] / Math.hypot(...quat);
  }
  change(parts);
  const positions = Uint16Array.from({ length: 3 * BLOCK }, () => 65536 * random());
  return { ...parts, count: BLOCK, positions, lobeDegree, statics: new Float32Array(0), scaleRange: [Math.exp(-2), Math.exp(2)], memory: memory.wasmMemory };
}

const CHANGES = {
  "ordinary numbers": () => {},
  "numbers of all sizes": ({ sh, lobes }) => {
    for (const part of [sh, lobes]) part.forEach((value, i) => (part[i] = value * 2 ** (i % 60 - 40)));
  },
  "numbers beyond what words can say": ({ sh, lobes, scales }) => {
    for (const part of [sh, lobes]) part.forEach((value, i) => (part[i] = value * 10 ** (i % 9)));
    scales.forEach((value, i) => (scales[i] = value ** (1 + (i % 3))));
  },
  "zeros, and numbers that are alike": ({ sh, lobes, quats, scales }) => {
    sh.fill(0);
    lobes.fill(-0.5, 0, 2 * BLOCK);
    scales.fill(Math.exp(-2));
    quats.fill(0);
    quats.fill(-0.5, 2, 5);
    for (let k = 1; k < 4; k++) quats.fill(0.5 * (k % 2 ? 1 : -1), k * BLOCK + 2, k * BLOCK + 5);
    quats[9] = -1;
    quats[3 * BLOCK + 11] = 1;
  },
  "powers of two, and halves between two others": ({ sh, lobes }) => {
    for (const part of [sh, lobes]) {
      part.forEach((_, i) => (part[i] = (i % 2 ? -1 : 1) * 2 ** ((i % 40) - 28) * (1 + ((i >> 6) % 4) * 2 ** -11)));
    }
  },
};

for (const [name, change] of Object.entries(CHANGES)) {
  test(`WebAssembly packs as JavaScript does: ${name}`, () => {
    for (const lobeDegree of [0, 1, 2, 3]) {
      const block = someBlock(lobeDegree, (parts) => {
        change(parts);
        parts.lobes.fill(0, -2 * BLOCK);
      });
      const [fast, plain] = KINDS.map((plain) => {
        block.words.fill(0);
        return packer(block, plain)().slice();
      });
      assert.ok(fast.some((word) => word !== 0));
      assert.deepEqual(fast, plain, `degree ${lobeDegree}`);
    }
  });
}

test("words hold the numbers of their Gaussian", () => {
  const block = someBlock(2, ({ quats }) => {
    for (let k = 0; k < 4; k++) quats[k * BLOCK + 3] = 0;
  });
  const words = packer(block)();
  const signed = (byte) => (byte << 24) >> 24;
  for (let i = 0; i < BLOCK; i++) {
    const [xy, z, sizes, turn] = words.subarray(4 * i, 4 * i + 4);
    assert.deepEqual([xy & 0xffff, xy >>> 16, z & 0xffff], [...block.positions.subarray(3 * i, 3 * i + 3)]);
    [2047, 2047, 1023].forEach((steps, axis) => {
      const share = ((sizes >>> (11 * axis)) & steps) / steps;
      const [least, largest] = new Uint32Array(Float32Array.of(...block.scaleRange).buffer);
      const [found] = new Float32Array(Uint32Array.of(least + share * (largest - least)).buffer);
      const expected = block.scales[axis * BLOCK + i];
      // six octaves
      assert.ok(Math.abs(found / expected - 1) <= 3.1 / steps, `${found} ${expected}`);
    });
    const thirds = [20, 10, 0].map((shift) => ((((turn >>> shift) & 1023) << 22) >> 22) / 511 / Math.SQRT2);
    thirds.splice(turn >>> 30, 0, Math.sqrt(Math.max(0, 1 - thirds.reduce((sum, part) => sum + part * part, 0))));
    const dot = thirds.reduce((sum, part, k) => sum + part * block.quats[k * BLOCK + i], 0);
    assert.ok(i === 3 || Math.abs(dot) > 0.99999, `rotation ${i}: ${dot}`);
    const [rg, b, ...four] = words.subarray(4 * (BLOCK + i), 4 * (BLOCK + i) + 4);
    const close = (found, part, column, tolerance) =>
      assert.ok(Math.abs(found - block[part][column * BLOCK + i]) <= tolerance, `${part} ${column} of ${i}`);
    [rg & 0xffff, rg >>> 16, b & 0xffff].forEach((half, column) => close(fromFloat16(half), "sh", column, 1e-3));
    const scaleOf = (byte) => (1 + (byte & 7) / 8) * 2 ** (((byte & 255) >> 3) - 16);
    const bytes = [b >>> 24, ...four.flatMap((word) => [0, 8, 16, 24].map((shift) => word >>> shift))];
    bytes.forEach((byte, k) => close((signed(byte) / 127) * scaleOf(b >>> 16), "sh", 3 + k, 0.51 * scaleOf(b >>> 16) / 127));
    const lobes = words.subarray(8 * BLOCK + 5 * i, 8 * BLOCK + 5 * i + 5);
    const logit = fromFloat16(lobes[0] & 0xffff);
    if (i === 3) assert.ok(logit < -9000);
    else close(logit, "lobes", 0, 1e-3);
    close(fromFloat16(lobes[0] >>> 16), "lobes", 1, 1e-3);
    for (let k = 0; k < 16; k++) {
      const scale = scaleOf(k % 2 ? z >>> 24 : z >>> 16);
      close((signed(lobes[1 + (k >> 2)] >>> (8 * (k % 4))) / 127) * scale, "lobes", 2 + k, (0.51 * scale) / 127);
    }
  }
});

test("every float16 is its own nearest float16, and ties round to even", () => {
  for (let bits = 0; bits < 65536; bits++) {
    if ((bits & 0x7c00) !== 0x7c00) assert.equal(toFloat16(fromFloat16(bits)) & 0x7fff, bits & 0x7fff);
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
    assert.equal(fromFloat16(toFloat16(value)), expected);
  }
});
