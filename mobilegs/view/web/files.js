/** Where the viewer's own files come from. A page that holds everything itself has another one. */

/** A thread that reads scenes, or helps with it. @returns {Worker} */
export function newWorker() {
  return new Worker(new URL("./load/worker.js", import.meta.url), { type: "module" });
}

/**
 * A thread that reads a scene.
 *
 * @param {import("./load/worker.js").Request} request
 * @param {(event: MessageEvent<import("./load/worker.js").Message>) => void} take what it says
 * @returns {Worker}
 */
export function loadingWorker(request, take) {
  const worker = newWorker();
  worker.onmessage = take;
  worker.postMessage(request);
  return worker;
}

/** @returns {Promise<GPUAdapter | null>} */
export function findAdapter() {
  return navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
}

/** A shader's text. @param {string} file @returns {Promise<string>} */
export async function shaderText(file) {
  const response = await fetch(new URL(`../shaders/${file}`, import.meta.url));
  if (!response.ok) throw new Error(`the viewer's own file ${file} is missing on the server`);
  return response.text();
}

/** Of the package that these files are of. */
export function version() {
  return "its source";
}

/** The scene that the page brings along. @returns {Blob | null} */
export function ownScene() {
  return null;
}
