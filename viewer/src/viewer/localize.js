/** Chooses the language of the interface, and puts its texts into the element. */

import { parsed } from "../assets.js";
import { LANGUAGES, en } from "./texts.js";

/** @typedef {import("./texts.js").Texts} Texts */

/**
 * The first language that the interface has: of the element or of what it is in, then of the visitor.
 *
 * @param {Element} element
 */
export function languageOf(element) {
  const own = element.closest("[lang]")?.getAttribute("lang");
  const wanted = [own ?? "", ...navigator.languages].map((one) => one.toLowerCase().split("-")[0]);
  return wanted.find((one) => LANGUAGES.includes(one)) ?? "en";
}

/** The texts of a language; the English ones if they cannot be loaded. @param {string} language @returns {Promise<Texts>} */
export async function textsOf(language) {
  if (language === "en") return en;
  try {
    return (await parsed(import("../languages.packed.js")))[language];
  } catch {
    return en;
  }
}

/**
 * A text of a file, with characters that nobody sees as numbers: controls, and those that turn the text after them.
 *
 * @param {string} text
 */
export const visible = (text) =>
  text.replace(/[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]/g, (each) => `\\u${each.charCodeAt(0).toString(16).padStart(4, "0")}`);

/** A text with values in the place of each `{}`. @param {string} text @param {string[]} values */
export const filled = (text, ...values) => values.reduce((all, value) => all.replace("{}", () => value), text);

/**
 * Set the texts: `data-text` names the content of an element, `data-name` its name for screen readers,
 * which is the tooltip of a button, too.
 *
 * @param {ParentNode} root
 * @param {Texts} texts
 */
export function localize(root, texts) {
  const named = /** @type {Record<string, string>} */ (texts);
  for (const part of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll("[data-text]"))) {
    part.textContent = named[part.dataset.text ?? ""];
  }
  for (const part of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll("[data-name]"))) {
    const name = named[part.dataset.name ?? ""];
    part.setAttribute("aria-label", name);
    if (part instanceof HTMLButtonElement) part.title = name + (part.dataset.key ? ` (${part.dataset.key})` : "");
  }
}
