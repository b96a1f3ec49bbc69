/**
 * `.mgs` files: bytes to a scene, whole or while they arrive. docs/format.md is the specification.
 *
 *     const reader = new SceneReader();
 *     for each piece of the file:
 *       reader.append(piece);  // reader.header is there as soon as it can be
 *       while (reader.step());
 *     reader.end();
 *     const { decoderInputs, levels } = reader.decoder;
 *     for each level:
 *       new GaussianDecoder(decoderInputs).decode(level.rows(0, level.count));  // the first block of them
 *
 * A step takes some milliseconds; between two of them a caller may do something else. As soon as
 * a level has `positions`, its Gaussians can be drawn: what has not come yet is neutral.
 */

import { StreamDecoder } from "./stream_decoder.js";
import { ContainerReader } from "./container.js";
import { parseHeader } from "./header.js";

/** @typedef {import("./header.js").Header} Header */

/** Reads a file in pieces. */
export class SceneReader {
  /** What the file says about itself, once that is complete. @type {Header | null} */
  header = null;
  /** What makes codes of its streams, from then on. @type {StreamDecoder | null} */
  decoder = null;

  #container = new ContainerReader();

  /** Bytes that have arrived. */
  get received() {
    return this.#container.received;
  }

  /** Bytes of the whole file; Infinity as long as the header is not known. */
  get total() {
    return this.#container.total;
  }

  /**
   * Takes in the next bytes of the file, which the caller must not change afterwards.
   *
   * @param {Uint8Array} piece
   */
  append(piece) {
    const streams = this.#container.append(piece);
    const { fields, table, total } = this.#container;
    if (fields !== null && this.decoder === null) {
      this.header = parseHeader(fields, total);
      this.decoder = new StreamDecoder(this.header, table);
    }
    for (const stream of streams) this.decoder?.accept(stream);
  }

  /** To be called behind the last piece: throws if something is missing. */
  end() {
    this.#container.end();
  }

  /**
   * Decodes the next stream of which all bytes are there.
   *
   * @returns {boolean} false: there is nothing to do before more bytes come
   */
  step() {
    return this.decoder?.step(this.received) ?? false;
  }
}

/**
 * Reads a file from a stream, such as the body of a response.
 *
 * @param {ReadableStream<Uint8Array>} source
 * @param {(reader: SceneReader, waited: number) => void | Promise<void>} onStep called behind every
 *     piece and every step, and waited for; told how many milliseconds the bytes took, apart from
 *     everything else
 * @returns {Promise<SceneReader>} with everything
 */
export async function readScene(source, onStep) {
  const reader = new SceneReader();
  const pieces = source.getReader();
  try {
    for (let waited = 0; ; ) {
      waited -= performance.now();
      const { value, done } = await pieces.read();
      waited += performance.now();
      if (done) break;
      reader.append(value);
      do await onStep(reader, waited);
      while (reader.step());
    }
  } catch (error) {
    // the first thing that went wrong is the one to tell
    await pieces.cancel().catch(() => {});
    throw error;
  }
  reader.end();
  return reader;
}
