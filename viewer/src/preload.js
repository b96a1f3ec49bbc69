/**
 * Starts work before `viewer.js` has arrived: the worker that loads the scene (the same script), and
 * the search for a GPU. Pages contain this script right after their `<mobile-gs>`.
 */

{
  const parameters = new URLSearchParams(location.search);
  const source = parameters.get("url") || document.querySelector("mobile-gs")?.getAttribute("src");
  const script = new URL("viewer.js", document.baseURI).href;
  try {
    if (parameters.get("renderer") === "webgl" || !navigator.gpu) {
      const link = { rel: "modulepreload", href: new URL(WEBGL_CHUNK, script).href };
      document.head.append(Object.assign(document.createElement("link"), link));
    } else {
      globalThis.preloadedAdapter = navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
    }
    if (source) {
      const url = new URL(source, document.baseURI).href;
      const worker = new Worker(script, { name: url });
      /** @type {MessageEvent[]} */
      const messages = []; // until the viewer receives them itself
      worker.onmessage = (event) => messages.push(event);
      // a policy of the page may forbid this worker and allow the one that the viewer starts
      worker.onerror = () => (globalThis.preloadedWorker = undefined);
      globalThis.preloadedWorker = { url, worker, messages };
    }
  } catch {
    // the viewer does the same work later and reports what goes wrong
  }
}
