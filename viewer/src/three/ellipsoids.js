/** Where the Gaussians of a packed scene are: their extent, and the surface that a ray meets. */

/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("../viewer/vector.js").Vector} Vector */

const BITS = new Uint32Array(1);
const FLOAT = new Float32Array(BITS.buffer);
const STEPS = [2047, 2047, 1023];
const HARMONIC = 0.28209479177387814; // of degree 0
const REACH = 3; // standard deviations within which a Gaussian counts
const FAINT = -2; // logit of the opacity of what covers something
const OUTLIERS = 0.01; // share of a body's Gaussians that each side of its box leaves out

/**
 * The standard deviations of a Gaussian, as `shape_of` of packed.glsl.
 *
 * @param {SceneData} scene
 * @param {number} i
 * @returns {Vector}
 */
function scalesOf({ packing, shapes }, i) {
  const { leastScaleBits, scaleBitsSpan } = /** @type {import("../render/types.js").Packing} */ (packing);
  const word = shapes[4 * i + 2];
  const steps = [word & 2047, (word >>> 11) & 2047, word >>> 22];
  return /** @type {Vector} */ (
    steps.map((step, axis) => {
      BITS[0] = leastScaleBits + (scaleBitsSpan * step) / STEPS[axis];
      return FLOAT[0];
    })
  );
}

/**
 * A function that returns at least the largest standard deviation of a Gaussian.
 *
 * @param {SceneData} scene
 * @returns {(i: number) => number}
 */
function largestOf({ packing, shapes }) {
  const { leastScaleBits, scaleBitsSpan } = /** @type {import("../render/types.js").Packing} */ (packing);
  return (i) => {
    const word = shapes[4 * i + 2];
    const step = Math.max(word & 2047, (word >>> 11) & 2047, 2 * (word >>> 22) + 1);
    BITS[0] = leastScaleBits + (scaleBitsSpan * step) / 2047;
    return FLOAT[0];
  };
}

/** The rotation of a Gaussian, w, x, y, z. @param {SceneData} scene @param {number} i */
function rotationOf({ shapes }, i) {
  const word = shapes[4 * i + 3];
  const q = [2, 12, 22].map((shift) => ((word << shift) >> 22) * (Math.SQRT1_2 / 511));
  const rest = Math.sqrt(Math.max(0, 1 - q[0] ** 2 - q[1] ** 2 - q[2] ** 2));
  q.splice(word >>> 30, 0, rest);
  return q;
}

/**
 * The box around the ellipsoids of three standard deviations; null without Gaussians.
 *
 * @param {SceneData} scene
 * @param {Float32Array} means 3 each
 * @returns {{min: Vector, max: Vector} | null}
 */
export function boxOf(scene, means) {
  if (scene.count === 0) return null;
  const [min, max] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  const largest = largestOf(scene);
  for (let i = 0; i < scene.count; i++) {
    const reach = REACH * largest(i);
    for (let axis = 0; axis < 3; axis++) {
      const mean = means[3 * i + axis];
      min[axis] = Math.min(min[axis], mean - reach);
      max[axis] = Math.max(max[axis], mean + reach);
    }
  }
  return { min: /** @type {Vector} */ (min), max: /** @type {Vector} */ (max) };
}

/**
 * The box of a scene without its outliers: each side leaves a hundredth of the Gaussians out that cover something.
 *
 * @param {SceneData} scene
 * @param {Float32Array} means 3 each
 * @param {Float32Array} logits of the mean opacities
 * @returns {{min: Vector, max: Vector} | null} null without Gaussians
 */
export function bodyOf(scene, means, logits) {
  const largest = largestOf(scene);
  const solid = [...Array(scene.count).keys()].filter((i) => HARMONIC * logits[i] > FAINT);
  if (!solid.length) return boxOf(scene, means);
  const end = (/** @type {number} */ axis, /** @type {number} */ sign) => {
    const ends = Float32Array.from(solid, (i) => sign * means[3 * i + axis] + REACH * largest(i)).sort();
    return sign * ends[Math.floor((1 - OUTLIERS) * (ends.length - 1))];
  };
  const corner = (/** @type {number} */ sign) => /** @type {Vector} */ ([0, 1, 2].map((axis) => end(axis, sign)));
  return { min: corner(-1), max: corner(1) };
}

/**
 * The distance along a ray at which half of the light is gone, and the Gaussian there; null if more of it passes.
 *
 * A Gaussian takes the share that its opacity from all directions has at the ray's nearest point.
 *
 * @param {SceneData} scene
 * @param {Float32Array} means
 * @param {Float32Array} logits of the mean opacities
 * @param {Vector} origin
 * @param {Vector} direction
 * @param {(mean: Vector) => boolean} isShown whether a Gaussian there counts
 * @returns {{distance: number, index: number} | null} the distance in lengths of the direction
 */
export function surfaceAlong(scene, means, logits, origin, direction, isShown) {
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  const square = dx * dx + dy * dy + dz * dz;
  const largest = largestOf(scene);
  /** @type {{distance: number, index: number, alpha: number}[]} */
  const found = [];
  for (let i = 0; i < scene.count; i++) {
    const [x, y, z] = [means[3 * i] - ox, means[3 * i + 1] - oy, means[3 * i + 2] - oz];
    const along = (x * dx + y * dy + z * dz) / square;
    const off = x * x + y * y + z * z - along * along * square;
    if (off > (REACH * largest(i)) ** 2) continue;
    const met = nearestOn(scene, i, [x, y, z], direction);
    if (met.distance <= 0 || met.q > REACH * REACH) continue;
    if (!isShown([means[3 * i], means[3 * i + 1], means[3 * i + 2]])) continue;
    const most = 1 / (1 + Math.exp(-HARMONIC * logits[i]));
    found.push({ distance: met.distance, index: i, alpha: Math.min(0.99, most * Math.exp(-0.5 * met.q)) });
  }
  found.sort((a, b) => a.distance - b.distance);
  let light = 1;
  for (const { distance, index, alpha } of found) {
    light *= 1 - alpha;
    if (light < 0.5) return { distance, index };
  }
  return null;
}

/**
 * Where a ray is deepest in a Gaussian, and the square of its distance from the mean there, in standard deviations.
 *
 * @param {SceneData} scene
 * @param {number} i
 * @param {Vector} mean from the ray's origin
 * @param {Vector} direction
 */
function nearestOn(scene, i, mean, direction) {
  const scales = scalesOf(scene, i);
  const q = rotationOf(scene, i);
  const m = inAxes(q, scales, mean);
  const d = inAxes(q, scales, direction);
  const distance = dot(m, d) / dot(d, d);
  const off = m.map((value, axis) => value - distance * d[axis]);
  return { distance, q: dot(off, off) };
}

/** @param {number[]} a @param {number[]} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/**
 * A vector along the axes of a Gaussian, in its standard deviations.
 *
 * @param {number[]} q rotation
 * @param {Vector} scales
 * @param {Vector} vector
 */
function inAxes([w, x, y, z], scales, vector) {
  const axes = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
  return axes.map((axis, k) => dot(axis, vector) / Math.max(scales[k], 1e-12));
}
