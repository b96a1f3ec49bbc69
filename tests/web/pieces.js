/** Files cut into pieces, as they may come over a network. */

/**
 * Random numbers in [0, 1), the same ones for a seed (a linear congruential generator).
 *
 * @param {number} seed
 */
export function randomNumbers(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/**
 * @param {Uint8Array} bytes
 * @param {() => number} random
 */
export function* pieces(bytes, random) {
  for (let start = 0; start < bytes.length; ) {
    // from single bytes, and none at all, to several streams at once
    const length = Math.floor(2 ** (random() * 13)) - 1;
    yield bytes.slice(start, start + length);
    start += length;
  }
}
