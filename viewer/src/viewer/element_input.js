/** Keys and dropped files of `<mobile-gs>`; the canvas has its own input (input.js). */

import { KEYS } from "./template.js";

/**
 * Listen to the keys of buttons, and show the focus only to keyboard users: pages set the focus too.
 *
 * @param {ShadowRoot} root
 * @param {(action: string) => void} act
 * @param {() => void} typed there is a keyboard
 */
export function listenToKeys(root, act, typed) {
  root.addEventListener("keydown", (event) => {
    const { code, key, ctrlKey, metaKey, altKey, repeat, target, defaultPrevented } = /** @type {KeyboardEvent} */ (event);
    // the code is the key's place, for keyboards with other alphabets
    const action = KEYS.get(key.toLowerCase()) ?? KEYS.get(code.slice(3).toLowerCase());
    const typing = defaultPrevented || /** @type {Element} */ (target).matches("textarea, select, input:not([type])");
    if (action && !ctrlKey && !metaKey && !altKey && !repeat && !typing) {
      typed();
      act(action);
    }
    if (code === "Escape") act("close");
  });
  root.addEventListener("keyup", (event) => {
    const { code, target } = /** @type {KeyboardEvent} */ (event);
    const { classList } = /** @type {Element} */ (target);
    if (code !== "Tab") return;
    classList.add("reached");
    target?.addEventListener("blur", () => classList.remove("reached"), { once: true });
  });
}

/**
 * Listen to files that are dropped on the element.
 *
 * @param {HTMLElement} element
 * @param {HTMLElement} sign shown while files are dragged over the element
 * @param {(files: FileList | undefined) => void} open
 */
export function listenToFiles(element, sign, open) {
  element.addEventListener("dragover", (event) => {
    event.preventDefault();
    sign.hidden = false;
  });
  element.addEventListener("dragleave", () => (sign.hidden = true));
  element.addEventListener("drop", (event) => {
    event.preventDefault();
    sign.hidden = true;
    open(event.dataTransfer?.files);
  });
}
