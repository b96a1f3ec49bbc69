/**
 * Starts work before `viewer.js` has arrived: the worker that loads the scene, the search for a GPU, and the loading
 * of the shaders. Pages contain this script right after their `<mobile-gs>`.
 */

import { startLoading } from "./load/scene_worker.js";

const parameters = new URLSearchParams(location.search);
const element = document.querySelector("mobile-gs");
const source = (element?.hasAttribute("linkable") && parameters.get("url")) || element?.getAttribute("src");
const webgl = parameters.get("renderer") === "webgl" || !navigator.gpu;
if (!webgl) globalThis.preloadedAdapter = navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
// the viewer does the same work later and reports what goes wrong
void Promise.allSettled(webgl ? [import("./render/webgl.js"), import("./glsl.packed.js")] : [import("./wgsl.packed.js")]);
try {
  if (source) {
    const url = new URL(source, document.baseURI).href;
    const worker = startLoading({ url });
    /** @type {MessageEvent[]} */
    const messages = []; // until the viewer receives them itself
    worker.onmessage = (event) => messages.push(event);
    worker.onerror = () => (globalThis.preloadedWorker = undefined);
    globalThis.preloadedWorker = { url, worker, messages };
  }
} catch {
  // the address is malformed
}
