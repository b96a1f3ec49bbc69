/** Load progress of a scene and of the one that it is compared with. */

/** @typedef {import("./viewer.js").Side} Side */
/** @typedef {"" | "loading" | "loaded" | "failed"} State "": no scene */
/**
 * @typedef {object} Progress
 * @property {string} name file name, or URL without query and fragment
 * @property {string} before name of the previous scene
 * @property {string} failed name of the scene that failed
 * @property {State} state
 * @property {number} share of the file that has been received
 * @property {string} sentence error message
 */

/** @returns {Progress} */
const empty = () => ({ name: "", before: "", failed: "", state: "", share: NaN, sentence: "" });

/** Progress of both scenes. */
export class LoadProgress {
  #sides = [empty(), empty()];

  /** Start another scene; without a name, clear the side. @param {Side} side @param {string} [name] */
  begin(side, name) {
    const before = this.#sides[side].name;
    this.#sides[side] = name === undefined ? empty() : { ...empty(), name, before, state: "loading" };
  }

  /** @param {Side} side @param {string} sentence @param {boolean} kept whether the previous scene is still shown */
  fail(side, sentence, kept) {
    const { name, before } = this.#sides[side];
    this.note(side, { share: 1, state: "failed", sentence, failed: this.names[side], name: kept ? before : name });
  }

  /** @param {Side} side @param {Partial<Progress>} change */
  note(side, change) {
    Object.assign(this.#sides[side], change);
  }

  /** The state of both: failed before loading before loaded. @returns {State} */
  get state() {
    const states = this.#sides.map(({ state }) => state);
    const order = /** @type {State[]} */ (["failed", "loading", "loaded"]);
    return order.find((state) => states.includes(state)) ?? "";
  }

  /** True if a scene is loading. */
  get busy() {
    return this.#sides.some(({ state }) => state === "loading");
  }

  /** Received share of all files; NaN while a size is unknown. */
  get share() {
    const shares = this.#sides.filter(({ state }) => state).map(({ share }) => share);
    return shares.reduce((sum, share) => sum + share, 0) / shares.length;
  }

  /** The error messages; of two scenes, each with its name. */
  get sentence() {
    const both = this.#sides.every(({ state }) => state);
    const sentences = this.#sides.map(({ state, sentence, failed }) => {
      if (state !== "failed") return "";
      return both && failed && !sentence.includes(failed) ? `${failed}: ${sentence}` : sentence;
    });
    return [...new Set(sentences.filter(Boolean))].join("; ");
  }

  /** The names of both scenes. */
  get names() {
    return namesOf(this.#sides[0].name, this.#sides[1].name);
  }
}

/**
 * Return the shortest ends of two paths that differ.
 *
 * @param {string} first
 * @param {string} second
 * @returns {[string, string]}
 */
export function namesOf(first, second) {
  const [a, b] = [first, second].map((text) => text.split("/").filter(Boolean));
  for (let parts = 1; parts <= Math.max(a.length, b.length); parts++) {
    const [one, other] = [a, b].map((words) => words.slice(-parts).map(plain).join("/"));
    if (one !== other) return [one, other];
  }
  return [plain(a[a.length - 1] ?? ""), plain(b[b.length - 1] ?? "")];
}

/** @param {string} word of a URL */
function plain(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    // file names may contain a %
    return word;
  }
}
