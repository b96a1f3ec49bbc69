/** Reads 3DGS scenes in INRIA's `.ply` layout, which are rendered sorted. */

import { CLASSIC } from "../mgs/header.js";
import { parsedUp } from "../viewer/up.js";
import { cross, dot } from "../viewer/vector.js";
import { isPly } from "./file_kind.js";

/** @typedef {import("../render/types.js").Footprint} Footprint */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("../viewer/vector.js").Vector} Vector */

const HEADER_MAX = 1 << 16;
const C0 = 0.28209479177387814;
// the rule of mobilegs/gaussians.py, whose names these are
const NUMBER_MAX = 1e30;
const [SQUARE_MIN, SQUARE_MAX] = [1e-24, 1e36];
const LOG_SCALE_MAX = 69;
const [LOGIT_MAX, LOG_SCALE_MIN] = [13.8, -69];
const SIDE_MAX = 1 << 16; // pixels of a photo
const BOX_SHARE = 0.75; // of a photo, as in mobilegs/viewpoints/framing.py
const TYPES = new Map([
  ["char", 1], ["int8", 1], ["uchar", 1], ["uint8", 1], ["short", 2], ["int16", 2], ["ushort", 2],
  ["uint16", 2], ["int", 4], ["int32", 4], ["uint", 4], ["uint32", 4], ["float", 4], ["float32", 4],
  ["double", 8], ["float64", 8],
]); // prettier-ignore
/** Of `Vertical Axis`: nerfstudio writes z for scenes with z up, Brush y for all scenes. */
const VERTICAL_AXES = /** @type {Map<string, Vector>} */ (new Map([["x", [1, 0, 0]], ["y", [0, -1, 0]], ["z", [0, 0, 1]]]));
const NEEDED = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1"];
NEEDED.push("scale_2", "rot_0", "rot_1", "rot_2", "rot_3");

/**
 * The scene of a whole file; rows that cannot be drawn are left out.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @returns {SceneData}
 */
export function readPly(bytes) {
  const { offsets, stride, rows, start, footprint, up, lines } = parseHeader(bytes);
  const view = new DataView(bytes.buffer, bytes.byteOffset + start);
  const rest = [...offsets.keys()].filter((name) => name.startsWith("f_rest_")).length;
  const shSize = rest / 3 + 1;
  if (![1, 4, 9, 16].includes(shSize)) {
    throw new Error(`the .ply file has ${rest} numbers f_rest_*: 0, 9, 24 or 45 were expected`);
  }
  const at = (/** @type {string} */ name) => /** @type {number} */ (offsets.get(name));
  const order = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"];
  order.push("opacity", "f_dc_0", "f_dc_1", "f_dc_2");
  // the file has all of red first, then green, then blue
  for (let k = 0; k + 1 < shSize; k++) {
    for (let c = 0; c < 3; c++) order.push(`f_rest_${c * (shSize - 1) + k}`);
  }
  const lost = order.find((name) => !offsets.has(name));
  if (lost) throw new Error(`the .ply file has ${rest} numbers f_rest_*, but not ${lost}`);
  const places = order.map(at);
  const scene = { ...roomFor(rows, shSize, footprint), up };
  const row = new Float32Array(places.length);
  for (let i = 0; i < rows; i++) {
    for (let k = 0; k < row.length; k++) row[k] = view.getFloat32(i * stride + places[k], true);
    addRow(scene, row);
  }
  const own = photoView(lines, view, rows * stride, scene);
  return withoutRoom({ ...scene, ...own, up: up ?? own?.up ?? null }, rows);
}

/**
 * The view of the photo from which Apple's SHARP made a scene: its camera is in elements after the vertices. As
 * `read_ply_camera` in mobilegs/formats/ply.py and `Start.from_camera`; null without a camera that sees the scene.
 *
 * @param {string[][]} lines words of the header's lines
 * @param {DataView} view the rows of the vertices, and what follows
 * @param {number} at where that begins
 * @param {SceneData} scene
 * @returns {{notes: Record<string, string>, up: Vector} | null}
 */
function photoView(lines, view, at, { count, shapes }) {
  const words = lines.filter(([kind]) => kind === "element" || kind === "property").slice(1);
  /** @type {Map<string, number[]>} */
  const values = new Map();
  for (let i = words.findIndex(([kind]) => kind === "element"); i > 0 && i + 1 < words.length; i += 2) {
    const [[kind, name, length], [next, type]] = [words[i], words[i + 1]];
    const size = (TYPES.get(type) ?? NaN) * Number(length);
    if (kind !== "element" || next !== "property" || !(at + size <= view.byteLength)) return null;
    const read = (/** @type {unknown} */ _, /** @type {number} */ k) =>
      type === "uint" ? view.getUint32(at + 4 * k, true) : view.getFloat32(at + 4 * k, true);
    if (size <= 64 && TYPES.get(type) === 4) values.set(name, Array.from({ length: size / 4 }, read));
    at += size;
  }
  const [viewmat, intrinsic, sides] = ["extrinsic", "intrinsic", "image_size"].map((name) => values.get(name) ?? []);
  if (viewmat.length !== 16 || intrinsic.length !== 9 || sides.length !== 2) return null;
  const [right, down, forward] = [0, 4, 8].map((k) => /** @type {Vector} */ (viewmat.slice(k, k + 3)));
  const [tx, ty, tz] = [viewmat[3], viewmat[7], viewmat[11]];
  const [x, y] = [sides[0] / (2 * intrinsic[0]), sides[1] / (2 * intrinsic[4])];
  const turned = cross(right, down).every((part, k) => Math.abs(part - forward[k]) < 1e-3);
  const level = [right, down].every((axis) => Math.abs(dot(axis, axis) - 1) < 1e-3) && Math.abs(dot(right, down)) < 1e-3;
  const depths = [];
  for (let i = 0; i < count; i++) {
    const mean = /** @type {Vector} */ ([shapes[12 * i + 3], shapes[12 * i + 7], shapes[12 * i + 11]]);
    const depth = dot(forward, mean) + tz;
    if (Math.abs(dot(right, mean) + tx) < x * depth && Math.abs(dot(down, mean) + ty) < y * depth) depths.push(depth);
  }
  const sized = sides.every((side) => side >= 1 && side <= SIDE_MAX) && [x, y].every((part) => part > 0 && part < 1e3);
  if (!turned || !level || !sized || !depths.length) return null;
  const middle = Float32Array.from(depths).sort()[(depths.length - 1) >> 1];
  const eye = right.map((_, k) => -(right[k] * tx + down[k] * ty + forward[k] * tz));
  const target = eye.map((part, k) => part + middle * forward[k]);
  const start = [...eye, ...target, BOX_SHARE * x, BOX_SHARE * y].map((part) => part.toFixed(6)).join(" ");
  return { notes: { start }, up: /** @type {Vector} */ (down.map((part) => -part)) };
}

/** A word of the file, for an error message. @param {string | undefined} word */
function quoted(word = "") {
  return `'${word.slice(0, 40).replace(/[^\x20-\x7e]/g, "\ufffd")}'`;
}

/** An empty sorted scene with memory for some Gaussians. @param {number} rows @param {number} shSize @param {Footprint} footprint @returns {SceneData} */
export function roomFor(rows, shSize, footprint) {
  return {
    count: 0,
    packing: null,
    shapes: new Float32Array(12 * rows),
    colors: new Float32Array(3 * shSize * rows),
    shSize,
    lobes: new Float32Array(2 * rows),
    lobeSize: 1,
    sorted: true,
    weighting: { index: 0, exponentMax: 4, sigma: 1, backgroundWeight: 0 },
    footprint,
    background: [0, 0, 0],
  };
}

/** Return a scene without the memory of the rows that were left out, and report how many. @param {SceneData} scene @param {number} rows of the file */
export function withoutRoom(scene, rows) {
  const { count, shSize } = scene;
  if (count === rows) return scene;
  if (count === 0) throw new Error("there is no Gaussian in this file that can be drawn");
  console.warn(`left out ${rows - count} of ${rows} Gaussians, which cannot be drawn`);
  scene.shapes = scene.shapes.slice(0, 12 * count);
  scene.colors = scene.colors.slice(0, 3 * shSize * count);
  scene.lobes = scene.lobes.slice(0, 2 * count);
  return scene;
}

/** As `Gaussians.can_be_drawn` in mobilegs/gaussians.py; a test compares the two. @param {Float32Array} row */
function canBeDrawn(row) {
  const square = row[6] * row[6] + row[7] * row[7] + row[8] * row[8] + row[9] * row[9];
  if (!(square > SQUARE_MIN && square < SQUARE_MAX && row[10] > -NUMBER_MAX)) return false;
  for (let k = 3; k < 6; k++) if (!(row[k] < LOG_SCALE_MAX)) return false;
  for (let k = 0; k < 3; k++) if (!(Math.abs(row[k]) < NUMBER_MAX)) return false;
  for (let k = 11; k < row.length; k++) if (!(Math.abs(row[k]) < NUMBER_MAX)) return false;
  return true;
}

/** Add a Gaussian if it can be drawn. @param {SceneData} scene @param {Float32Array} row mean, log-scales, rotation, logit, harmonics */
export function addRow(scene, row) {
  if (!canBeDrawn(row)) return;
  // other tools write infinities for opacities of 1 and scales of 0
  if (row[10] > NUMBER_MAX) row[10] = LOGIT_MAX;
  for (let k = 3; k < 6; k++) if (row[k] < -NUMBER_MAX) row[k] = LOG_SCALE_MIN;
  const [w, x, y, z] = [row[6], row[7], row[8], row[9]];
  const s = 2 / (w * w + x * x + y * y + z * z);
  const [a, b, c] = [Math.exp(row[3]), Math.exp(row[4]), Math.exp(row[5])];
  const i = scene.count++;
  scene.shapes.set(
    [
      a * (1 - s * (y * y + z * z)), a * s * (x * y + w * z), a * s * (x * z - w * y), row[0],
      b * s * (x * y - w * z), b * (1 - s * (x * x + z * z)), b * s * (y * z + w * x), row[1],
      c * s * (x * z + w * y), c * s * (y * z - w * x), c * (1 - s * (x * x + y * y)), row[2],
    ],
    12 * i,
  ); // prettier-ignore
  scene.lobes[2 * i] = row[10] / C0;
  scene.colors.set(row.subarray(11), 3 * scene.shSize * i);
}

/**
 * @param {Uint8Array} bytes
 * @returns {{offsets: Map<string, number>, stride: number, rows: number, start: number, footprint: Footprint,
 *   up: Vector | null, lines: string[][]}}
 */
function parseHeader(bytes) {
  const text = new TextDecoder("latin1").decode(bytes.subarray(0, HEADER_MAX));
  const end = /\nend_header\r?\n/.exec(text);
  if (!isPly(bytes) || end === null) throw new Error("this is not a PLY file, or its header is cut off");
  const lines = text.slice(0, end.index).split(/\r?\n/).map((line) => line.trim().split(/\s+/));
  const format = lines.find((words) => words[0] === "format")?.[1];
  if (format !== "binary_little_endian") {
    throw new Error(`the .ply file is ${quoted(format)}: only binary_little_endian is read`);
  }
  const first = lines.findIndex((words) => words[0] === "element");
  const element = lines[first] ?? [];
  const rows = /^\d+$/.test(element[2]) ? Number(element[2]) : NaN;
  if (element[1] !== "vertex" || !Number.isSafeInteger(rows) || rows < 0) {
    throw new Error("the .ply file does not begin with its vertices, as those of 3DGS do");
  }
  const offsets = new Map();
  let stride = 0;
  for (const words of lines.slice(first + 1)) {
    if (words[0] === "element") break;
    if (words[0] !== "property") continue;
    const size = TYPES.get(words[1]);
    if (size === undefined) throw new Error(`the .ply file has a property of type ${quoted(words[1])}`);
    if (words.length !== 3) throw new Error("the .ply file has a property without a name, or with two");
    if (offsets.has(words[2])) throw new Error(`the .ply file has the property ${quoted(words[2])} twice`);
    if (words[1] === "float" || words[1] === "float32") offsets.set(words[2], stride);
    stride += size;
  }
  const missing = NEEDED.filter((name) => !offsets.has(name));
  if (missing.length) {
    throw new Error(`the .ply file is not a Gaussian scene: it lacks ${missing.join(", ")} as floats`);
  }
  const start = end.index + end[0].length;
  if (start + rows * stride > bytes.length) {
    throw new Error(`the .ply file is cut off: ${rows} Gaussians were announced`);
  }
  return { offsets, stride, rows, start, footprint: footprintOf(lines), up: upOf(lines), lines };
}

/**
 * The footprint that a header's comments name: `SplatRenderMode: mip` or Postshot's words for antialiased
 * Gaussians, `mobilegs blur` for another blur; as mobilegs/formats/ply.py.
 *
 * @param {string[][]} lines words of the header's lines
 * @returns {Footprint}
 */
function footprintOf(lines) {
  const found = { ...CLASSIC };
  for (const [kind, ...words] of lines) {
    if (kind !== "comment") continue;
    const comment = words.join(" ");
    if (words[0] === "SplatRenderMode:") found.antialiased = words[1]?.toLowerCase() === "mip";
    else if (comment === "antialiased 1" || comment === "postshot.anti_aliasing=1") found.antialiased = true;
    else if (words.length === 3 && comment.startsWith("mobilegs blur ")) {
      found.blur = /^\d*\.?\d+$/.test(words[2]) ? Number(words[2]) : NaN;
    }
  }
  if (!(found.blur > 0 && found.blur <= 4)) {
    throw new Error("the .ply file names a blur that is not possible: above 0 and at most 4 is");
  }
  return found;
}

/**
 * The upward direction that a header's comments name, length 1, or null: nerfstudio's `Vertical Axis: z`, Brush's
 * `Vertical axis: y` for -y, or `mobilegs up X Y Z`; as mobilegs/formats/ply.py.
 *
 * @param {string[][]} lines words of the header's lines
 * @returns {Vector | null}
 */
function upOf(lines) {
  let found = null;
  for (const line of lines) {
    const [kind, first, second, ...rest] = line.map((word) => word.toLowerCase());
    if (kind !== "comment") continue;
    if (first === "vertical" && second === "axis:" && rest.length === 1) found = VERTICAL_AXES.get(rest[0]) ?? found;
    if (first === "mobilegs" && second === "up") found = parsedUp(rest.join(" ")) ?? found;
  }
  return found;
}
