/** Parses the header of a `.mgs`. docs/reference/format.md, section 2. */

import { SceneError } from "./error.js";
import { COLOR_STREAMS } from "./weights.js";

/** @typedef {"scale" | "rotation" | "appearance" | "opacity" | "lobes"} Attribute */
/** @typedef {{ count: number, length: number, size: number }} Cut books, of entries of numbers */
/** @typedef {{ least: number, size: number, middle: number }} Column of whole numbers */
/** @typedef {{ step: number, columns: Column[] }} Scalar numbers that are multiples of a step */
/** @typedef {{ center: Float32Array, radius: number, exponent: number }} PositionGrid of the positions */
/** @typedef {{ degree: number, latents: number, hidden: number[] }} LobeShape */
/**
 * @typedef {object} Weighting the weights of sort-free blending; docs/reference/format.md, section 9
 * @property {string} name
 * @property {number} exponent_max
 * @property {number} sigma
 * @property {number} background_weight
 * @property {number} alpha_min
 */
/**
 * @typedef {object} Footprint how a Gaussian covers pixels; docs/reference/format.md, section 9
 * @property {number} blur px^2
 * @property {boolean} antialiased
 * @property {boolean} soft_edge
 */
/**
 * @typedef {object} View a training camera
 * @property {Float32Array} viewmat world to camera, 16 numbers row by row, OpenCV axes
 * @property {Float32Array} K camera to pixels, 9 numbers row by row
 * @property {number} width pixels
 * @property {number} height pixels
 */
/** @typedef {string | number | boolean | null} MetaValue */
/**
 * @typedef {object} Header
 * @property {number} count Gaussians
 * @property {number[]} lodSizes Gaussians of each LOD level, the coarsest first
 * @property {Map<Attribute, Cut>} cuts in the file's order; none if there are scalars
 * @property {Map<Attribute, Scalar>} scalars in the file's order; none if there are cuts
 * @property {PositionGrid} grid
 * @property {string} colors `linear`, `networks` or `latent_networks`
 * @property {boolean} sorted whether the scene is blended back to front
 * @property {LobeShape | null} lobes
 * @property {boolean} network
 * @property {Weighting} weighting
 * @property {Footprint} footprint
 * @property {Float32Array} background sRGB in [0, 1]
 * @property {number} near world units
 * @property {View[]} views
 * @property {Record<string, MetaValue>} meta
 */
/** @typedef {Record<string, unknown>} Fields */
/** @typedef {import("./container.js").Row} Row */

/** The footprint of files that name none, that of 3DGS. @type {Readonly<Footprint>} */
export const CLASSIC = Object.freeze({ blur: 0.3, antialiased: false, soft_edge: false });

const COUNT_MAX = 2 ** 26;
const LOD_LEVELS_MAX = 8;
const SIZE_MAX = 4096;
const CODE_MAX = 2 ** 14;
const STEP_MIN = 1e-5;
const STEP_MAX = 1e3;
const LOG_SCALE_MAX = 80; // its exponential is finite in float32
const ANGLE_MAX = 8; // radians; up to this, float32 and float64 give the same quaternion
const LATENTS_MAX = 32;
const HIDDEN_MAX = 256;
const HIDDEN_LAYERS = 3;
const VIEWS_MAX = 64;
const SIDE_MAX = 2 ** 16;
const META_MAX = 64;
const TEXT_MAX = 4096;
const WORLD_MIN = 1e-20;
const WORLD_MAX = 1e20;
// control characters and unpaired surrogates
const UNSHOWN = /[\x00-\x1f\x7f-\x9f\p{Cs}]/u;
const WEIGHTINGS = ["mobile_gs", "no_depth", "no_scale", "sort_free_gs", "depth_pass"];
/** @type {[Attribute, [count: number, length: number][]][]} the cuts that an attribute can have */
const CUTS = [
  ["scale", [[3, 1], [1, 3]]],
  ["rotation", [[2, 2], [1, 4]]],
  ["appearance", [[3, 2]]],
  ["opacity", [[1, 1]]],
];
// latents of a colour: the number in the paper, and the number of harmonics
const COLOR_LATENTS = [6, 12];
/** @type {[Attribute, number][]} columns per attribute; colours may have more, lobes have one per latent */
const COLUMNS = [
  ["scale", 3],
  ["rotation", 3],
  ["appearance", COLOR_LATENTS[0]],
  ["opacity", 1],
];

/**
 * Check type and range of each field; other fields are ignored.
 *
 * @param {Fields} fields
 * @param {number} bytes of the whole file
 * @returns {Header}
 */
export function parseHeader(fields, bytes) {
  const { colors = "networks" } = fields;
  for (const [name, value, ...known] of [
    ["mode", fields.mode, "nvq", "sq"],
    ["blend", fields.blend, "sortfree", "sorted"],
    ["sh_degree", fields.sh_degree, 1],
    ["colors", colors, "linear", "networks", "latent_networks"],
  ]) {
    if (!known.includes(value)) {
      throw new SceneError(
        `the .mgs file has ${name} '${shown(value)}', which this program ` +
          "does not know: a newer one may",
      );
    }
  }
  const lobes = parseLobes(fields);
  const network = fields.network;
  if (typeof network !== "boolean") throw broken("network");
  if (network && lobes !== null) {
    throw new SceneError("the .mgs file has lobes and a view network: it can have one of them");
  }
  const plain = fields.mode === "sq";
  const count = integer(fields, "count", 1, COUNT_MAX);
  const header = {
    count,
    lodSizes: parseLodSizes(fields, count),
    cuts: plain ? new Map() : parseCuts(object(fields, "codebooks"), lobes),
    scalars: plain ? parseScalars(object(fields, "scalars"), lobes, colors === "linear") : new Map(),
    grid: parsePositionGrid(object(fields, "positions")),
    colors: /** @type {string} */ (colors),
    sorted: fields.blend === "sorted",
    lobes,
    network,
    weighting: parseWeighting(object(fields, "weighting")),
    footprint: parseFootprint(object(fields, "footprint")),
    background: floats(fields, "background", 3),
    near: number(fields, "near"),
    views: list(fields, "views").map(parseView),
    meta: parseMeta(object(fields, "meta")),
  };
  // bytes of unused streams do not justify a count
  const names = usedStreams(header);
  const rows = /** @type {Row[]} */ (fields.streams).filter((row) => names.has(row.name));
  const used = rows.reduce((sum, row) => sum + row.bytes, 0);
  if (count > used) {
    throw new SceneError(
      `the .mgs file claims ${count} Gaussians in ${used} of its ${bytes} bytes: it is damaged`,
    );
  }
  if (header.footprint.soft_edge && header.sorted) throw broken("footprint.soft_edge");
  if (header.background.some((value) => value < 0 || value > 1)) throw broken("background");
  if (!(header.near > 0 && header.near <= WORLD_MAX)) throw broken("near");
  if (header.views.length > VIEWS_MAX) throw broken("views");
  return header;
}

/**
 * Whether `text` is printable and has at most `longest` code points.
 *
 * @param {unknown} text
 * @param {number} longest
 */
export function shortText(text, longest) {
  if (typeof text !== "string" || text.length > 2 * longest || UNSHOWN.test(text)) return false;
  return text.length <= longest || [...text].length <= longest;
}

/** Names of the streams that a header needs. @param {Header} header */
function usedStreams({ colors, lobes, network, cuts, scalars, lodSizes }) {
  const rows = ["positions"];
  for (const [name, { count }] of cuts) for (let i = 0; i < count; i++) rows.push(`${name}.${i}`);
  for (const [name, { columns }] of scalars) rows.push(...columns.map((_, i) => `${name}.${i}`));
  if (scalars.size) rows.push("rotation-finer");
  const names = lodSizes.flatMap((_, i) => rows.map((name) => (i ? `${name}@${i}` : name)));
  names.push(COLOR_STREAMS[colors]);
  if (lobes) names.push("lobe-decoder");
  if (network) names.push("view-network");
  if (cuts.size) names.push("codebooks");
  return new Set(names);
}

/** @param {Fields} fields @param {number} count @returns {number[]} */
function parseLodSizes(fields, count) {
  const sizes = list(fields, "layers").map((size) => integer({ layers: size }, "layers", 1, count));
  const sum = sizes.reduce((a, b) => a + b, 0);
  if (sizes.length > LOD_LEVELS_MAX || sum !== count) throw broken("layers");
  return sizes;
}

/**
 * @param {Fields} fields
 * @returns {LobeShape | null}
 */
function parseLobes(fields) {
  if (fields.lobes === null) return null;
  const shape = object(fields, "lobes");
  const hidden = list(shape, "hidden");
  if (hidden.length > HIDDEN_LAYERS) throw broken("lobes.hidden");
  return {
    degree: integer(shape, "degree", 0, 3),
    latents: integer(shape, "latents", 0, LATENTS_MAX),
    hidden: hidden.map((width) => integer({ hidden: width }, "hidden", 1, HIDDEN_MAX)),
  };
}

/**
 * @param {Fields} books
 * @param {LobeShape | null} lobes
 * @returns {Map<Attribute, Cut>}
 */
function parseCuts(books, lobes) {
  /** @type {Map<Attribute, Cut>} */
  const cuts = new Map();
  for (const [name, known] of CUTS) {
    if (name === "opacity" && !Object.hasOwn(books, name) && lobes !== null) continue;
    const book = object(books, name);
    const cut = known.find(([count, length]) => book.count === count && book.length === length);
    if (!cut) throw broken(`codebooks.${name}`);
    cuts.set(name, { count: cut[0], length: cut[1], size: integer(book, "size", 1, SIZE_MAX) });
  }
  let latents = 0;
  if (Object.hasOwn(books, "lobes")) {
    const book = object(books, "lobes");
    const count = integer(book, "count", 1, LATENTS_MAX);
    const length = integer(book, "length", 1, LATENTS_MAX);
    cuts.set("lobes", { count, length, size: integer(book, "size", 1, SIZE_MAX) });
    latents = count * length;
  }
  if (latents !== (lobes === null ? 0 : lobes.latents)) throw broken("codebooks.lobes");
  return cuts;
}

/**
 * @param {Fields} scalars
 * @param {LobeShape | null} lobes
 * @param {boolean} linear colours
 * @returns {Map<Attribute, Scalar>}
 */
function parseScalars(scalars, lobes, linear) {
  /** @type {Map<Attribute, Scalar>} */
  const found = new Map();
  const latents = lobes?.latents ?? 0;
  if (Object.hasOwn(scalars, "lobes") && !latents) throw broken("scalars.lobes");
  for (const [name, count] of /** @type {[Attribute, number][]} */ ([...COLUMNS, ["lobes", latents]])) {
    const spare = name === "opacity" && !Object.hasOwn(scalars, name) && lobes !== null;
    if (spare || count === 0) continue;
    const part = object(scalars, name);
    const [leasts, sizes, middles] = ["least", "size", "middle"].map((key) => list(part, key));
    const [fewest, most] = name === "appearance" && linear ? COLOR_LATENTS : [count, count];
    const many = leasts.length;
    if (many < fewest || many > most || sizes.length !== many || middles.length !== many) {
      throw broken(`scalars.${name}`);
    }
    const step = Math.fround(number(part, "step"));
    if (!(step >= STEP_MIN && step <= STEP_MAX)) throw broken(`scalars.${name}.step`);
    const columns = leasts.map((_, i) => {
      const own = { least: leasts[i], size: sizes[i], middle: middles[i] };
      const least = integer(own, "least", -CODE_MAX, CODE_MAX);
      const size = integer(own, "size", 1, SIZE_MAX);
      const largest = integer({ size: least + size - 1 }, "size", least, CODE_MAX);
      // the product of a float32 and a short integer is exact
      if (name === "scale" && largest * step > LOG_SCALE_MAX) throw broken("scalars.scale");
      const farthest = Math.max(-least, largest) + 0.5;
      if (name === "rotation" && farthest * step > ANGLE_MAX) throw broken("scalars.rotation");
      return { least, size, middle: integer(own, "middle", least, largest) };
    });
    found.set(name, { step, columns });
  }
  return found;
}

/**
 * @param {Fields} fields
 * @returns {PositionGrid}
 */
function parsePositionGrid(fields) {
  const center = floats(fields, "center", 3);
  const radius = Math.fround(number(fields, "radius"));
  // the nearest float32 to 1e20 is larger
  if (center.some((value) => Math.abs(value) > Math.fround(WORLD_MAX))) throw broken("positions.center");
  if (radius < WORLD_MIN || radius > WORLD_MAX) throw broken("positions.radius");
  return { center, radius, exponent: integer(fields, "exponent", 0, 14) };
}

/**
 * @param {Fields} fields
 * @returns {Weighting}
 */
function parseWeighting(fields) {
  const { name } = fields;
  if (typeof name !== "string") throw broken("name");
  if (!WEIGHTINGS.includes(name)) {
    throw new SceneError(
      `the .mgs file has the weighting '${shown(name)}': known are ${WEIGHTINGS.join(", ")}`,
    );
  }
  const weighting = {
    name,
    exponent_max: number(fields, "exponent_max"),
    sigma: number(fields, "sigma"),
    background_weight: number(fields, "background_weight"),
    alpha_min: fields.alpha_min === undefined ? 1 / 255 : number(fields, "alpha_min"),
  };
  if (!(weighting.exponent_max > 0 && weighting.exponent_max <= 80)) throw broken("exponent_max");
  if (!(weighting.sigma > 0 && weighting.sigma <= WORLD_MAX)) throw broken("sigma");
  if (weighting.background_weight < 0) throw broken("background_weight");
  if (!(weighting.alpha_min >= 1e-4 && weighting.alpha_min <= 0.1)) throw broken("alpha_min");
  return weighting;
}

/**
 * @param {Fields} fields
 * @returns {Footprint}
 */
function parseFootprint(fields) {
  const { antialiased, soft_edge } = fields;
  if (typeof antialiased !== "boolean") throw broken("footprint.antialiased");
  if (typeof soft_edge !== "boolean") throw broken("footprint.soft_edge");
  const blur = number(fields, "blur");
  if (!(blur > 0 && blur <= 4)) throw broken("footprint.blur");
  return { blur, antialiased, soft_edge };
}

/**
 * @param {unknown} value
 * @returns {View}
 */
function parseView(value) {
  const fields = object({ views: value }, "views");
  const viewmat = floats(fields, "viewmat", 16);
  const K = floats(fields, "K", 9);
  const affine = [0, 0, 0, 1].every((x, i) => viewmat[12 + i] === x);
  if (!affine || ![0, 0, 1].every((x, i) => K[6 + i] === x) || K[0] <= 0 || K[4] <= 0) {
    throw new SceneError("a view's matrices in the .mgs file are not those of a camera");
  }
  const width = integer(fields, "width", 1, SIDE_MAX);
  return { viewmat, K, width, height: integer(fields, "height", 1, SIDE_MAX) };
}

/**
 * @param {Fields} fields
 * @returns {Record<string, MetaValue>}
 */
function parseMeta(fields) {
  const notes = Object.entries(fields);
  if (notes.length > META_MAX) {
    throw new SceneError(`the .mgs file has ${notes.length} notes: ${META_MAX} are allowed`);
  }
  for (const [name, value] of notes) {
    const plain = value === null || typeof value === "boolean" || shortText(value, TEXT_MAX);
    const number = typeof value === "number" && Math.abs(value) <= 2 ** 53;
    if (!(plain || number) || !shortText(name, TEXT_MAX)) {
      throw new SceneError(`the note '${name.slice(0, 40)}' is not a short text or a number`);
    }
  }
  return /** @type {Record<string, MetaValue>} */ (fields);
}

/**
 * @param {Fields} fields
 * @param {string} name
 * @returns {Fields}
 */
function object(fields, name) {
  const value = fields[name];
  if (typeof value !== "object" || value === null || Array.isArray(value)) throw broken(name);
  return /** @type {Fields} */ (value);
}

/**
 * @param {Fields} fields
 * @param {string} name
 * @returns {unknown[]}
 */
function list(fields, name) {
  const value = fields[name];
  if (!Array.isArray(value)) throw broken(name);
  return value;
}

/**
 * @param {Fields} fields
 * @param {string} name
 * @param {number} smallest
 * @param {number} largest
 */
function integer(fields, name, smallest, largest) {
  const value = number(fields, name);
  if (!Number.isInteger(value) || value < smallest || value > largest) throw broken(name);
  return value;
}

/**
 * @param {Fields} fields
 * @param {string} name
 */
function number(fields, name) {
  return finite(fields[name], name);
}

/**
 * @param {Fields} fields
 * @param {string} name
 * @param {number} count
 */
function floats(fields, name, count) {
  const values = list(fields, name);
  if (values.length !== count) throw broken(name);
  return Float32Array.from(values, (value) => finite(value, name));
}

/**
 * @param {unknown} value
 * @param {string} name
 */
function finite(value, name) {
  // 3e38 is about the largest float32; beyond it rounding would make it infinite
  if (typeof value !== "number" || !(Math.abs(value) <= 3e38)) throw broken(name);
  return value;
}

/**
 * What a sentence says of a value. What JSON has made of a list or an object may have no text.
 *
 * @param {unknown} value
 */
function shown(value) {
  if (typeof value !== "object" || value === null) return String(value).slice(0, 40);
  return Array.isArray(value) ? "a list" : "an object";
}

/** @param {string} name */
function broken(name) {
  return new SceneError(
    `the field '${name}' in the header of the .mgs file is missing or invalid`,
  );
}
