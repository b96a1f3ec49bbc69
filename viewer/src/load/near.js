/** Near plane of a scene that fills its unit of length, world units; that of 3DGS. */
const NEAR = 0.2;
/** Gaussians that are looked at, at most twice as many. */
const SAMPLE = 10_000;
/** Share of them that is inside of the size. */
const INSIDE = 0.9;

/**
 * Return the near plane of a scene whose file has none, as `near_of` in scene_file.py does.
 *
 * A scene in a unit in which it is small has a smaller one.
 *
 * @param {Float32Array} means x, y, z of each Gaussian
 */
export function nearOf(means) {
  const count = means.length / 3;
  const step = Math.max(1, Math.floor(count / SAMPLE));
  const axes = [0, 1, 2].map((axis) => Float32Array.from({ length: Math.ceil(count / step) }, (_, i) => means[3 * i * step + axis]));
  const middle = axes.map((values) => values.slice().sort()[(values.length - 1) >> 1]);
  const away = axes[0].map((_, i) => Math.max(...axes.map((values, axis) => Math.abs(values[i] - middle[axis]))));
  const size = away.sort()[Math.floor(INSIDE * (away.length - 1))];
  return NEAR * Math.min(1, Math.max(size, 1e-6));
}
