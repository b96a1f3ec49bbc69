/** The kernels of viewer/wasm, compiled once and instantiated for each memory. */

import { KERNELS } from "../../wasm/kernels.js";

/**
 * @typedef {object} Kernels functions that take byte offsets for pointers; viewer/wasm says what they do
 * @property {(weights: number, offsets: number, x: number, y: number, inputs: number, outputs: number,
 *   slope: number) => void} layer
 * @property {(x: number, y: number, width: number) => void} units
 * @property {Pull} pull_plain
 * @property {Pull} pull_contextual
 * @property {(scales: number, quats: number, sh: number, lobes: number, words: number, pairs: number,
 *   stride: number, leastBits: number, growBits: number) => void} pack
 */
/**
 * @typedef {(lanes: number, symbols: number, spans: number, alphabet: number, word: number, end: number,
 *   count: number, length: number, longer: number) => number} Pull
 */

/** Null where the browser forbids WebAssembly or has no SIMD. @type {WebAssembly.Module | null | undefined} */
let compiled;
/** @type {WeakMap<WebAssembly.Memory, Kernels>} */
const instances = new WeakMap();

/** A memory of at least `bytes` bytes; null in browsers without WebAssembly. @param {number} bytes */
export function newMemory(bytes) {
  // pages of 64 KiB
  return typeof WebAssembly === "object" ? new WebAssembly.Memory({ initial: Math.ceil(bytes / 2 ** 16) }) : null;
}

/**
 * The kernels that work in a memory; null where they cannot run.
 *
 * @param {WebAssembly.Memory | null} memory
 */
export function kernelsIn(memory) {
  if (memory === null) return null;
  if (compiled === undefined) {
    try {
      const digits = /** @type {RegExpMatchArray} */ (KERNELS.match(/../g));
      compiled = new WebAssembly.Module(Uint8Array.from(digits, (byte) => parseInt(byte, 16)));
    } catch {
      compiled = null;
    }
  }
  if (compiled === null) return null;
  let kernels = instances.get(memory);
  if (!kernels) {
    const { exports } = new WebAssembly.Instance(compiled, { env: { memory } });
    kernels = /** @type {Kernels} */ (/** @type {unknown} */ (exports));
    instances.set(memory, kernels);
  }
  return kernels;
}
