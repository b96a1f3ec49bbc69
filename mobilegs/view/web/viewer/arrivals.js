/** How far a scene is, and the one that it is compared with. */

/** @typedef {import("./viewer.js").Side} Side */
/** @typedef {"" | "loading" | "loaded" | "failed"} State "" of a scene that nobody asked for */
/**
 * @typedef {object} Arrival
 * @property {string} name its file, or an address without what follows the path
 * @property {string} before that of the scene in its place
 * @property {string} asked that of what failed
 * @property {State} state
 * @property {number} share of the file that has come
 * @property {string} sentence why it failed
 */

/** @returns {Arrival} */
const nothing = () => ({ name: "", before: "", asked: "", state: "", share: NaN, sentence: "" });

/** Both scenes, each for itself and taken together. */
export class Arrivals {
  #sides = [nothing(), nothing()];

  /** Another scene, or none, on a side. @param {Side} side @param {string} [name] */
  begin(side, name) {
    const before = this.#sides[side].name;
    this.#sides[side] = name === undefined ? nothing() : { ...nothing(), name, before, state: "loading" };
  }

  /** @param {Side} side @param {string} sentence @param {boolean} kept whether the scene before is still there */
  fail(side, sentence, kept) {
    const { name, before } = this.#sides[side];
    this.note(side, { share: 1, state: "failed", sentence, asked: this.names[side], name: kept ? before : name });
  }

  /** @param {Side} side @param {Partial<Arrival>} change */
  note(side, change) {
    Object.assign(this.#sides[side], change);
  }

  /** @returns {State} of both: one that failed counts most */
  get state() {
    const states = this.#sides.map(({ state }) => state);
    const order = /** @type {State[]} */ (["failed", "loading", "loaded"]);
    return order.find((state) => states.includes(state)) ?? "";
  }

  /** Whether more may come. */
  get busy() {
    return this.#sides.some(({ state }) => state === "loading");
  }

  /** Of what was asked for, that has come; NaN while that is not known. */
  get share() {
    const shares = this.#sides.filter(({ state }) => state).map(({ share }) => share);
    return shares.reduce((sum, share) => sum + share, 0) / shares.length;
  }

  /** Why something failed; of two scenes, with its name. */
  get sentence() {
    const both = this.#sides.every(({ state }) => state);
    const sentences = this.#sides.map(({ state, sentence, asked }) => {
      if (state !== "failed") return "";
      return both && asked && !sentence.includes(asked) ? `${asked}: ${sentence}` : sentence;
    });
    return [...new Set(sentences.filter(Boolean))].join("; ");
  }

  /** What to call the two. */
  get names() {
    return namesOf(this.#sides[0].name, this.#sides[1].name);
  }
}

/**
 * The ends of two paths, with as many folders as it takes to tell them apart.
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

/** @param {string} word of an address */
function plain(word) {
  try {
    return decodeURIComponent(word);
  } catch {
    // a file may have a % in its name
    return word;
  }
}
