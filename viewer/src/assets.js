/** The viewer's own files, from source: a browser loads each module. `assets_bundle.js` replaces this module in the bundle. */

/** Start a worker that loads scenes or helps with it. @returns {Worker} */
export function newWorker() {
  return new Worker(new URL("./viewer.js", import.meta.url), { type: "module" });
}

/**
 * Start a worker that loads a scene.
 *
 * @param {import("./load/worker.js").Request} request
 * @param {(event: MessageEvent<import("./load/worker.js").Message>) => void} receive called with each message
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

/** The text of a shader. @param {string} file @returns {Promise<string>} */
export async function shaderText(file) {
  const response = await fetch(new URL(`../shaders/${file}`, import.meta.url));
  if (!response.ok) throw new Error(`the viewer's own file ${file} is missing on the server`);
  return response.text();
}

/** The version of the package. */
export function version() {
  return "source";
}

/** The scene that the page embeds. @returns {Blob | null} */
export function embeddedScene() {
  return null;
}
