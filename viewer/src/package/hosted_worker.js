/** Workers whose script the page hosts, where its policy forbids `blob:`. Without workers, the script runs in the page. */

import { hostWorkers, startWorker, trustedAddress, unpacked } from "../assets.js";

/**
 * The script of the workers, to be written to a file of the site, which `setWorker` names.
 *
 * @returns {Promise<string>}
 */
export async function workerScript() {
  const packed = [import("../worker.packed.js"), import("../formats.packed.js")];
  const [worker, formats] = await Promise.all(packed.map(unpacked));
  // in a page, its names are those of `PageWorker`'s scope, which has no Trusted Types: the page has the policy already
  const scope = "(s=>[s.self,s,s.Worker])(globalThis.document?.currentScript?.scope??self)";
  return `((self,globalThis,Worker)=>{if(self.location.hash==="#formats"){${formats}}else{${worker}}})(...${scope});\n`;
}

/**
 * Start workers from an address, for scenes that are opened from now on.
 *
 * If the page's policy allows no worker from there either, the script runs in the page, which does not respond while a
 * scene is decoded.
 *
 * @param {string | URL | null} address of the text of `workerScript`, on the page's own host; null: workers start from
 *     `blob:`, as by default
 */
export function setWorker(address) {
  const href = address === null ? null : new URL(address, document.baseURI).href;
  hostWorkers(href === null ? null : () => /** @type {any} */ (new HostedWorker(href)));
}

/** The script in the page, used as a worker. */
class PageWorker {
  /** @type {((event: MessageEvent) => void) | null} */
  onmessage = null;
  /** @type {((event: ErrorEvent) => void) | null} */
  onerror = null;
  #ended = false;
  #scope;
  #ready;

  /** @param {string} address */
  constructor(address) {
    /** @type {Record<string, any>} */
    const scope = {
      location: new URL(address),
      onmessage: (/** @type {{data: unknown}} */ _) => {},
      postMessage: (/** @type {unknown} */ data, /** @type {StructuredSerializeOptions} */ options) => {
        const message = new MessageEvent("message", { data: structuredClone(data, options) });
        queueMicrotask(() => this.#ended || this.onmessage?.(message));
      },
      Worker: FormatsWorker,
    };
    this.#scope = scope.self = scope;
    const script = Object.assign(document.createElement("script"), { scope });
    this.#ready = new Promise((resolve, reject) => Object.assign(script, { onload: resolve, onerror: reject }));
    this.#ready.then(() => script.remove(), () => this.onerror?.(new ErrorEvent("error")));
    script.src = trustedAddress(address);
    document.head.append(script);
  }

  /** @param {unknown} message @param {Transferable[]} [transfer] */
  postMessage(message, transfer = []) {
    const data = structuredClone(message, { transfer });
    // a task, as messages are
    this.#ready.then(() => setTimeout(() => this.#ended || this.#scope.onmessage({ data })), () => {});
  }

  terminate() {
    this.#ended = true;
  }
}

/** A page starts no helpers: they would share its thread. */
class FormatsWorker extends PageWorker {
  /** @param {string} address */
  constructor(address) {
    if (!address.endsWith("#formats")) throw new Error("a page has one thread");
    super(address);
  }
}

/** A worker from an address, or the script in the page if the worker cannot start. */
class HostedWorker {
  /** @type {((event: MessageEvent) => void) | null} */
  onmessage = null;
  /** @type {((event: ErrorEvent) => void) | null} */
  onerror = null;
  /** Messages until the worker answers. @type {unknown[]} */
  #sent = [];
  #answers = false;
  #address;
  /** @type {Worker} */
  #worker;

  /** @param {string} address */
  constructor(address) {
    this.#address = address;
    try {
      this.#worker = this.#heard(startWorker(address));
    } catch {
      this.#worker = this.#inPage();
    }
  }

  /** @param {Worker} worker @param {boolean} [last] whether it is the last attempt */
  #heard(worker, last = false) {
    worker.onmessage = (event) => {
      this.#answers = true;
      this.#sent.length = 0;
      this.onmessage?.(event);
    };
    worker.onerror = (event) => {
      if (this.#answers || last) return this.onerror?.(event);
      event.preventDefault();
      this.#worker = this.#inPage();
      for (const message of this.#sent) this.#worker.postMessage(message);
    };
    return worker;
  }

  #inPage() {
    return this.#heard(/** @type {any} */ (new PageWorker(this.#address)), true);
  }

  /** @param {unknown} message */
  postMessage(message) {
    if (!this.#answers) this.#sent.push(message);
    this.#worker.postMessage(message);
  }

  terminate() {
    this.#worker.terminate();
  }
}
