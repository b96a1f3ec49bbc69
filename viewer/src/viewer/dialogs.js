/** Opens and closes the dialogs, copies what they show, and shares the page's address. */

import { trustedHtml } from "../assets.js";
import { codeOf, isLocal, offer } from "./share.js";

/** @typedef {import("./texts.js").Texts} Texts */

const NAMES = ["settings", "help", "share", "report"];

/** The dialogs of an element, of which at most one is open. */
export class Dialogs {
  #root;
  /** The element that had the focus before a dialog. @type {HTMLElement | null} */
  #opener = null;

  /** @param {ShadowRoot} root */
  constructor(root) {
    this.#root = root;
  }

  /** Show or hide a part. @param {string} name @param {boolean} [shown] @returns {boolean} whether it is shown now */
  toggle(name, shown) {
    const part = this.#part(name);
    part.hidden = shown === undefined ? !part.hidden : !shown;
    this.#root.querySelector(`[data-act=${name}]`)?.setAttribute("aria-expanded", String(!part.hidden));
    return !part.hidden;
  }

  /** Toggle a dialog and close the others; null closes all. @param {string | null} name */
  show(name) {
    if (!this.#open) this.#opener = /** @type {HTMLElement | null} */ (this.#root.activeElement);
    const shown = name !== null && this.#part(name).hidden;
    for (const one of NAMES) this.toggle(one, shown && one === name);
    if (shown) this.#part(name).focus();
    else (this.#opener ?? this.#root.querySelector("canvas"))?.focus({ preventScroll: true });
  }

  /** Copy the text of the open dialog. Pages served over plain http have no clipboard API. @param {Texts} texts */
  async copy(texts) {
    const text = this.#selected();
    const done = navigator.clipboard
      ? await navigator.clipboard.writeText(text).then(() => true, () => false)
      : document.execCommand("copy");
    this.#part("sheet:not([hidden]) .copied").textContent = done ? texts.copied : texts.uncopied;
  }

  /** Offer the text of the open dialog to the device's own menu. */
  send() {
    const text = this.#selected();
    void offer(this.#open === "share" ? { url: text } : { text });
  }

  /** Share the page's address by the device's own menu, or else in a dialog. @param {Texts} texts */
  async share(texts) {
    const { href } = location;
    const panel = this.#part("share");
    const touch = panel.hidden && "share" in navigator && matchMedia("(pointer: coarse)").matches;
    if (touch && (await offer({ title: document.title, url: href }))) return;
    const [field, code] = [/** @type {HTMLInputElement} */ (panel.querySelector("input")), this.#part("code")];
    field.value = href;
    this.#part("share .copied").textContent = "";
    /** @type {HTMLElement} */ (panel.querySelector("[data-act=send]")).hidden = !navigator.share;
    this.show("share");
    code.innerHTML = trustedHtml(isLocal(location) ? "" : await codeOf(href));
    code.hidden = !code.innerHTML;
    this.#part("about").textContent = isLocal(location) ? texts.local : code.hidden ? "" : texts.scan;
  }

  /** Name of the open dialog. */
  get #open() {
    return NAMES.find((name) => !this.#part(name).hidden);
  }

  /** The text of the open dialog's field, which is selected so that the visitor can copy it where pages may not. */
  #selected() {
    const field = /** @type {HTMLInputElement} */ (
      this.#root.querySelector(".sheet:not([hidden]) :is(textarea, [readonly])")
    );
    field.focus();
    field.select();
    return field.value;
  }

  /** @param {string} name @returns {HTMLElement} */
  #part(name) {
    return /** @type {HTMLElement} */ (this.#root.querySelector(`.${name}`));
  }
}
