/** Sorts Gaussians by depth, the farthest first: a radix sort of float bits. */

const BINS = 1 << 16;

/**
 * Return the order of rendering.
 *
 * @param {Float32Array} means 3 each
 * @param {[number, number, number]} forward the viewing direction
 * @returns {Uint32Array<ArrayBuffer>} indices, the farthest first
 */
export function backToFront(means, [fx, fy, fz]) {
  const count = means.length / 3;
  const depths = new Float32Array(count);
  for (let i = 0; i < count; i++) {
    depths[i] = fx * means[3 * i] + fy * means[3 * i + 1] + fz * means[3 * i + 2];
  }
  // as integers, the bits of positive floats rise with them and those of negative ones fall
  const keys = new Uint32Array(depths.buffer);
  for (let i = 0; i < count; i++) keys[i] = keys[i] & 0x80000000 ? keys[i] : ~keys[i] & 0x7fffffff;
  let order = Uint32Array.from({ length: count }, (_, i) => i);
  let other = new Uint32Array(count);
  for (const shift of [0, 16]) {
    const starts = new Uint32Array(BINS + 1);
    for (let i = 0; i < count; i++) starts[((keys[i] >>> shift) & 0xffff) + 1] += 1;
    for (let bin = 0; bin < BINS; bin++) starts[bin + 1] += starts[bin];
    for (let i = 0; i < count; i++) {
      const row = order[i];
      other[starts[(keys[row] >>> shift) & 0xffff]++] = row;
    }
    [order, other] = [other, order];
  }
  return order;
}
