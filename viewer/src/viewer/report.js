/** The report of a measurement, in a dialog from which it can be copied or shared. */

/**
 * @param {HTMLElement} element
 * @param {ShadowRoot} root
 * @param {import("./dialogs.js").Dialogs} dialogs
 * @param {Record<string, unknown>} figures
 */
export function showReport(element, root, dialogs, figures) {
  const panel = /** @type {HTMLElement} */ (root.querySelector(".report"));
  const part = (/** @type {string} */ selector) => /** @type {any} */ (panel.querySelector(selector));
  part("textarea").value = JSON.stringify(figures, null, 1);
  const scenes = /** @type {import("./bench.js").Measured[]} */ (figures.scenes);
  const interrupted = scenes.some((one) => one.interrupted);
  const words = scenes.map(({ cold, steady }) => `${cold.fps} frames/s cold, ${steady.fps} steady`).join(" | ");
  const heading = part("h2");
  delete heading.dataset.text;
  heading.textContent = interrupted ? "The page was hidden during the measurement: measure again" : words;
  part("[data-act=send]").hidden = !navigator.share;
  if (panel.hidden) dialogs.show("report");
  element.dispatchEvent(new CustomEvent("report", { detail: figures }));
}
