/**
 * What can begin before the viewer's own script is there: the thread that reads the scene, which is
 * that script as well, and the search for a GPU. It stands in a page behind its `<mobile-gs>`.
 */

{
  const wishes = new URLSearchParams(location.search);
  const source = wishes.get("url") || document.querySelector("mobile-gs")?.getAttribute("src");
  try {
    if (wishes.get("renderer") !== "webgl") {
      const adapter = navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
      Object.assign(globalThis, { earlyAdapter: adapter });
    }
    if (source) {
      const url = new URL(source, document.baseURI).href;
      const worker = new Worker("viewer.js", { name: url });
      /** @type {MessageEvent[]} */
      const held = []; // what it says until somebody listens
      worker.onmessage = (event) => held.push(event);
      // where a page may not begin it so, the viewer can
      worker.onerror = () => Object.assign(globalThis, { earlyWorker: undefined });
      Object.assign(globalThis, { earlyWorker: { url, worker, held } });
    }
  } catch {
    // the viewer does all of it by itself, and tells what goes wrong
  }
}
