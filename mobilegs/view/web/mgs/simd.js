/**
 * What blocks of Gaussians need, with 128-bit SIMD: WebAssembly, put together here.
 *
 * It does what `apply` and `units` of machine.js define, some eight times as fast. Of a layer, four
 * outputs of eight Gaussians are added up in registers, so that a number that is loaded is used four
 * or eight times.
 */

import {
  BELOW, F32, I32, PLUS, TIMES, V128, advance, assembled, floats, get, load, loadSplat, loop, number, set, simd,
  store,
} from "./assembler.js"; // prettier-ignore

// Gaussians at a time: two vectors
const ROWS = 8;
const OUTPUTS = 4;

const splat = simd(0x13);
const root = simd(0xe3);
const plus = simd(0xe4);
const times = simd(0xe6);
const divided = simd(0xe7);
const largest = simd(0xe9);

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
    ...loadSplat(get(pw), 4 * j), ...set(w),
    ...[x0, x1].flatMap((values, k) => [...plus(get(sum(j, k)), times(get(w), get(values))), ...set(sum(j, k))]),
  ]);
  const overInputs = loop(
    [
      ...load(get(px)), ...set(x0),
      ...load(get(px), 16), ...set(x1),
      ...multiplied,
      ...advance(px, rowBytes),
      ...advance(pw, 4 * OUTPUTS),
    ],
    [...get(pw), ...get(end), BELOW],
  );
  const overRows = loop(
    [
      ...four.flatMap((j) => [
        ...loadSplat([...get(offsets), ...get(o), ...number(4), TIMES, PLUS], 4 * j), ...set(sum(j, 0)),
        ...get(sum(j, 0)), ...set(sum(j, 1)),
      ]),
      ...get(x), ...get(row), PLUS, ...set(px),
      // four outputs take 16 bytes per input
      ...get(weights), ...get(o), ...get(inputs), TIMES, ...number(4), TIMES, PLUS, ...set(pw),
      ...get(pw), ...get(inputs), ...number(4 * OUTPUTS), TIMES, PLUS, ...set(end),
      ...overInputs,
      ...get(y), ...get(o), ...number(rowBytes), TIMES, PLUS, ...get(row), PLUS, ...set(py),
      ...four.flatMap((j) =>
        [0, 1].flatMap((k) => {
          const found = get(sum(j, k));
          return store(get(py), largest(found, times(found, get(slopes))), j * rowBytes + 16 * k);
        }),
      ),
      ...advance(row, 4 * ROWS),
    ],
    [...get(row), ...number(rowBytes), BELOW],
  );
  const code = [
    ...splat(get(slope)), ...set(slopes),
    ...loop(
      [...number(0), ...set(row), ...overRows, ...advance(o, OUTPUTS)],
      [...get(o), ...get(outputs), BELOW],
    ),
    0x0b,
  ];
  // locals first
  return [2, 6, I32, 12, V128, ...code];
}

/**
 * `units(x, y, width)` takes places in bytes, and a number of columns.
 *
 * @param {number} block
 * @param {number} least of lengths
 */
function unitsBody(block, least) {
  const [x, y, width, row, from, to, end, value, sum] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
  const rowBytes = 4 * block;
  const overColumns = (/** @type {number[]} */ body) => [
    ...get(x), ...get(row), PLUS, ...set(from),
    ...loop([...load(get(from)), ...set(value), ...body, ...advance(from, rowBytes)], [...get(from), ...get(end), BELOW]),
  ];
  const code = [
    ...get(x), ...get(width), ...number(rowBytes), TIMES, PLUS, ...set(end),
    ...loop(
      [
        ...floats(0), ...set(sum),
        ...overColumns([...plus(get(sum), times(get(value), get(value))), ...set(sum)]),
        ...divided(floats(1), largest(root(get(sum)), floats(least))), ...set(sum),
        ...get(y), ...get(row), PLUS, ...set(to),
        ...overColumns([...store(get(to), times(get(value), get(sum))), ...advance(to, rowBytes)]),
        ...advance(row, 16),
      ],
      [...get(row), ...number(rowBytes), BELOW],
    ),
    0x0b,
  ];
  return [2, 4, I32, 2, V128, ...code];
}

/**
 * @typedef {object} Simd
 * @property {(weights: number, offsets: number, x: number, y: number, inputs: number, outputs: number,
 *   slope: number) => void} layer
 * @property {(x: number, y: number, width: number) => void} units
 */

/** @type {((memory: WebAssembly.Memory) => Record<string, Function> | null) | undefined} */
let make;

/**
 * Functions in a memory of their own; null where there is no such thing, or it is forbidden.
 *
 * @param {number} block Gaussians in a block, a multiple of 8
 * @param {number} least of lengths
 * @param {WebAssembly.Memory} memory
 * @returns {Simd | null}
 */
export function simdIn(block, least, memory) {
  make ??= assembled({
    layer: { parameters: [I32, I32, I32, I32, I32, I32, F32], body: layerBody(block) },
    units: { parameters: [I32, I32, I32], body: unitsBody(block, least) },
  });
  return /** @type {Simd | null} */ (/** @type {unknown} */ (make(memory)));
}
