/** The module of workers, whose text the package contains: loads scenes for the viewer, and decodes for `decodeMgs`. */

import { startWorker } from "../load/worker.js";
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

// Node.js, which has no workers of this kind, imports `decodeStream`
if (globalThis.WorkerGlobalScope) {
  startWorker();
  const load = /** @type {(event: MessageEvent) => void} */ (self.onmessage);
  self.onmessage = (event) => ("piece" in event.data ? take(event.data.piece) : load(event));
}
