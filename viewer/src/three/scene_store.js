/** A scene on its way from a file to the renderers: loads it in a worker, and keeps its packed numbers. */

import { loadingWorker } from "../load/scene_worker.js";
import { worldMeans } from "../mgs/positions.js";
import { strides } from "../render/types.js";
import { recordLogits } from "../viewer/pick.js";

/** @typedef {import("../load/worker.js").Message} Message */
/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../mgs/positions.js").StoredMeans} StoredMeans */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {{url: string} | {file: Blob}} Source */
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
  /** Logits of the mean opacities. */
  logits = new Float32Array(0);

  /** @type {StoredMeans} */
  #means = new Float32Array(0);
  #listener;
  /** @type {Worker | null} */
  #worker;

  /**
   * @param {Source} source
   * @param {StoreListener} listener
   */
  constructor(source, listener) {
    this.#listener = listener;
    const worker = loadingWorker(source, ({ data }) => this.#worker === worker && this.#receive(data));
    worker.onerror = (event) => {
      event.preventDefault();
      this.#fail("the files of mobilegs could not be loaded in a worker: does the page's policy allow blob: workers?");
    };
    this.#worker = worker;
  }

  /** Means of the Gaussians to draw, training units, 3 each; converted at the first use. */
  get means() {
    return (this.#means = worldMeans(this.#means));
  }

  /** Stop loading and drop the scene. */
  destroy() {
    this.#worker?.terminate();
    this.#worker = null;
    this.data = null;
    this.changes = [];
    this.logits = new Float32Array(0);
    this.#means = new Float32Array(0);
  }

  /** @param {string} sentence */
  #fail(sentence) {
    this.#worker?.terminate();
    this.#worker = null;
    this.#listener.failed(new Error(sentence));
  }

  /** @param {Message} message */
  #receive(message) {
    if (message.kind === "progress") this.#listener.progress(message.received / message.total);
    else if (message.kind === "failed") this.#fail(message.sentence);
    else if (message.kind === "scene") this.#take(message);
    else if (message.kind === "rows") this.#write(message);
    else if (message.kind === "more") this.#show(message.means);
    else if (message.kind === "done") {
      this.#worker?.terminate();
      this.#worker = null;
      this.#listener.loaded();
    }
  }

  /** @param {Extract<Message, {kind: "scene"}>} message */
  #take({ data, means, views, near }) {
    if (data.sorted || !data.packing) return this.#fail(SORTED);
    if (data.weighting.index === SORT_FREE_GS) return this.#fail(LINEAR);
    this.data = data;
    this.changes = [];
    this.views = views;
    this.near = near;
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
    this.#listener.changed();
  }

  /** @param {StoredMeans} means */
  #show(means) {
    this.#means = means;
    if (this.data) this.data.count = ("stored" in means ? means.stored : means).length / 3;
    this.#listener.changed();
  }
}
