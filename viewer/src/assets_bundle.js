/** The viewer's own files, inside the bundle. It replaces `assets.js` there and exports the same functions. */

import { workerPrefix } from "./chunks.js";

/** @returns {Worker} */
export function newWorker() {
  // build.mjs wraps the whole script in the function `bundle`, so that a worker can run its source text
  const url = URL.createObjectURL(new Blob([`${workerPrefix()}(${bundle})()`], { type: "text/javascript" }));
  setTimeout(() => URL.revokeObjectURL(url), 60000);
  return new Worker(url);
}

/**
 * Take over the worker that `preload.js` started, or start one.
 *
 * @param {import("./load/worker.js").Request} request
 * @param {(event: MessageEvent<import("./load/worker.js").Message>) => void} receive
 * @returns {Worker}
 */
export function loadingWorker(request, receive) {
  const preloaded = globalThis.preloadedWorker;
  delete globalThis.preloadedWorker;
  let worker;
  if (preloaded && "url" in request && preloaded.url === request.url) {
    worker = preloaded.worker;
    preloaded.messages.forEach(receive);
  } else {
    preloaded?.worker.terminate();
    worker = newWorker();
    worker.postMessage(request);
  }
  worker.onmessage = receive;
  return worker;
}

/** @returns {Promise<GPUAdapter | null>} */
export async function findAdapter() {
  const preloaded = globalThis.preloadedAdapter;
  delete globalThis.preloadedAdapter;
  return (await preloaded) ?? navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
}

/** @param {string} file @returns {Promise<string>} */
export async function shaderText(file) {
  return SHADERS[file];
}

export function version() {
  return PACKAGE_VERSION;
}

/** @returns {Blob | null} */
export function embeddedScene() {
  const element = document.getElementById("scene");
  if (element === null) return null;
  const text = atob(element.textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  return new Blob([bytes]);
}
