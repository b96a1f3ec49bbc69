/** The workers of the npm package. */

import { unpacked } from "./unpacked.js";

/** The text of the workers' module. @type {Promise<string> | undefined} */
let text;
/** Its address in a browser. @type {Promise<string> | undefined} */
let address;
/** The text of the workers' module. */
const workerText = () => (text ??= unpacked(PACKED_WORKER));

/** The exports of the workers' module, for Node.js. @returns {Promise<typeof import("./worker.js")>} */
export function workerModule() {
  // without `await`: vite wraps an import in a function that is not async
  return workerText().then((text) => import(`data:text/javascript,${encodeURIComponent(text)}`));
}

/** A worker that starts once its module is unpacked. */
class PackedWorker {
  /** @type {((event: MessageEvent) => void) | null} */
  onmessage = null;
  /** @type {((event: ErrorEvent) => void) | null} */
  onerror = null;
  #ended = false;
  #worker = this.#start();

  async #start() {
    address ??= workerText().then((text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    const worker = new Worker(await address, { type: "module" });
    worker.onmessage = (event) => this.onmessage?.(event);
    worker.onerror = (event) => this.onerror?.(event);
    if (this.#ended) worker.terminate();
    return worker;
  }

  /** @param {unknown} message @param {StructuredSerializeOptions} [options] */
  async postMessage(message, options) {
    try {
      (await this.#worker).postMessage(message, options);
    } catch (error) {
      // the page's content security policy forbids workers
      this.onerror?.(new ErrorEvent("error", { error, message: String(error), cancelable: true }));
    }
  }

  async terminate() {
    this.#ended = true;
    (await this.#worker.catch(() => null))?.terminate();
  }
}

/** Start a worker that loads scenes. @returns {Worker} */
export function newWorker() {
  return /** @type {Worker} */ (/** @type {unknown} */ (new PackedWorker()));
}
