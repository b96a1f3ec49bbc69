/**
 * Milliseconds from the bytes of a .mgs to the words that GPUs take, by the viewer's code in one
 * thread of node: for several times in a process, of which the first has everything to compile.
 *
 *     node bench/decoding.mjs scene.mgs [times]
 */

import { readFileSync } from "node:fs";

import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { GaussianDecoder } from "../../viewer/src/mgs/gaussian_decoder.js";
import { packRows } from "../../viewer/src/render/pack.js";

const PIECE = 2 ** 16; // bytes that a network brings at a time
const CHUNK = 8192; // Gaussians, as load/worker_pool.js has it

const [, , path, times = "5"] = process.argv;
const bytes = new Uint8Array(readFileSync(path));

/** @returns {number} */
function opened() {
  const started = performance.now();
  const reader = new SceneReader();
  for (let at = 0; at < bytes.length; at += PIECE) {
    reader.append(bytes.slice(at, at + PIECE));
    while (reader.step());
  }
  reader.end();
  const { decoder } = reader;
  if (decoder === null) throw new Error("there is no scene in this file");
  const own = new GaussianDecoder(decoder.decoderInputs);
  for (const level of decoder.levels) {
    for (let from = 0; from < level.count; from += CHUNK) {
      packRows(own, level.rows(from, Math.min(from + CHUNK, level.count), "subarray"));
    }
  }
  return performance.now() - started;
}

console.log(JSON.stringify(Array.from({ length: Number(times) }, opened)));
