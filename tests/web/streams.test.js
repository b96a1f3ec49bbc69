import assert from "node:assert/strict";
import test from "node:test";

import { BitReader, exactBits } from "../../viewer/src/mgs/bits.js";
import { crc32 } from "../../viewer/src/mgs/crc32.js";
import { SceneError } from "../../viewer/src/mgs/error.js";
import { fromFloat16, isNotFinite } from "../../viewer/src/mgs/float16.js";
import { subsampled } from "../../viewer/src/mgs/positions.js";
import { decodeRans, laneCount } from "../../viewer/src/mgs/rans.js";
import { bits, constantRans, rans } from "./write.js";

/** @param {() => void} call @param {RegExp} sentence */
function refuses(call, sentence) {
  assert.throws(call, (error) => error instanceof SceneError && sentence.test(error.message));
}

test("the checksum equals zip's and can be continued", () => {
  const text = new TextEncoder().encode("123456789");
  assert.equal(crc32(text), 0xcbf43926);
  assert.equal(crc32(text.subarray(4), crc32(text.subarray(0, 4))), 0xcbf43926);
});

test("subsampling keeps every n-th position, and all of few", () => {
  const positions = Uint16Array.from({ length: 3 * 11 }, (_, i) => i);
  assert.equal(subsampled(positions, 11), positions);
  assert.deepEqual([...subsampled(positions, 4)], [0, 1, 2, 9, 10, 11, 18, 19, 20, 27, 28, 29]);
  assert.deepEqual([...subsampled(positions, 10)].length, 18);
  assert.deepEqual([...subsampled(positions, 1)], [0, 1, 2]);
});

test("float16 values are exact, also subnormal ones", () => {
  const known = [
    [0x3c00, 1],
    [0xc000, -2],
    [0x7bff, 65504],
    [0x0001, 2 ** -24],
    [0x83ff, -1023 * 2 ** -24],
    [0x0400, 2 ** -14],
    [0x3555, 1365 / 4096],
    [0x8000, -0],
  ];
  for (const [stored, value] of known) assert.equal(fromFloat16(stored), value);
  assert.ok([0x7c00, 0xfc00, 0x7e00].every(isNotFinite));
  assert.ok(![0x7bff, 0xfbff, 0].some(isNotFinite));
});

test("bits are read lowest first", () => {
  const reader = new BitReader(bits([[5, 3], [0xabcdef, 24], [0, 0], [1, 1], [77, 9]]));
  assert.deepEqual([3, 24, 0, 1, 9].map((width) => reader.take(width)), [5, 0xabcdef, 0, 1, 77]);
  assert.ok(reader.atEnd());
});

test("bits of a wrong length or with trailing ones are refused", () => {
  refuses(() => exactBits(new Uint8Array(2), 17), /take 2 bytes where 3 belong/);
  refuses(() => exactBits(Uint8Array.of(0, 2), 9), /not zero/);
});

test("the lane count grows with the symbols", () => {
  const counts = [0, 1, 4095, 4096, 8191, 8192, 2 ** 19, 2 ** 26];
  assert.deepEqual(counts.map(laneCount), [1, 1, 1, 2, 2, 4, 256, 256]);
});

test("a stream of one symbol takes no words", () => {
  assert.deepEqual([...decodeRans(constantRans(7, 4), 5, 7)], [4, 4, 4, 4, 4]);
});

test("a stream written by hand is decoded", () => {
  // two symbols, 8192 each: symbol 1 takes the upper half of the slots
  const tables = bits([[1, 1], [3, 2], [13, 4], [1, 1], [8191, 13]]);
  /** @param {number} state @param {number[]} words @param {number} count */
  const decode = (state, words, count) => decodeRans(rans(2, 1, tables, [state], words), count, 2);
  // backwards from the state 2^16: each symbol doubles it and adds where it lies
  const push = (x, symbol) => Math.floor(x / 8192) * 16384 + (x % 8192) + 8192 * symbol;
  assert.deepEqual([...decode([1, 1, 0].reduce(push, 65536), [], 3)], [0, 1, 1]);
  // half of 2^16 is too little and takes a word, which makes it 2^31
  refuses(() => decode(65536, [0], 1), /does not end where it should/);
  refuses(() => decode(65536, [], 1), /ends early/);
  refuses(() => decode(65535, [], 1), /impossible state/);
});

test("rANS streams that contradict themselves are refused", () => {
  const sound = constantRans(7, 4);
  const changed = (place, byte) => sound.map((old, i) => (i === place ? byte : old));
  refuses(() => decodeRans(sound.subarray(0, 11), 5, 7), /too short/);
  refuses(() => decodeRans(sound, 5, 8), /of 7 symbols stands where 8 belong/);
  refuses(() => decodeRans(changed(2, 2), 5, 7), /has 2 contexts/);
  refuses(() => decodeRans(changed(8, 1), 5, 7), /longer or shorter/);
  refuses(() => decodeRans(sound, 5000, 7), /longer or shorter/);
  refuses(() => decodeRans(changed(12, 0), 5, 7), /longer than they should/);
  /** @type {(contexts: number, tables: [number, number][]) => Uint16Array} */
  const decode = (contexts, tables) =>
    decodeRans(rans(3, contexts, bits(tables), [65536], []), 5, 3);
  refuses(() => decode(1, [[0, 1]]), /context that is not used/);
  refuses(() => decode(1, [[1, 1], [0, 3], [0, 4]]), /do not sum/);
  refuses(() => decode(1, [[1, 1], [3, 3], [0, 9]]), /end early/);
  refuses(() => decode(1, [[1, 1], [3, 3], [15, 4], [1, 1], [0, 15]]), /out of range/);
  // only the first of three contexts is there, and symbol 1 asks for the second
  refuses(() => decode(3, [[1, 1], [2, 3], [0, 4], [0, 2]]), /context that is not used/);
});
