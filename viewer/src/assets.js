/**
 * The viewer's own files: the parts of its script that are loaded when they are needed, workers and shaders.
 *
 * Workers and shaders are compressed texts in modules `NAME.packed.js`, which the build makes. So they are where the
 * script is, and a page in one file, content networks and bundlers without settings all start workers in one way.
 */

/** @typedef {Promise<{text: string}>} Packed a module `NAME.packed.js` */

/** A part of the script. @template T @param {Promise<T>} loading @returns {Promise<T>} */
export async function own(loading) {
  try {
    return await loading;
  } catch {
    throw new Error("the viewer's own files could not be loaded: reload the page");
  }
}

/** Of pages that require Trusted Types, which must allow it. @type {{createHTML(text: string): string, createScriptURL(text: string): string} | undefined} */
const policy = /** @type {any} */ (globalThis).trustedTypes?.createPolicy("mobilegs", { createHTML: String, createScriptURL: String });

/** A text of ours, as HTML. @param {string} text */
export const trustedHtml = (text) => (policy ? policy.createHTML(text) : text);

/** An address of a script of ours. @param {string} address */
export const trustedAddress = (address) => (policy ? policy.createScriptURL(address) : address);

/** Start a worker. @param {string} address of a script of ours */
export const startWorker = (address) => new Worker(trustedAddress(address));

/** @param {string} text */
export const bytesOfBase64 = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));

/** @param {Packed} packed @returns {Promise<string>} */
export async function unpacked(packed) {
  const { text } = await packed;
  return new Response(new Blob([bytesOfBase64(text)]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
}

/** The shaders of a language by name, or the texts of the interface by language. @param {Packed} packed @returns {Promise<Record<string, any>>} */
export const parsed = async (packed) => JSON.parse(await own(unpacked(packed)));

/** An address of a script, for workers. They are no modules: pages from `file:` may not start those. @param {string} text */
export const addressOf = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));

/** Addresses of scripts of workers by module: they stay, since a worker starts its helpers from its own. @type {Map<unknown, Promise<string>>} */
const addresses = new Map();

/** A worker that starts once its module is unpacked. */
class PackedWorker {
  /** @type {((event: MessageEvent) => void) | null} */
  onmessage = null;
  /** @type {((event: ErrorEvent) => void) | null} */
  onerror = null;
  #ended = false;
  #worker;

  /** @param {Packed} packed */
  constructor(packed) {
    this.#worker = this.#start(packed);
  }

  /** @param {Packed} packed */
  async #start(packed) {
    const module = await packed;
    if (!addresses.has(module)) addresses.set(module, unpacked(packed).then(addressOf));
    const worker = startWorker(/** @type {string} */ (await addresses.get(module)));
    worker.onmessage = (event) => this.onmessage?.(event);
    worker.onerror = (event) => this.onerror?.(event);
    if (this.#ended) worker.terminate();
    return worker;
  }

  /** @param {unknown} message @param {StructuredSerializeOptions} [options] */
  async postMessage(message, options) {
    try {
      (await this.#worker).postMessage(message, options);
    } catch {
      // the script is missing, or the page's content security policy forbids workers
      this.onerror?.(new ErrorEvent("error"));
    }
  }

  async terminate() {
    this.#ended = true;
    (await this.#worker.catch(() => null))?.terminate();
  }
}

/** Starts a worker from a script that the page hosts. */
let hosted = /** @type {(() => Worker) | null} */ (null);

/** @param {typeof hosted} start of all workers of scenes; null: they start from packed scripts */
export const hostWorkers = (start) => void (hosted = start);

/** @param {() => Packed} load @returns {Worker} */
export const packedWorker = (load) => hosted?.() ?? /** @type {Worker} */ (/** @type {unknown} */ (new PackedWorker(load())));
