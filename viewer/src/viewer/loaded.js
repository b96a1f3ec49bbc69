/**
 * Wait until a scene is loaded; null if that fails.
 *
 * @param {import("../element.js").MobileGs} element
 * @returns {Promise<{milliseconds: number, bytes: number} | null>}
 */
export function loaded(element) {
  return new Promise((resolve) => {
    element.addEventListener("load", (event) => resolve(/** @type {CustomEvent} */ (event).detail), { once: true });
    element.addEventListener("error", () => resolve(null), { once: true });
  });
}
