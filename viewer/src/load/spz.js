/**
 * Reads 3DGS scenes in Niantic's `.spz`, which are rendered sorted.
 *
 * Versions 1 to 3 are one gzip stream: a header, then all positions, all opacities, and so on.
 * Version 4 has its header in plain, and a Zstandard stream for each of these attributes. Axes are
 * RUB (y up, z backwards), ours RDF. The specification is github.com/nianticlabs/spz.
 */

import { fromFloat16 } from "../mgs/float16.js";
import { CLASSIC } from "../mgs/header.js";
import { addRow, roomFor, withoutRoom } from "./ply.js";
import { decompressZstd } from "./zstd.js";

/** @typedef {import("../render/types.js").SceneData} SceneData */
/**
 * @typedef {object} Header
 * @property {number} version
 * @property {number} count Gaussians
 * @property {number} degree of the harmonics
 * @property {number} fraction bits behind the point of positions
 * @property {boolean} antialiased whether alpha is compensated for the blur
 * @property {boolean} extended whether something follows that only some tools know
 * @property {number} streams of version 4
 * @property {number} table where version 4 says how long its streams are
 */
/** The stored attributes: positions, opacities, colours, scales, rotations, harmonics. @typedef {Uint8Array[]} Attributes */

const MAGIC = 0x5053474e; // "NGSP"
const COUNT_MAX = 1e7; // as the format's own readers had it
const HEADER = 16; // bytes in version 1 to 3
const HEADER_4 = 32;
const COEFFICIENTS = [0, 3, 8, 15, 24]; // of a colour, by degree, without the constant
const KEPT = 15; // of those; degree 4 is not drawn
const COLOR = 0.15; // of the constant coefficient in a byte's range
// of harmonics when y and z change their signs: the parity of each
const SIGNS = [-1, -1, 1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1, 1];
const DAMAGED = "the .spz file is damaged or cut off";

/**
 * The scene of a whole file.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @returns {Promise<SceneData>}
 */
export async function readSpz(bytes) {
  if (bytes[0] !== 0x1f) {
    const header = parseHeader(bytes, bytes.length);
    return sceneOf(header, unpacked(header, bytes));
  }
  const { header, content } = await gunzipped(bytes);
  const attributes = [];
  let at = HEADER;
  for (const size of sizesOf(header)) attributes.push(content.subarray(at, (at += size)));
  return sceneOf(header, attributes);
}

/** @param {Uint8Array} bytes at least the header @param {number} size bytes of the file @returns {Header} */
function parseHeader(bytes, size) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < HEADER || view.getUint32(0, true) !== MAGIC) throw new Error("this is not a .spz file");
  const version = view.getUint32(4, true);
  const zipped = version < 4;
  if (version < 1 || version > 4) {
    throw new Error(`the .spz file has version ${version}: 1 to 4 are read`);
  }
  if (!zipped && bytes.length < HEADER_4) throw new Error(DAMAGED);
  const count = view.getUint32(8, true);
  const [degree, fraction, flags, streams] = bytes.subarray(12, 16);
  if (count > COUNT_MAX) throw new Error(`the .spz file announces ${count} Gaussians, too many to be drawn`);
  // real scenes are far below this; a small file must not allocate much memory
  if (count > size) throw new Error(`the .spz file announces ${count} Gaussians in ${size} bytes: it is cut off`);
  if (degree > 4 || fraction > 24) throw new Error(DAMAGED);
  const [antialiased, extended] = [(flags & 1) !== 0, (flags & 2) !== 0];
  return { version, count, degree, fraction, antialiased, extended, streams, table: zipped ? 0 : view.getUint32(16, true) };
}

/** Bytes of each attribute. @param {Header} header */
function sizesOf({ version, count, degree }) {
  return [version === 1 ? 6 : 9, 1, 3, 3, version < 3 ? 3 : 4, 3 * COEFFICIENTS[degree]].map(
    (size) => size * count,
  );
}

/**
 * Decompress no more than the header announces.
 *
 * @param {Uint8Array<ArrayBuffer>} bytes
 * @returns {Promise<{header: Header, content: Uint8Array}>}
 */
async function gunzipped(bytes) {
  const body = /** @type {ReadableStream<Uint8Array<ArrayBuffer>>} */ (new Response(bytes).body);
  const reader = body.pipeThrough(new DecompressionStream("gzip")).getReader();
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const pieces = [];
  let length = 0;
  /** @type {Header | null} */
  let header = null;
  let size = Infinity;
  const whole = async () => new Uint8Array(await new Blob(pieces).arrayBuffer());
  while (length <= size) {
    const { value, done } = await reader.read().catch(() => {
      throw new Error(DAMAGED);
    });
    if (done) break;
    pieces.push(value);
    length += value.length;
    if (header === null && length >= HEADER) {
      header = parseHeader(await whole(), bytes.length);
      if (header.version > 3) throw new Error("this is not a .spz file");
      size = sizesOf(header).reduce((sum, part) => sum + part, HEADER);
    }
  }
  if (header === null) throw new Error("this is not a .spz file");
  if (length > size) {
    // errors after the content do not matter
    await reader.cancel().catch(() => {});
    if (!header.extended) throw new Error("the .spz file holds more than it announces");
  }
  if (length < size) throw new Error(`the .spz file is cut off: ${header.count} Gaussians were announced`);
  return { header, content: await whole() };
}

/** The streams of version 4. @param {Header} header @param {Uint8Array} bytes @returns {Attributes} */
function unpacked(header, bytes) {
  const { streams, table, version } = header;
  const sizes = sizesOf(header);
  const end = table + 16 * streams;
  const sent = sizes.filter((size) => size > 0).length; // empty attributes have no stream
  if (version !== 4 || table < HEADER_4 || end > bytes.length || streams !== sent) throw new Error(DAMAGED);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let [entry, at] = [table, end];
  return sizes.map((size) => {
    if (size === 0) return new Uint8Array(0);
    const length = Number(view.getBigUint64(entry, true));
    const announced = Number(view.getBigUint64(entry + 8, true));
    entry += 16;
    if (at + length > bytes.length || announced !== size) throw new Error(DAMAGED);
    const stream = bytes.subarray(at, (at += length));
    try {
      return decompressZstd(stream, size);
    } catch (error) {
      throw new Error(`${DAMAGED}: ${error instanceof Error ? error.message : error}`);
    }
  });
}

/** @param {Header} header @param {Attributes} attributes @returns {SceneData} */
function sceneOf({ version, count, degree, fraction, antialiased }, attributes) {
  const [positions, opacities, colors, scales, rotations, harmonics] = attributes;
  const sent = COEFFICIENTS[degree];
  const kept = Math.min(sent, KEPT);
  const shSize = kept + 1;
  const scene = roomFor(count, shSize, { ...CLASSIC, antialiased });
  const row = new Float32Array(11 + 3 * shSize);
  const place = version === 1 ? halfAt(positions) : fixedAt(positions, 2 ** -fraction);
  const turn = version < 3 ? firstThree : smallestThree;
  for (let i = 0; i < count; i++) {
    row[0] = place(3 * i);
    row[1] = -place(3 * i + 1);
    row[2] = -place(3 * i + 2);
    for (let k = 0; k < 3; k++) row[3 + k] = scales[3 * i + k] / 16 - 10;
    turn(rotations, i, row);
    // 0 and 255 are no logits; both stay as good as invisible and opaque
    const opacity = Math.min(Math.max(opacities[i] / 255, 1e-6), 1 - 1e-6);
    row[10] = Math.log(opacity / (1 - opacity));
    for (let k = 0; k < 3; k++) row[11 + k] = (colors[3 * i + k] / 255 - 0.5) / COLOR;
    for (let k = 0; k < kept; k++) {
      for (let c = 0; c < 3; c++) {
        row[14 + 3 * k + c] = (SIGNS[k] * (harmonics[3 * (sent * i + k) + c] - 128)) / 128;
      }
    }
    addRow(scene, row);
  }
  return withoutRoom(scene, count);
}

/** 24-bit integers. @param {Uint8Array} bytes @param {number} unit @returns {(index: number) => number} */
function fixedAt(bytes, unit) {
  return (index) => {
    const at = 3 * index;
    return unit * (((bytes[at] << 8) | (bytes[at + 1] << 16) | (bytes[at + 2] << 24)) >> 8);
  };
}

/** Half floats. @param {Uint8Array} bytes @returns {(index: number) => number} */
function halfAt(bytes) {
  return (index) => fromFloat16(bytes[2 * index] | (bytes[2 * index + 1] << 8));
}

/** Versions 1 and 2: x, y, z; w follows, as it is not negative. @param {Uint8Array} bytes @param {number} i @param {Float32Array} row */
function firstThree(bytes, i, row) {
  const [x, y, z] = [0, 1, 2].map((k) => bytes[3 * i + k] / 127.5 - 1);
  const w = Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z));
  row.set([w, x, -y, -z], 6);
}

/** From version 3 on: which of x, y, z, w is largest, and the others as signs and nine bits. @param {Uint8Array} bytes @param {number} i @param {Float32Array} row */
function smallestThree(bytes, i, row) {
  const at = 4 * i;
  const word = bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24);
  const largest = word >>> 30;
  const parts = [0, 0, 0, 0];
  let left = 1;
  for (let k = 0, shift = 20; k < 4; k++) {
    if (k === largest) continue;
    const size = (((word >> shift) & 511) / 511) * Math.SQRT1_2;
    parts[k] = (word >> (shift + 9)) & 1 ? -size : size;
    left -= size * size;
    shift -= 10;
  }
  parts[largest] = Math.sqrt(Math.max(0, left));
  row.set([parts[3], parts[0], -parts[1], -parts[2]], 6);
}
