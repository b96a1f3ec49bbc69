/** The worker that parses a file of another format than `.mgs`. */

import { buffersOf } from "../render/pack.js";
import { isPly } from "./file_kind.js";
import { readPly } from "./ply.js";
import { readSpz } from "./spz.js";

/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {{scene: SceneData} | {failed: string, memory: boolean}} Parsed memory: there was too little */

self.onmessage = async ({ data: bytes }) => {
  try {
    const scene = await (isPly(bytes) ? readPly : readSpz)(bytes);
    self.postMessage({ scene }, { transfer: buffersOf(scene) });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    // browsers throw a RangeError where memory is short
    self.postMessage({ failed: message, memory: error instanceof RangeError });
  }
};
