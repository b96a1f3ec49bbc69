/** Decodes a `.mgs` to arrays: in a worker where there are workers, else in this thread. */

import { bytesOf } from "../load/bytes_of.js";
import { SceneError } from "../mgs/error.js";
import { packedWorker, unpacked } from "../assets.js";

/**
 * @typedef {object} MgsCamera a training camera
 * @property {Float32Array} viewmat world to camera, 16 numbers row by row, OpenCV axes (x right, y down, z ahead)
 * @property {Float32Array} K camera to pixels, 9 numbers row by row
 * @property {number} width pixels
 * @property {number} height pixels
 */
/**
 * @typedef {object} MgsWeighting the weights of sort-free blending
 * @property {string} name
 * @property {number} exponent_max
 * @property {number} sigma
 * @property {number} background_weight
 * @property {number} alpha_min
 */
/**
 * @typedef {object} MgsFootprint how a Gaussian covers pixels
 * @property {number} blur px^2
 * @property {boolean} antialiased
 * @property {boolean} soft_edge
 */
/**
 * @typedef {object} MgsScene a decoded scene; arrays have one row per Gaussian, in the order of the file
 * @property {number} count Gaussians
 * @property {Float32Array} means world units, 3 each
 * @property {Float32Array} quats rotations wxyz, 4 each, of length 1, or 0: then the Gaussian is invisible
 * @property {Float32Array} scales standard deviations along the rotated axes, world units, 3 each
 * @property {Float32Array} opacities in (0, 1); of a scene with lobes, that of the constant harmonic
 * @property {Float32Array} sh harmonics of the colour, degree 1: 4 coefficients of r, g, b each. The colour in a
 *     direction is `max(0, 0.5 + sum(sh * basis))`
 * @property {Float32Array | null} lobes harmonics of the opacity's logit and of phi: `(lobeDegree + 1) ** 2` pairs
 *     each; null if the file has none
 * @property {number} lobeDegree 0 to 3
 * @property {number[]} levels Gaussians of each LOD level, the coarsest first
 * @property {"sortfree" | "sorted"} blend
 * @property {MgsWeighting} weighting
 * @property {MgsFootprint} footprint
 * @property {Record<string, Float32Array> | null} network weights of the view network, row by row; null if the file
 *     has none
 * @property {Float32Array} background sRGB in [0, 1]
 * @property {number} near distance of the near plane, world units
 * @property {MgsCamera[]} cameras of the training photos, some of them
 * @property {[number, number, number] | null} up upward direction; null if the file names none
 * @property {Record<string, string | number | boolean | null>} notes such as `title` and `credit`
 */
/** @typedef {{received: number, total: number}} MgsProgress bytes; `total` is NaN while it is unknown */
/**
 * @typedef {object} DecodeOptions
 * @property {AbortSignal} [signal] ends loading and decoding
 * @property {(progress: MgsProgress) => void} [onProgress] called whenever bytes have come
 */
/** @typedef {ArrayBuffer | ArrayBufferView<ArrayBuffer> | Blob | Response | ReadableStream<Uint8Array> | URL | string} MgsSource */


/**
 * Decode a `.mgs`: bytes, a file, a response, a stream of bytes, or an address to load.
 *
 * In a browser a worker decodes, so that the page stays responsive. It rejects with a `SceneError` if the file is
 * damaged, and with the signal's reason if that is aborted.
 *
 * @param {MgsSource} source
 * @param {DecodeOptions} [options]
 * @returns {Promise<MgsScene>}
 */
export async function decodeMgs(source, { signal, onProgress } = {}) {
  signal?.throwIfAborted();
  // an aborted pipe cancels its source, also while no bytes come
  const stream = (await streamOf(source, signal)).pipeThrough(new TransformStream(), { signal });
  if (globalThis.Worker) return decodeInWorker(stream, signal, onProgress);
  const text = await unpacked(import("../worker.packed.js"));
  // of servers only: bundlers leave this import alone
  const { decodeStream } = (await import(/* webpackIgnore: true */ /* @vite-ignore */ `data:text/javascript,${encodeURIComponent(`${text};export default decoder`)}`)).default;
  try {
    return await decodeStream(stream, onProgress, signal);
  } catch (error) {
    throw error instanceof Error && error.name === "SceneError" ? new SceneError(error.message) : error;
  }
}

/** @param {MgsSource} source @param {AbortSignal} [signal] @returns {Promise<ReadableStream<Uint8Array<any>>>} */
async function streamOf(source, signal) {
  if (typeof source === "string" || source instanceof URL) {
    const { href } = new URL(source, globalThis.document?.baseURI ?? globalThis.location?.href);
    return (await bytesOf({ url: href }, signal)).source;
  }
  if (source instanceof Blob) return source.stream();
  if (source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return new Blob([source]).stream();
  if (source instanceof ReadableStream) return source;
  if (!(source instanceof Response)) {
    throw new TypeError("decodeMgs takes an ArrayBuffer, a typed array, a Blob, a Response, a ReadableStream or an address");
  }
  if (source.ok && source.body) return source.body;
  throw new Error(`${source.url || "the scene"} could not be loaded: the server says ${source.status}`);
}

/**
 * @param {ReadableStream<Uint8Array>} stream
 * @param {AbortSignal} [signal]
 * @param {DecodeOptions["onProgress"]} [onProgress]
 * @returns {Promise<MgsScene>}
 */
async function decodeInWorker(stream, signal, onProgress) {
  const worker = packedWorker(() => import("../worker.packed.js"));
  const pieces = stream.getReader();
  const over = new AbortController();
  try {
    return await new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => {
        if (data.kind === "progress") onProgress?.(data.progress);
        else if (data.kind === "decoded") resolve(data.scene);
        else reject(data.kind === "damaged" ? new SceneError(data.message) : new Error(data.message));
      };
      worker.onerror = () => reject(new Error("a worker of mobilegs cannot start: allow worker-src blob: in the page's policy, or host the script (setWorker)"));
      signal?.addEventListener("abort", () => reject(signal.reason), { signal: over.signal });
      const send = async () => {
        for (let next; !(next = await pieces.read()).done; ) worker.postMessage({ piece: next.value });
        worker.postMessage({ piece: null });
      };
      send().catch(reject);
    });
  } finally {
    over.abort();
    worker.terminate();
    await pieces.cancel().catch(() => {}); // of a damaged file
  }
}
