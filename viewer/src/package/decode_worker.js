/** The worker of the package, which loads scenes and decodes for `decodeMgs`; in Node.js its script becomes a module. */

import { receive } from "../load/worker.js";
import { SceneError } from "../mgs/error.js";
import { decodeStream } from "./decode_stream.js";

export { decodeStream };

/** The file that is being decoded. @type {ReadableStreamDefaultController<Uint8Array> | null} */
let file = null;

/** Take the next bytes of a file to decode; null ends it. @param {Uint8Array | null} piece */
function take(piece) {
  if (!file) void decode(new ReadableStream({ start: (controller) => void (file = controller) }));
  if (piece) file?.enqueue(piece);
  else file?.close();
}

/** @param {ReadableStream<Uint8Array>} stream */
async function decode(stream) {
  try {
    const scene = await decodeStream(stream, (progress) => self.postMessage({ kind: "progress", progress }));
    const { means, quats, scales, opacities, sh, lobes } = scene;
    const transfer = [means, quats, scales, opacities, sh, ...(lobes ? [lobes] : [])].map(({ buffer }) => buffer);
    self.postMessage({ kind: "decoded", scene }, { transfer: /** @type {Transferable[]} */ (transfer) });
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    self.postMessage({ kind: error instanceof SceneError ? "damaged" : "failed", message });
  }
}

if (globalThis.self) {
  self.onmessage = (event) => ("piece" in event.data ? take(event.data.piece) : receive(event));
}
