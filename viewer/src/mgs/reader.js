/**
 * Reads `.mgs` files, whole or while they arrive. docs/reference/format.md is the specification.
 *
 *     const reader = new SceneReader();
 *     for each piece of the file:
 *       reader.append(piece);  // sets reader.header once it is complete
 *       while (reader.step());
 *     reader.end();
 *     const { decoderInputs, levels } = reader.decoder;
 *     for each level:
 *       new GaussianDecoder(decoderInputs).decode(level.rows(0, level.count));  // the first block of them
 *
 * A step takes some milliseconds. A level can be rendered once it has `positions`: missing attributes have
 * neutral values.
 */

import { StreamDecoder } from "./stream_decoder.js";
import { ContainerReader } from "./container.js";
import { parseHeader } from "./header.js";

/** @typedef {import("./header.js").Header} Header */

/** Reads a file in pieces. */
export class SceneReader {
  /** The header, once it is complete. @type {Header | null} */
  header = null;
  /** The decoder of its streams, once the header is complete. @type {StreamDecoder | null} */
  decoder = null;

  #container = new ContainerReader();

  /** Bytes received. */
  get received() {
    return this.#container.received;
  }

  /** Bytes of the whole file; Infinity before the header is complete. */
  get total() {
    return this.#container.total;
  }

  /**
   * Add the next bytes of the file, which the caller must not change afterwards.
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

  /** Call after the last piece: throws a SceneError if bytes are missing. */
  end() {
    this.#container.end();
  }

  /**
   * Decode the next complete stream.
   *
   * @returns {boolean} false: more bytes are needed first
   */
  step() {
    return this.decoder?.step(this.received) ?? false;
  }
}

/**
 * Read a file from a stream, such as the body of a response.
 *
 * @param {ReadableStream<Uint8Array>} source
 * @param {(reader: SceneReader, waited: number) => void | Promise<void>} onStep called and awaited
 *     after every piece and every step; `waited` is the total time spent waiting for bytes, milliseconds
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
    // report the first error, not one of the cancellation
    await pieces.cancel().catch(() => {});
    throw error;
  }
  reader.end();
  return reader;
}
