/** The viewer's own files, inside the npm package. It replaces `assets.js` there and exports the same functions. */

import { newWorker } from "./packed_worker.js";

export { newWorker } from "./packed_worker.js";
export { shaderText } from "./shaders.js";

/**
 * @param {import("../load/worker.js").Request} request
 * @param {(event: MessageEvent<import("../load/worker.js").Message>) => void} receive
 * @returns {Worker}
 */
export function loadingWorker(request, receive) {
  const worker = newWorker();
  worker.onmessage = receive;
  worker.postMessage(request);
  return worker;
}

/** @returns {Promise<GPUAdapter | null>} */
export function findAdapter() {
  return navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
}

export function version() {
  return PACKAGE_VERSION;
}

/** @returns {Blob | null} */
export function embeddedScene() {
  return null;
}
