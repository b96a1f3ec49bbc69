/**
 * `.mgs` files: bytes to a scene, whole or while they arrive. docs/format.md is the specification.
 *
 *     const reader = new SceneReader();
 *     for each piece of the file:
 *       reader.append(piece);  // reader.header is there as soon as it can be
 *       for (let update; (update = reader.step()); ) draw(reader.scene, update);
 *     reader.end();
 *
 * A step takes some milliseconds; between two of them a caller may do something else. As soon as
 * there is a `reader.scene` it can be drawn: what has not come yet is neutral.
 */

import { Decoder } from "./decode.js";
import { Envelope } from "./envelope.js";
import { parseHeader } from "./header.js";

/** @typedef {import("./decode.js").Update} Update */
/** @typedef {import("./header.js").Header} Header */
/** @typedef {import("./scene.js").Part} Part */
/** @typedef {import("./scene.js").Scene} Scene */

/** Reads a file in pieces. */
export class SceneReader {
  /** What the file says about itself, once that is complete. @type {Header | null} */
  header = null;

  #envelope = new Envelope();
  /** @type {Decoder | null} */
  #decoder = null;

  /** The scene, once its positions are known. @returns {Scene | null} */
  get scene() {
    return this.#decoder?.scene ?? null;
  }

  /** Bytes that have arrived. */
  get received() {
    return this.#envelope.received;
  }

  /** Bytes of the whole file; Infinity as long as the header is not known. */
  get total() {
    return this.#envelope.total;
  }

  /** Whether everything is there and decoded. */
  get complete() {
    return this.received === this.total && this.#decoder !== null && this.#decoder.complete;
  }

  /** Whether a part of the scene is what it will be. @param {Part} part */
  has(part) {
    return this.#decoder !== null && this.#decoder.has(part);
  }

  /**
   * Takes in the next bytes of the file, which the caller must not change afterwards.
   *
   * @param {Uint8Array} piece
   */
  append(piece) {
    const streams = this.#envelope.append(piece);
    const { fields, table, total } = this.#envelope;
    if (fields !== null && this.#decoder === null) {
      this.header = parseHeader(fields, total);
      this.#decoder = new Decoder(this.header, table);
    }
    for (const stream of streams) this.#decoder?.accept(stream);
  }

  /** To be called behind the last piece: throws if something is missing. */
  end() {
    this.#envelope.end();
  }

  /**
   * Does the next thing for which the bytes are there.
   *
   * @returns {Update | null} null: there is nothing to do before more bytes come
   */
  step() {
    if (this.header === null || this.#decoder === null) return null;
    // a claim alone gets no memory: a Gaussian takes a byte that has arrived, if not its own
    return this.#decoder.step(this.received >= this.header.count);
  }
}

/**
 * The scene in a whole file.
 *
 * @param {Uint8Array} bytes
 */
export function openScene(bytes) {
  const reader = new SceneReader();
  reader.append(bytes);
  return finished(reader);
}

/**
 * Reads a file from a stream, such as the body of a response.
 *
 * @param {ReadableStream<Uint8Array>} source
 * @param {(reader: SceneReader, update: Update) => void | Promise<void>} onUpdate called behind
 *     every step, and waited for
 */
export async function readScene(source, onUpdate) {
  const reader = new SceneReader();
  const pieces = source.getReader();
  try {
    for (let piece; !(piece = await pieces.read()).done; ) {
      reader.append(piece.value);
      for (let update; (update = reader.step()); ) await onUpdate(reader, update);
    }
  } catch (error) {
    await pieces.cancel().catch(() => {}); // the first thing that went wrong is the one to tell
    throw error;
  }
  return finished(reader);
}

/** @param {SceneReader} reader */
function finished(reader) {
  reader.end();
  while (reader.step());
  const { header, scene } = reader;
  if (header === null || scene === null) throw new Error("a whole file gave no scene");
  return { header, scene };
}
