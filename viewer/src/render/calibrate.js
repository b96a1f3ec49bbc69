/**
 * Measures which variant renders fastest on a device.
 *
 * Two synthetic scenes compare instances with batches (many small Gaussians) and float16 with float32
 * sums (large Gaussians). Either can be faster by a factor of two and more, depending on the device.
 */

/** @typedef {import("./types.js").Camera} Camera */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {import("./types.js").Variant} Variant */
/**
 * @typedef {object} Drawing the parts of a renderer that are used here
 * @property {Variant} variant
 * @property {Variant[]} variants
 * @property {(scene: SceneData) => void} setScene
 * @property {(camera: Camera) => Promise<void>} drawUnseen
 * @property {() => string} describe
 */

const LONG = 4; // milliseconds that suffice to compare two variants
const OWN = 3; // times the duration of the smallest image, which is mostly overhead
const BETTER = 0.85; // share of the default variant's time below which the other one is chosen
const REPEATS = 3;
const SMALL = { from: 1 << 6, to: 1 << 16, times: 4 }; // Gaussians
const LARGE = { from: 1 << 5, to: 1 << 10, times: 2 }; // pixels on a side
const LARGE_COUNT = 128;
const MEMORY = "mobilegs variant 1";

/**
 * The stored fastest variant of this device, or null.
 *
 * @param {Drawing} renderer
 * @param {Storage | null} storage
 * @returns {Variant | null}
 */
export function knownVariant(renderer, storage) {
  let known = null;
  try {
    known = storage?.getItem(`${MEMORY} ${renderer.describe()}`) ?? null;
  } catch {
    // forbidden here
  }
  return renderer.variants.find((variant) => written(variant) === known) ?? null;
}

/**
 * Measure the fastest variant and store it. The renderer has another scene afterwards.
 *
 * @param {Drawing} renderer
 * @param {Storage | null} storage
 * @returns {Promise<Variant>}
 */
export async function fastestVariant(renderer, storage) {
  const usual = { floats: false, strips: false };
  const variant = { ...usual };
  if (await isFaster(renderer, usual, { ...usual, strips: true }, SMALL, smallOnes)) {
    variant.strips = true;
  }
  if (renderer.variants.some(({ floats }) => floats)) {
    const floats = { ...variant, floats: true };
    if (await isFaster(renderer, variant, floats, LARGE, largeOnes)) variant.floats = true;
  }
  try {
    storage?.setItem(`${MEMORY} ${renderer.describe()}`, written(variant));
  } catch {
    // storage is full or forbidden: the next visit measures again
  }
  return variant;
}

/**
 * Render one packed Gaussian off screen, so that the device compiles the shaders. The renderer has another
 * scene afterwards.
 *
 * @param {Drawing} renderer
 */
export async function warmUp(renderer) {
  renderer.setScene({
    ...someScene(1, 1, () => [0, 0, 1]),
    weighting: { index: 4, exponentMax: 4, sigma: 1, backgroundWeight: 0 }, // the default's
    packing: { center: [0, 0, 0], unit: 1, leastScaleBits: 0, scaleBitsSpan: 0 },
    shapes: Uint32Array.of(0, 0x3c00, 0, 0), // z is 1
    colors: new Uint32Array(4),
    shSize: 4,
    lobes: new Uint32Array(5),
    lobeSize: 9,
  });
  await renderer.drawUnseen(frontal(1));
}

/**
 * Render one dot into a canvas that is still hidden, so that the device compiles the shaders of dots.
 *
 * @param {Pick<import("./create_renderer.js").Renderer, "setDots" | "drawDots">} renderer
 */
export function warmUpDots(renderer) {
  renderer.setDots({ means: Float32Array.of(0, 0, 1), color: [0, 0, 0], side: 1, background: [0, 0, 0] });
  renderer.drawDots(frontal(1));
  renderer.setDots(null);
}

/** @param {Variant} variant */
const written = ({ floats, strips }) => `${floats} ${strips}`;

/**
 * Return whether `other` is faster than `usual`, on scenes that grow until rendering takes long enough.
 *
 * @param {Drawing} renderer
 * @param {Variant} usual
 * @param {Variant} other
 * @param {{from: number, to: number, times: number}} sizes
 * @param {(size: number) => {scene: SceneData, side: number}} make
 */
async function isFaster(renderer, usual, other, { from, to, times: grow }, make) {
  let least = 0;
  for (let size = from; ; size *= grow) {
    const { scene, side } = make(size);
    renderer.setScene(scene);
    const times = [Infinity, Infinity];
    // alternate, so that other load meets both; the first round compiles shaders
    for (let i = 0; i <= REPEATS; i++) {
      for (const [which, variant] of [usual, other].entries()) {
        renderer.variant = variant;
        const started = performance.now();
        await renderer.drawUnseen(frontal(side));
        if (i > 0) times[which] = Math.min(times[which], performance.now() - started);
      }
    }
    const most = Math.max(...times);
    if (size === from) least = most;
    if (most > Math.max(LONG, OWN * least) || size >= to) return times[1] < BETTER * times[0];
  }
}

/** Gaussians of one or two pixels in a grid. @param {number} count */
function smallOnes(count) {
  const across = Math.ceil(Math.sqrt(count));
  const place = (/** @type {number} */ i) => (2 * (i + 0.5)) / across - 1;
  const scene = someScene(count, 1e-3, (i) => [place(i % across), place(Math.floor(i / across)), 1]);
  return { scene, side: 256 };
}

/** Gaussians that each cover the whole image. @param {number} side */
function largeOnes(side) {
  return { scene: someScene(LARGE_COUNT, 1, (i) => [0, 0, 1 + i / LARGE_COUNT]), side };
}

/**
 * @param {number} count
 * @param {number} size
 * @param {(i: number) => [number, number, number]} placeOf
 * @returns {SceneData}
 */
function someScene(count, size, placeOf) {
  const shapes = new Float32Array(12 * count);
  for (let i = 0; i < count; i++) {
    const [x, y, z] = placeOf(i);
    shapes.set([size, 0, 0, x, 0, size, 0, y, 0, 0, size, z], 12 * i);
  }
  return {
    count,
    packing: null,
    shapes,
    colors: new Float32Array(3 * count),
    shSize: 1,
    lobes: new Float32Array(2 * count).fill(1),
    lobeSize: 1,
    sorted: false,
    weighting: { index: 0, exponentMax: 4, sigma: 1, backgroundWeight: 0 },
    background: [0, 0, 0],
  };
}

/** A camera that looks along z; at a distance of 1 the image is 2 units wide. @param {number} side @returns {Camera} */
function frontal(side) {
  return {
    viewmat: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
    fx: side / 2,
    fy: side / 2,
    cx: side / 2,
    cy: side / 2,
    width: side,
    height: side,
    near: 0.1,
  };
}
