/**
 * What networks need, with 128-bit SIMD: WebAssembly, put together here from its instructions.
 *
 * It does what `defined` of dense.js does, some eight times as fast. Of a layer, four
 * outputs of eight Gaussians are added up in registers, so that a number that is loaded is used four
 * or eight times.
 */

import { BELOW, I32, PLUS, TIMES, advance, assembled, get, loop, number, set, unsigned } from "./assembler.js";

const F32 = 0x7d;
const V128 = 0x7b;
// Gaussians at a time: two vectors
const ROWS = 8;
const OUTPUTS = 4;

const simd = (/** @type {number} */ code) => [0xfd, ...unsigned(code)];
// aligned to nothing
const at = (/** @type {number} */ offset) => [0, ...unsigned(offset)];
const load = (/** @type {number} */ offset) => [...simd(0x00), ...at(offset)];
const loadSplat = (/** @type {number} */ offset) => [...simd(0x09), ...at(offset)];
const store = (/** @type {number} */ offset) => [...simd(0x0b), ...at(offset)];
const SPLAT = simd(0x13);
const ADD = simd(0xe4);
const MULTIPLY = simd(0xe6);
const MAXIMUM = simd(0xe9);

/**
 * `layer(weights, offsets, x, y, inputs, outputs, slope)` takes places in bytes, and numbers of
 * inputs and of outputs.
 *
 * @param {number} block Gaussians in a block
 */
function layerBody(block) {
  const [weights, offsets, x, y, inputs, outputs, slope] = [0, 1, 2, 3, 4, 5, 6];
  const [o, row, px, pw, end, py] = [7, 8, 9, 10, 11, 12];
  const [x0, x1, w, slopes] = [13, 14, 15, 16];
  const sum = (/** @type {number} */ j, /** @type {number} */ k) => 17 + 2 * j + k;
  const four = [0, 1, 2, 3];
  const rowBytes = 4 * block;
  const multiplied = four.flatMap((j) => [
    ...get(pw), ...loadSplat(4 * j), ...set(w),
    ...[x0, x1].flatMap((values, k) => [
      ...get(sum(j, k)), ...get(w), ...get(values), ...MULTIPLY, ...ADD, ...set(sum(j, k)),
    ]),
  ]);
  const overInputs = loop(
    [
      ...get(px), ...load(0), ...set(x0),
      ...get(px), ...load(16), ...set(x1),
      ...multiplied,
      ...advance(px, rowBytes),
      ...advance(pw, 4 * OUTPUTS),
    ],
    [...get(pw), ...get(end), BELOW],
  );
  const overRows = loop(
    [
      ...four.flatMap((j) => [
        ...get(offsets), ...get(o), ...number(4), TIMES, PLUS, ...loadSplat(4 * j), ...set(sum(j, 0)),
        ...get(sum(j, 0)), ...set(sum(j, 1)),
      ]),
      ...get(x), ...get(row), PLUS, ...set(px),
      // four outputs take 16 bytes per input
      ...get(weights), ...get(o), ...get(inputs), TIMES, ...number(4), TIMES, PLUS, ...set(pw),
      ...get(pw), ...get(inputs), ...number(4 * OUTPUTS), TIMES, PLUS, ...set(end),
      ...overInputs,
      ...get(y), ...get(o), ...number(rowBytes), TIMES, PLUS, ...get(row), PLUS, ...set(py),
      ...four.flatMap((j) =>
        [0, 1].flatMap((k) => [
          ...get(py),
          ...get(sum(j, k)), ...get(sum(j, k)), ...get(slopes), ...MULTIPLY, ...MAXIMUM,
          ...store(j * rowBytes + 16 * k),
        ]),
      ),
      ...advance(row, 4 * ROWS),
    ],
    [...get(row), ...number(rowBytes), BELOW],
  );
  const code = [
    ...get(slope), ...SPLAT, ...set(slopes),
    ...loop(
      [...number(0), ...set(row), ...overRows, ...advance(o, OUTPUTS)],
      [...get(o), ...get(outputs), BELOW],
    ),
    0x0b,
  ];
  // locals first
  return [2, 6, I32, 12, V128, ...code];
}

/** @type {Map<number, (memory: WebAssembly.Memory) => Function | null>} */
const made = new Map();

/**
 * @typedef {(weights: number, offsets: number, x: number, y: number, inputs: number, outputs: number,
 *   slope: number) => void} Simd
 */

/**
 * The function in a memory of its own; null where there is no such thing, or it is forbidden.
 *
 * @param {number} block Gaussians in a block, a multiple of 8
 * @param {WebAssembly.Memory} memory
 * @returns {Simd | null}
 */
export function simdIn(block, memory) {
  let make = made.get(block);
  if (make === undefined) {
    make = assembled([I32, I32, I32, I32, I32, I32, F32], [], layerBody(block));
    made.set(block, make);
  }
  return /** @type {Simd | null} */ (make(memory));
}
