/**
 * The container of a `.mgs`, read while it arrives: magic, version, header and streams with checksums.
 * docs/reference/format.md, section 1.
 */

import { view } from "./bits.js";
import { crc32 } from "./crc32.js";
import { SceneError } from "./error.js";
import { CLASSIC, shortText } from "./header.js";

/** @typedef {{ name: string, codec: string, data: Uint8Array }} Stream a piece of the file */
/** @typedef {{ name: string, codec: string, bytes: number, crc32: number }} Row of the table */

const MAGIC = [0x4d, 0x47, 0x53, 0x1a, 0x0d, 0x0a, 0x00, 0x01];
const MAJORS = [2, 3, 4];
// bytes before the header
const PREFIX = 20;
const HEADER_MAX = 2 ** 20;
const STREAMS_MAX = 256;
const FILE_MAX = 2 ** 32;
/** @type {[string, string][]} */
const FOREIGN = [
  ["ply", "a PLY scene: train or compress it first"],
  ["PK\x03\x04", "a zip archive (perhaps .sog)"],
  ["\x1f\x8b", "a gzip file (perhaps .spz)"],
  ["NGSP", "an .spz scene"],
  ["glTF", "a binary glTF file"],
  ["\xfd7zXZ", "an xz file (perhaps another program's comp.xz)"],
  ["\x89PNG", "a PNG picture"],
  ["\xff\xd8\xff", "a JPEG picture"],
  ["<", "a web page"],
  ["{", "a JSON text"],
];

/** Splits a file that arrives in pieces into its header and its streams. */
export class ContainerReader {
  /** Bytes received. */
  received = 0;
  /** Bytes of the whole file; Infinity before the header is complete. */
  total = Infinity;
  /** The header's fields, once it is complete. @type {Record<string, unknown> | null} */
  fields = null;
  /** The table of streams; empty before the header is complete. @type {Row[]} */
  table = [];

  /** @type {Uint8Array[]} */
  #pieces = [];
  // bytes in #pieces
  #waiting = 0;
  // row of the table
  #next = 0;
  #magic = false;
  /** Bytes 8 to 19, once they are received. @type {Uint8Array | null} */
  #prefix = null;

  /**
   * Add the next bytes of the file; returns the streams that they complete.
   *
   * The pieces are kept, not copied: the caller must not change them afterwards.
   *
   * @param {Uint8Array} piece
   * @returns {Stream[]}
   */
  append(piece) {
    if (piece.length > 0) this.#pieces.push(piece);
    this.received += piece.length;
    this.#waiting += piece.length;
    if (!this.#readHeader()) return [];
    if (this.received > this.total) {
      throw new SceneError(
        `the .mgs file has ${this.received - this.total} bytes too many at its end`,
      );
    }
    const streams = [];
    for (let row; (row = this.table[this.#next]) && padded(row.bytes) <= this.#waiting; ) {
      this.#next++;
      streams.push(checked(row, this.#take(padded(row.bytes))));
    }
    return streams;
  }

  /** Call after the last piece: throws a SceneError if bytes are missing. */
  end() {
    if (this.fields !== null) {
      const row = this.table[this.#next];
      if (row === undefined) return;
      throw new SceneError(
        `the .mgs file ends inside its stream '${row.name}': it has been cut short`,
      );
    }
    if (!this.#magic) throw new SceneError(notOurs(this.#take(this.#waiting)));
    const where = this.#prefix === null ? "first bytes" : "header";
    throw new SceneError(`the .mgs file ends inside its ${where}: it has been cut short`);
  }

  /** Read the header as far as possible; returns whether it is complete. */
  #readHeader() {
    if (!this.#magic && this.#waiting >= MAGIC.length) {
      const start = this.#take(MAGIC.length);
      if (MAGIC.some((byte, i) => byte !== start[i])) throw new SceneError(notOurs(start));
      this.#magic = true;
    }
    if (this.#magic && this.#prefix === null && this.#waiting >= PREFIX - MAGIC.length) {
      this.#prefix = this.#take(PREFIX - MAGIC.length);
    }
    if (this.#prefix !== null && this.fields === null) {
      const length = headerLength(this.#prefix);
      if (this.#waiting >= length) this.#open(this.#prefix, this.#take(length));
    }
    return this.fields !== null;
  }

  /**
   * @param {Uint8Array} prefix
   * @param {Uint8Array} text
   */
  #open(prefix, text) {
    const checksum = view(prefix).getUint32(8, true);
    if ((PREFIX + text.length) % 8 || crc32(text, crc32(prefix.subarray(0, 8))) !== checksum) {
      throw new SceneError("the header of the .mgs file is damaged (wrong checksum)");
    }
    this.fields = parseObject(text);
    const major = view(prefix).getUint16(0, true);
    // a file without LOD levels has one
    if (major === 2 || (major === 4 && this.fields.layers === undefined)) {
      this.fields.layers = [this.fields.count];
    }
    if (major < 4) this.fields.footprint = CLASSIC;
    this.table = parseTable(this.fields.streams);
    this.total = this.table.reduce((sum, row) => sum + padded(row.bytes), PREFIX + text.length);
    if (this.total > FILE_MAX) {
      throw new SceneError(`the .mgs file claims ${this.total} bytes, too many for a scene`);
    }
  }

  /** The next `length` bytes as one array. @param {number} length */
  #take(length) {
    this.#waiting -= length;
    const first = this.#pieces[0];
    if (first !== undefined && first.length > length) {
      this.#pieces[0] = first.subarray(length);
      return first.subarray(0, length);
    }
    const taken = new Uint8Array(length);
    let filled = 0;
    let used = 0;
    while (filled < length) {
      const piece = this.#pieces[used];
      const part = piece.subarray(0, length - filled);
      taken.set(part, filled);
      filled += part.length;
      if (part.length < piece.length) this.#pieces[used] = piece.subarray(part.length);
      else used++;
    }
    this.#pieces.splice(0, used);
    return taken;
  }
}

/** @param {number} bytes */
function padded(bytes) {
  return Math.ceil(bytes / 8) * 8;
}

/**
 * @param {Row} row
 * @param {Uint8Array} bytes the stream and its padding
 * @returns {Stream}
 */
function checked(row, bytes) {
  const data = bytes.subarray(0, row.bytes);
  if (crc32(data) !== row.crc32) {
    throw new SceneError(`the stream '${row.name}' of the .mgs file is damaged (wrong checksum)`);
  }
  if (bytes.subarray(row.bytes).some((byte) => byte !== 0)) {
    throw new SceneError(`the .mgs file is damaged after its stream '${row.name}'`);
  }
  return { name: row.name, codec: row.codec, data };
}

/** Check the version and return the bytes of the header. @param {Uint8Array} prefix */
function headerLength(prefix) {
  const numbers = view(prefix);
  const major = numbers.getUint16(0, true);
  const length = numbers.getUint32(4, true);
  if (!MAJORS.includes(major)) {
    throw new SceneError(
      `the .mgs file is of version ${major}.${numbers.getUint16(2, true)}, this program reads ` +
        `${MAJORS[0]}.x to ${MAJORS[2]}.x: reload the page, or write the file again with this version of mobilegs`,
    );
  }
  if (length > HEADER_MAX) {
    throw new SceneError(`the header of the .mgs file claims ${length} bytes: it is damaged`);
  }
  return length;
}

/**
 * @param {Uint8Array} text
 * @returns {Record<string, unknown>}
 */
function parseObject(text) {
  let value;
  try {
    value = JSON.parse(new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(text));
  } catch {
    throw new SceneError("the header of the .mgs file is not valid JSON");
  }
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw new SceneError("the header of the .mgs file is not a JSON object");
  }
  return value;
}

/**
 * @param {unknown} rows
 * @returns {Row[]}
 */
function parseTable(rows) {
  if (!Array.isArray(rows) || rows.length > STREAMS_MAX) {
    throw new SceneError("the header of the .mgs file lacks a table of streams");
  }
  const names = new Set();
  return rows.map((row) => {
    const { name, codec, bytes, crc32: checksum } = Object(row);
    const sound =
      [name, codec].every((text) => shortText(text, 64)) &&
      [bytes, checksum].every((n) => Number.isInteger(n) && n >= 0 && n < 2 ** 40);
    if (!sound) throw new SceneError("the header of the .mgs file has a broken table of streams");
    if (names.has(name)) {
      throw new SceneError(`the .mgs file has two streams called '${name}'`);
    }
    names.add(name);
    return { name, codec, bytes, crc32: checksum };
  });
}

/** The error message for a file of another format. @param {Uint8Array} start */
function notOurs(start) {
  if (start.length === 0) return "the file is empty, not a .mgs scene";
  const same = MAGIC.findIndex((byte, i) => byte !== start[i]);
  if (same >= Math.min(3, start.length)) {
    return "the first bytes of the .mgs file are damaged: transfer it again, in binary mode";
  }
  const text = String.fromCharCode(...start);
  const found = FOREIGN.find(([sign]) => text.startsWith(sign));
  if (found) return `this is not a .mgs scene but looks like ${found[1]}`;
  return "this is not a .mgs scene";
}
