/** WebAssembly, put together here from its instructions. Expressions and statements are their bytes. */

export const I32 = 0x7f;
export const F32 = 0x7d;
export const V128 = 0x7b;
export const PLUS = 0x6a;
export const MINUS = 0x6b;
export const TIMES = 0x6c;
export const AND = 0x71;
export const OR = 0x72;
export const SHIFT_LEFT = 0x74;
export const SHIFT_RIGHT = 0x76;
export const BELOW = 0x49;
export const ABOVE = 0x4b;
export const NOT_BELOW = 0x4f;

/** @param {number} value @returns {number[]} LEB128 */
export function unsigned(value) {
  return value < 128 ? [value] : [(value & 127) | 128, ...unsigned(value >>> 7)];
}

/** @param {number} value at least 0 @returns {number[]} signed LEB128 */
function constant(value) {
  const bytes = value < 64 ? [value] : [(value & 127) | 128];
  return value < 64 ? bytes : [...bytes, ...constant(value >>> 7)];
}

/** @param {number} id @param {number[]} bytes */
const section = (id, bytes) => [id, ...unsigned(bytes.length), ...bytes];
export const get = (/** @type {number} */ local) => [0x20, ...unsigned(local)];
export const set = (/** @type {number} */ local) => [0x21, ...unsigned(local)];
export const number = (/** @type {number} */ value) => [0x41, ...constant(value)];
/** @param {number[]} body @param {number[]} again what must be true to go on */
export const loop = (body, again) => [0x03, 0x40, ...body, ...again, 0x0d, 0, 0x0b];

/** @param {number} local @param {number} step */
export const advance = (local, step) => [...get(local), ...number(step), PLUS, ...set(local)];

/** An operation on four numbers at a time. @param {number} code */
export const simd = (code) => (/** @type {number[][]} */ ...operands) => [...operands.flat(), 0xfd, ...unsigned(code)];

/** A place in memory, aligned to nothing. @param {number} code @param {number} offset */
const placed = (code, offset) => [0xfd, ...unsigned(code), 0, ...unsigned(offset)];
export const load = (/** @type {number[]} */ at, offset = 0) => [...at, ...placed(0x00, offset)];
export const loadSplat = (/** @type {number[]} */ at, offset = 0) => [...at, ...placed(0x09, offset)];
/** @param {number[]} at @param {number[]} value @param {number} [offset] */
export const store = (at, value, offset = 0) => [...at, ...value, ...placed(0x0b, offset)];
/** @param {number[]} at @param {number[]} value @param {number} lane @param {number} [offset] */
export const storeLane = (at, value, lane, offset = 0) => [...at, ...value, ...placed(0x5a, offset), lane];
/** One number four times. @param {number} value */
export const floats = (value) => [0x43, ...new Uint8Array(Float32Array.of(value).buffer), 0xfd, 0x13];
/** @param {number} value at least 0 */
export const integers = (value) => [...number(value), 0xfd, 0x11];

/** Memory of so many bytes at least; null in browsers that have no WebAssembly, or hide it. @param {number} bytes */
export function memoryOf(bytes) {
  // pages of 64 KiB
  return typeof WebAssembly === "object" ? new WebAssembly.Memory({ initial: Math.ceil(bytes / 2 ** 16) }) : null;
}

/**
 * Functions of a memory that is given to them.
 *
 * @param {Record<string, {parameters: number[], results?: number[], body: number[]}>} functions
 *     types, and what is done, locals first
 * @returns {(memory: WebAssembly.Memory) => Record<string, Function> | null} null where there is no such thing, or
 *     it is forbidden
 */
export function assembled(functions) {
  const text = (/** @type {string} */ words) => [words.length, ...new TextEncoder().encode(words)];
  const all = Object.entries(functions);
  const list = (/** @type {number[][]} */ items) => [items.length, ...items.flat()];
  /** @type {WebAssembly.Module | null} */
  let module = null;
  try {
    module = new WebAssembly.Module(
      Uint8Array.from([
        0x00, 0x61, 0x73, 0x6d, 1, 0, 0, 0,
        ...section(1, list(all.map(([, { parameters, results = [] }]) =>
          [0x60, parameters.length, ...parameters, results.length, ...results]))),
        ...section(2, [1, ...text("web"), ...text("memory"), 2, 0, 1]),
        ...section(3, list(all.map((_, i) => [i]))),
        ...section(7, list(all.map(([name], i) => [...text(name), 0, i]))),
        ...section(10, list(all.map(([, { body }]) => [...unsigned(body.length), ...body]))),
      ]),
    ); // prettier-ignore
  } catch {
    // as it is
  }
  return (memory) => {
    if (module === null) return null;
    return /** @type {any} */ (new WebAssembly.Instance(module, { web: { memory } }).exports);
  };
}
