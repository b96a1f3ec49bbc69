/** The elements over the picture: title, hint and icon bar, which fade while nobody uses them. */

import { own } from "../assets.js";
import { visible } from "./localize.js";

const IDLE_TIME = 4000; // milliseconds
const HINT_TIME = 7000;
const USES = ["pointermove", "pointerdown", "wheel", "keydown", "focusin"];
const INPUTS = ["pointerdown", "wheel", "keydown"];
/** Modes of WebXR. */
const SESSIONS = /** @type {const} */ ({ vr: "immersive-vr", ar: "immersive-ar" });

/** Title, hint and icon bar of an element. */
export class Chrome {
  #part;
  /** Scenes that the hint was shown for. @type {Set<unknown>} */
  #hinted = new Set();
  #idle = 0; // timer
  #end = 0; // timer of the hint
  /** Starts sessions, once the device is known to offer them. @type {typeof import("./xr.js").present | null} */
  #present = null;

  /**
   * @param {HTMLElement} host
   * @param {HTMLElement} part holds `.title`, `.hint` and `.buttons`
   */
  constructor(host, part) {
    this.#part = part;
    const options = { capture: true, passive: true };
    for (const type of USES) host.addEventListener(type, () => this.#wake(), options);
    for (const type of INPUTS) host.addEventListener(type, () => this.#endHint(), options);
  }

  /** Show the hint, once for each scene, and let the rest fade after a while. @param {unknown} scene */
  invite(scene) {
    if (this.#hinted.has(scene)) return;
    this.#hinted.add(scene);
    this.#wake();
    this.#of("hint").hidden = false;
    clearTimeout(this.#end);
    this.#end = setTimeout(() => this.#endHint(), HINT_TIME);
  }

  /** @param {string} heading @param {string} credit */
  setTitle(heading, credit) {
    const title = this.#of("title");
    const texts = [heading, credit].map(visible);
    if (texts.every((text, i) => title.children[i].textContent === text)) return;
    texts.forEach((text, i) => (title.children[i].textContent = text));
    title.hidden = !heading && !credit;
  }

  /** Show the buttons of the sessions that the device offers. */
  async offer() {
    // in a frame without its page's permission, browsers that tell so complain about a question
    const { featurePolicy } = /** @type {{ featurePolicy?: { allowsFeature(name: string): boolean } }} */ (document);
    if (featurePolicy && !featurePolicy.allowsFeature("xr-spatial-tracking")) return;
    for (const [name, mode] of Object.entries(SESSIONS)) {
      if (!(await navigator.xr?.isSessionSupported(mode).catch(() => false))) continue;
      this.#present = (await own(import("./xr.js"))).present;
      this.#of(name).hidden = false;
    }
  }

  /**
   * Start a session, or end the one that runs.
   *
   * @param {"vr" | "ar"} name
   * @param {import("./viewer.js").Viewer} viewer
   * @returns {Promise<void> | undefined} rejects with a message for visitors
   */
  present(name, viewer) {
    return this.#present?.(viewer, SESSIONS[name], this.#of(name));
  }

  #wake() {
    this.#part.classList.remove("idle");
    clearTimeout(this.#idle);
    if (this.#hinted.size) this.#idle = setTimeout(() => this.#part.classList.add("idle"), IDLE_TIME);
  }

  #endHint() {
    this.#of("hint").hidden = true;
  }

  /** @param {string} name @returns {HTMLElement} */
  #of(name) {
    return /** @type {HTMLElement} */ (this.#part.querySelector(`.${name}`));
  }
}
