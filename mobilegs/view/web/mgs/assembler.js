/** WebAssembly, put together here from its instructions. */

export const I32 = 0x7f;
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

/**
 * A function of a memory that is given to it.
 *
 * @param {number[]} parameters their types
 * @param {number[]} results
 * @param {number[]} body locals first
 * @returns {(memory: WebAssembly.Memory) => Function | null} null where there is no such thing, or it is forbidden
 */
export function assembled(parameters, results, body) {
  const text = (/** @type {string} */ words) => [words.length, ...new TextEncoder().encode(words)];
  /** @type {WebAssembly.Module | null} */
  let module = null;
  try {
    module = new WebAssembly.Module(
      Uint8Array.from([
        0x00, 0x61, 0x73, 0x6d, 1, 0, 0, 0,
        ...section(1, [1, 0x60, parameters.length, ...parameters, results.length, ...results]),
        ...section(2, [1, ...text("web"), ...text("memory"), 2, 0, 1]),
        ...section(3, [1, 0]),
        ...section(7, [1, ...text("run"), 0, 0]),
        ...section(10, [1, ...unsigned(body.length), ...body]),
      ]),
    ); // prettier-ignore
  } catch {
    // as it is
  }
  return (memory) => {
    if (module === null) return null;
    return /** @type {any} */ (new WebAssembly.Instance(module, { web: { memory } }).exports).run;
  };
}
