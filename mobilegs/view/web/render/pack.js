/** From what a file holds of each Gaussian to what GPUs take. */

/** @typedef {import("../mgs/header.js").Header} Header */
/** @typedef {import("../mgs/scene.js").Part} Part */
/** @typedef {import("../mgs/scene.js").Scene} Scene */
/** @typedef {import("./types.js").SceneData} SceneData */
/** @typedef {"shapes" | "colors" | "lobes"} Packed */

const WEIGHTINGS = ["mobile_gs", "no_depth", "no_scale", "sort_free_gs"];
const INVISIBLE = -1e4; // logit of an opacity that nothing brings back
/** Which packed part a part of the scene goes into. @type {Record<Part, Packed>} */
const PACKED_OF = {
  means: "shapes",
  logScales: "shapes",
  quats: "shapes",
  sh: "colors",
  lobes: "lobes",
};

/**
 * The scene of a `.mgs` file in the form that renderers take, its rows as far as they are known.
 *
 * @param {Header} header
 * @param {Scene} scene
 * @returns {SceneData}
 */
export function packScene(header, scene) {
  const { weighting, background } = header;
  const packed = {
    count: scene.count,
    shapes: new Float32Array(12 * scene.count),
    colors: new Float32Array(12 * scene.count),
    shSize: 4,
    lobes: new Float32Array(scene.lobes.length),
    lobeSize: (scene.lobeDegree + 1) ** 2,
    sorted: false,
    weighting: {
      index: WEIGHTINGS.indexOf(weighting.name),
      exponentMax: weighting.exponent_max,
      sigma: weighting.sigma,
      backgroundWeight: weighting.background_weight,
    },
    background: /** @type {[number, number, number]} */ (Array.from(background)),
  };
  for (const part of /** @type {Packed[]} */ (["shapes", "colors", "lobes"])) {
    packed[part].set(packRows(scene, part, 0, scene.count));
  }
  return packed;
}

/**
 * The packed parts that must be made anew when parts of the scene have changed.
 *
 * @param {Part[]} changed
 * @returns {Packed[]}
 */
export function packedParts(changed) {
  return [...new Set(changed.map((part) => PACKED_OF[part]))];
}

/**
 * One packed part of the Gaussians from `from` up to, but without, `to`.
 *
 * @param {Scene} scene
 * @param {Packed} part
 * @param {number} from
 * @param {number} to
 * @returns {Float32Array<ArrayBuffer>}
 */
export function packRows(scene, part, from, to) {
  if (part === "shapes") return packShapes(scene, from, to);
  if (part === "colors") return scene.sh.slice(12 * from, 12 * to);
  const stride = scene.lobes.length / scene.count;
  const lobes = scene.lobes.slice(stride * from, stride * to);
  for (let i = from; i < to; i++) {
    const q = 4 * i;
    const { quats } = scene;
    if (quats[q] || quats[q + 1] || quats[q + 2] || quats[q + 3]) continue;
    lobes[stride * (i - from)] = INVISIBLE; // a rotation that is none
  }
  return lobes;
}

/**
 * Three rows of four: rotation times scale, by columns, and the centre behind them.
 *
 * @param {Scene} scene
 * @param {number} from
 * @param {number} to
 */
function packShapes({ means, logScales, quats }, from, to) {
  const shapes = new Float32Array(12 * (to - from));
  for (let i = from, at = 0; i < to; i++, at += 12) {
    const [w, x, y, z] = [quats[4 * i], quats[4 * i + 1], quats[4 * i + 2], quats[4 * i + 3]];
    const a = Math.exp(logScales[3 * i]);
    const b = Math.exp(logScales[3 * i + 1]);
    const c = Math.exp(logScales[3 * i + 2]);
    shapes[at] = a * (1 - 2 * (y * y + z * z));
    shapes[at + 1] = a * 2 * (x * y + w * z);
    shapes[at + 2] = a * 2 * (x * z - w * y);
    shapes[at + 3] = means[3 * i];
    shapes[at + 4] = b * 2 * (x * y - w * z);
    shapes[at + 5] = b * (1 - 2 * (x * x + z * z));
    shapes[at + 6] = b * 2 * (y * z + w * x);
    shapes[at + 7] = means[3 * i + 1];
    shapes[at + 8] = c * 2 * (x * z + w * y);
    shapes[at + 9] = c * 2 * (y * z - w * x);
    shapes[at + 10] = c * (1 - 2 * (x * x + y * y));
    shapes[at + 11] = means[3 * i + 2];
  }
  return shapes;
}
