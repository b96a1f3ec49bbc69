/** Connects the settings panel and the viewer. */

import { colorOf, hexOf } from "./color.js";
import { filled } from "./localize.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */
/** @typedef {HTMLInputElement | HTMLSelectElement} Control */

/**
 * Show the viewer's settings in the panel.
 *
 * @param {HTMLElement} panel
 * @param {Viewer} viewer
 * @param {boolean} stats whether the frame rate is shown
 * @param {import("./texts.js").Texts} texts
 */
export function showSettings(panel, viewer, stats, texts) {
  const control = (/** @type {string} */ name) =>
    /** @type {Control} */ (panel.querySelector(`[name=${name}]`));
  control("background").value = hexOf(viewer.background);
  const resolution = /** @type {HTMLSelectElement} */ (control("scale"));
  const share = viewer.scale ?? 0;
  if (![...resolution.options].some(({ value }) => Number(value) === share)) {
    resolution.add(new Option(`${Math.round(100 * share)} %`, String(share)));
  }
  resolution.value = String(share);
  control("mode").value = viewer.mode;
  /** @type {HTMLInputElement} */ (control("turning")).checked = viewer.turning;
  /** @type {HTMLInputElement} */ (control("stats")).checked = stats;
  const { renderer, adapter } = viewer.device;
  const words = renderer ? filled(adapter ? texts.adapter : texts.device, renderer, adapter) : "";
  /** @type {HTMLElement} */ (panel.querySelector(".device")).textContent = words;
  const next = /** @type {HTMLElement} */ (panel.querySelector("[data-act=view]"));
  next.hidden = viewer.views.length < 2;
}

/** Apply a control to the viewer. @param {Control} control @param {Viewer} viewer */
export function applySetting(control, viewer) {
  const { name, value } = control;
  if (name === "background") viewer.background = colorOf(value);
  else if (name === "scale") viewer.scale = Number(value) || null;
  else if (name === "mode") viewer.mode = /** @type {import("./viewer.js").Mode} */ (value);
  else if (name === "turning") viewer.turning = /** @type {HTMLInputElement} */ (control).checked;
  viewer.redraw();
}
