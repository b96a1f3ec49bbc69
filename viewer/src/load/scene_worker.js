/** Starts the worker that loads a scene, `worker.js`. */

import { packedWorker, unpacked } from "../assets.js";

/** @typedef {import("./worker.js").Message} Message */
/** @typedef {import("./worker.js").Request} Request */

/** @param {Request} request @returns {Worker} */
export function startLoading(request) {
  const worker = packedWorker(() => import("../worker.packed.js"));
  worker.postMessage(request);
  return worker;
}

/**
 * Load a scene in the worker that `preload.js` started for it, or in a new one.
 *
 * @param {Request} request
 * @param {(event: MessageEvent<Message>) => void} receive called with each message
 * @returns {Worker}
 */
export function loadingWorker(request, receive) {
  const preloaded = globalThis.preloadedWorker;
  delete globalThis.preloadedWorker;
  const taken = preloaded && "url" in request && preloaded.url === request.url;
  if (!taken) preloaded?.worker.terminate();
  const worker = taken ? preloaded.worker : startLoading(request);
  const answer = async (/** @type {MessageEvent<import("./worker.js").Sent>} */ event) => {
    if (event.data.kind !== "formats") return receive(/** @type {MessageEvent<Message>} */ (event));
    worker.postMessage({ formats: await unpacked(import("../formats.packed.js")).catch(() => "") });
  };
  if (taken) preloaded.messages.forEach(answer);
  worker.onmessage = answer;
  return worker;
}
