/** Scenes on their way from files to the renderers: a worker loads each, for all meshes that show it. */

import { loadingWorker } from "../load/scene_worker.js";
import { worldMeans } from "../mgs/positions.js";
import { strides } from "../render/types.js";
import { recordLogits } from "../viewer/pick.js";
import { parsedUp } from "../viewer/up.js";

/** @typedef {import("../load/worker.js").Message} Message */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../mgs/positions.js").StoredMeans} StoredMeans */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/**
 * @typedef {object} StoreListener
 * @property {(share: number) => void} progress share of the file, 0 to 1; NaN while its size is unknown
 * @property {() => void} changed the scene has changed
 * @property {() => void} loaded everything is decoded
 * @property {(error: Error) => void} failed
 */

const SORTED =
  "this scene needs sorting, which MobileGSMesh does not do: train a sort-free scene from it with " +
  "`mobilegs compress`, or show it with <mobile-gs>";
const LINEAR = "MobileGSMesh does not draw the weighting sort_free_gs: show this scene with <mobile-gs>";
const SORT_FREE_GS = 3;

/** Those that some mesh shows, by address or file. @type {Map<string | Blob, SceneStore>} */
const stores = new Map();

/**
 * Join those that show a scene, which is loaded once.
 *
 * @param {string | Blob} source an address or a file
 * @param {StoreListener} listener
 */
export function joinScene(source, listener) {
  const store = stores.get(source) ?? new SceneStore(source);
  stores.set(source, store);
  store.add(listener);
  return store;
}

/** Loads one scene; renderers read it and upload what has changed. */
export class SceneStore {
  /** The scene with all its numbers; `count` is the number of Gaussians to draw. @type {SceneData | null} */
  data = null;
  /** Parts that have changed since `data` was set, in the order of the changes. @type {{part: Part, from: number, count: number}[]} */
  changes = [];
  /** Training cameras of the file. @type {View[]} */
  views = [];
  /** Near plane, training units. */
  near = 0.2;
  /** Notes of the file. @type {Record<string, string | number | boolean | null>} */
  notes = {};
  /** Upward direction that the file tells. @type {import("../viewer/vector.js").Vector | null} */
  up = null;
  /** Logits of the mean opacities. */
  logits = new Float32Array(0);

  /** @type {StoredMeans} */
  #means = new Float32Array(0);
  /** @type {Set<StoreListener>} */
  #listeners = new Set();
  #source;
  #complete = false;
  /** @type {Worker | null} */
  #worker;

  /** @param {string | Blob} source */
  constructor(source) {
    this.#source = source;
    const request = typeof source === "string" ? { url: source } : { file: source };
    const worker = loadingWorker(request, ({ data }) => this.#worker === worker && this.#receive(data));
    worker.onerror = (event) => {
      event.preventDefault();
      this.#fail("a worker of mobilegs cannot start: allow worker-src blob: in the page's policy, or host the script (setWorker)");
    };
    this.#worker = worker;
  }

  /** Means of the Gaussians to draw, training units, 3 each; converted at the first use. */
  get means() {
    return (this.#means = worldMeans(this.#means));
  }

  /** @param {StoreListener} listener that hears of what happens from now on, and at once if everything is decoded */
  add(listener) {
    this.#listeners.add(listener);
    if (this.#complete) queueMicrotask(() => this.#listeners.has(listener) && listener.loaded());
  }

  /** Leave; with the last one that shows it, the scene goes. @param {StoreListener} listener */
  leave(listener) {
    this.#listeners.delete(listener);
    if (!this.#listeners.size) this.#end();
  }

  #end() {
    this.#worker?.terminate();
    this.#worker = null;
    if (stores.get(this.#source) === this) stores.delete(this.#source);
  }

  /** @param {(listener: StoreListener) => void} call */
  #tell(call) {
    for (const listener of [...this.#listeners]) call(listener);
  }

  /** @param {string} sentence */
  #fail(sentence) {
    this.#end();
    this.#tell(({ failed }) => failed(new Error(sentence)));
  }

  /** @param {Message} message */
  #receive(message) {
    if (message.kind === "progress") this.#tell(({ progress }) => progress(message.received / message.total));
    else if (message.kind === "failed") this.#fail(message.sentence);
    else if (message.kind === "scene") this.#take(message);
    else if (message.kind === "rows") this.#write(message);
    else if (message.kind === "more") this.#show(message.means);
    else if (message.kind === "done") {
      this.#worker?.terminate();
      this.#worker = null;
      this.#complete = true;
      this.#tell(({ loaded }) => loaded());
    }
  }

  /** @param {Extract<Message, {kind: "scene"}>} message */
  #take({ data, means, views, near, notes, up }) {
    if (data.sorted || !data.packing) return this.#fail(SORTED);
    if (data.weighting.index === SORT_FREE_GS) return this.#fail(LINEAR);
    this.data = data;
    this.changes = [];
    this.views = views;
    this.near = near;
    this.notes = notes;
    this.up = parsedUp(notes.up) ?? up;
    this.logits = new Float32Array(data.count);
    recordLogits(this.logits, strides(data).lobes, 0, data.lobes);
    this.#show(means);
  }

  /** @param {Extract<Message, {kind: "rows"}>} message */
  #write({ part, from, numbers }) {
    if (!this.data) return;
    const stride = strides(this.data)[part];
    this.data[part].set(numbers, stride * from);
    this.changes.push({ part, from, count: numbers.length / stride });
    if (part === "lobes") recordLogits(this.logits, stride, from, numbers);
    this.#tell(({ changed }) => changed());
  }

  /** @param {StoredMeans} means */
  #show(means) {
    this.#means = means;
    if (this.data) this.data.count = ("stored" in means ? means.stored : means).length / 3;
    this.#tell(({ changed }) => changed());
  }
}
