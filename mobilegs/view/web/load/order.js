/** Far Gaussians first: a counting sort of depths, for scenes that are drawn sorted. */

const BINS = 1 << 16;

/**
 * @param {Float32Array} centers 3 each
 * @param {[number, number, number]} forward the direction of looking
 * @returns {Uint32Array<ArrayBuffer>} rows, the farthest first
 */
export function farFirst(centers, [fx, fy, fz]) {
  const count = centers.length / 3;
  const depths = new Float32Array(count);
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < count; i++) {
    const depth = fx * centers[3 * i] + fy * centers[3 * i + 1] + fz * centers[3 * i + 2];
    depths[i] = depth;
    if (depth < low) low = depth;
    if (depth > high) high = depth;
  }
  const scale = high > low ? (BINS - 1) / (high - low) : 0;
  const bins = new Uint16Array(count);
  const starts = new Uint32Array(BINS + 1);
  for (let i = 0; i < count; i++) {
    bins[i] = BINS - 1 - Math.floor((depths[i] - low) * scale);
    starts[bins[i] + 1] += 1;
  }
  for (let bin = 0; bin < BINS; bin++) starts[bin + 1] += starts[bin];
  const order = new Uint32Array(count);
  for (let i = 0; i < count; i++) order[starts[bins[i]]++] = i;
  return order;
}
