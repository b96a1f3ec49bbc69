/** Decodes a stream of bytes to arrays; the worker of the npm package contains it. */

import { yieldToMessages } from "../load/yield_to_messages.js";
import { BLOCK } from "../mgs/block_memory.js";
import { GaussianDecoder } from "../mgs/gaussian_decoder.js";
import { C0 } from "../mgs/lobes.js";
import { toWorld } from "../mgs/positions.js";
import { readScene } from "../mgs/reader.js";
import { parsedUp } from "../viewer/up.js";

/** @typedef {import("./decode.js").MgsProgress} MgsProgress */
/** @typedef {import("./decode.js").MgsScene} MgsScene */

/**
 * Decode a `.mgs`, beginning with its first bytes. Other tasks can run every few milliseconds.
 *
 * @param {ReadableStream<Uint8Array>} stream
 * @param {(progress: MgsProgress) => void} [onProgress]
 * @param {AbortSignal} [signal]
 * @returns {Promise<MgsScene>}
 */
export async function decodeStream(stream, onProgress, signal) {
  const pauses = async () => {
    await yieldToMessages();
    signal?.throwIfAborted();
  };
  let before = -1;
  const reader = await readScene(stream, async ({ received, total }) => {
    if (received !== before) onProgress?.({ received, total: Number.isFinite(total) ? total : NaN });
    before = received;
    await pauses();
  });
  return sceneOf(reader, pauses);
}

/**
 * @param {import("../mgs/reader.js").SceneReader} reader with the whole file
 * @param {() => Promise<void>} pauses
 * @returns {Promise<MgsScene>}
 */
async function sceneOf(reader, pauses) {
  const header = /** @type {import("../mgs/header.js").Header} */ (reader.header);
  const { levels, decoderInputs, network } = /** @type {import("../mgs/stream_decoder.js").StreamDecoder} */ (reader.decoder);
  const { count } = header;
  const decoder = new GaussianDecoder(decoderInputs);
  const pairs = 2 * (decoder.lobeDegree + 1) ** 2;
  const lobes = new Float32Array(pairs * count);
  const scene = {
    means: new Float32Array(3 * count),
    quats: new Float32Array(4 * count),
    scales: new Float32Array(3 * count),
    sh: new Float32Array(12 * count),
  };
  let at = 0;
  for (const level of levels) {
    const rows = level.rows(0, level.count, "subarray");
    scene.means.set(toWorld(rows.positions, header.grid), 3 * at);
    for (let from = 0; from < level.count; from += BLOCK) {
      const block = decoder.decode(rows, from);
      toRows(block.quats, 4, block.count, scene.quats, at + from);
      toRows(block.scales, 3, block.count, scene.scales, at + from);
      toRows(block.sh, 12, block.count, scene.sh, at + from);
      toRows(block.lobes, pairs, block.count, lobes, at + from);
      await pauses();
    }
    at += level.count;
  }
  const { lodSizes, sorted, views, meta, weighting, footprint, background, near } = header;
  return {
    count,
    ...scene,
    opacities: Float32Array.from({ length: count }, (_, i) => 1 / (1 + Math.exp(-C0 * lobes[pairs * i]))),
    lobes: header.lobes && lobes,
    lobeDegree: decoder.lobeDegree,
    levels: lodSizes,
    blend: sorted ? "sorted" : "sortfree",
    weighting,
    footprint,
    network,
    background,
    near,
    cameras: views,
    up: parsedUp(meta.up),
    notes: meta,
  };
}

/**
 * Copy columns of a block to rows.
 *
 * @param {Float32Array} columns
 * @param {number} width columns
 * @param {number} count rows
 * @param {Float32Array} rows
 * @param {number} first of the rows
 */
function toRows(columns, width, count, rows, first) {
  for (let column = 0; column < width; column++) {
    for (let row = 0; row < count; row++) rows[(first + row) * width + column] = columns[column * BLOCK + row];
  }
}
