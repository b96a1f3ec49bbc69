/**
 * What networks need, with 128-bit SIMD: WebAssembly, put together here from its instructions.
 *
 * It does what `defined` of dense.js does, some eight times as fast. Of a layer, four
 * outputs of eight Gaussians are added up in registers, so that a number that is loaded is used four
 * or eight times.
 */

const I32 = 0x7f;
const F32 = 0x7d;
const V128 = 0x7b;
// Gaussians at a time: two vectors
const ROWS = 8;
const OUTPUTS = 4;

/** @param {number} value @returns {number[]} LEB128 */
function unsigned(value) {
  return value < 128 ? [value] : [(value & 127) | 128, ...unsigned(value >>> 7)];
}

/** @param {number} value at least 0 @returns {number[]} signed LEB128 */
function constant(value) {
  const bytes = value < 64 ? [value] : [(value & 127) | 128];
  return value < 64 ? bytes : [...bytes, ...constant(value >>> 7)];
}

/** @param {number} id @param {number[]} bytes */
const section = (id, bytes) => [id, ...unsigned(bytes.length), ...bytes];
const get = (/** @type {number} */ local) => [0x20, ...unsigned(local)];
const set = (/** @type {number} */ local) => [0x21, ...unsigned(local)];
const number = (/** @type {number} */ value) => [0x41, ...constant(value)];
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
const PLUS = 0x6a;
const TIMES = 0x6c;
const BELOW = 0x49;

/** @param {number[]} body @param {number[]} again what must be true to go on */
const loop = (body, again) => [0x03, 0x40, ...body, ...again, 0x0d, 0, 0x0b];

/** @param {number} local @param {number} step */
const advance = (local, step) => [...get(local), ...number(step), PLUS, ...set(local)];

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

/** The module, whose function works in the memory that it is given. @param {number} block */
function assemble(block) {
  const name = (/** @type {string} */ text) => [text.length, ...new TextEncoder().encode(text)];
  const body = layerBody(block);
  return Uint8Array.from([
    0x00, 0x61, 0x73, 0x6d, 1, 0, 0, 0,
    ...section(1, [1, 0x60, 7, I32, I32, I32, I32, I32, I32, F32, 0]),
    ...section(2, [1, ...name("web"), ...name("memory"), 2, 0, 1]),
    ...section(3, [1, 0]),
    ...section(7, [1, ...name("layer"), 0, 0]),
    ...section(10, [1, ...unsigned(body.length), ...body]),
  ]); // prettier-ignore
}

/** @type {Map<number, WebAssembly.Module | null>} */
const modules = new Map();

/**
 * @typedef {object} Simd
 * @property {(weights: number, offsets: number, x: number, y: number, inputs: number,
 *   outputs: number, slope: number) => void} layer
 */

/**
 * The function in a memory of its own; null where there is no such thing, or it is forbidden.
 *
 * @param {number} block Gaussians in a block, a multiple of 8
 * @param {WebAssembly.Memory} memory
 * @returns {Simd | null}
 */
export function simdIn(block, memory) {
  let module = modules.get(block);
  if (module === undefined) {
    try {
      module = new WebAssembly.Module(assemble(block));
    } catch {
      module = null;
    }
    modules.set(block, module);
  }
  if (module === null) return null;
  return /** @type {any} */ (new WebAssembly.Instance(module, { web: { memory } }).exports);
}
