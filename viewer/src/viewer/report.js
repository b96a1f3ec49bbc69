/** Measures scenes, and shows the report in a dialog from which it can be copied or shared. */

import { parsePlan, runBench } from "./bench.js";
import { loaded } from "./loaded.js";

/**
 * Measure the scene that the page opens, then others, and show one report.
 *
 * @param {import("../element.js").MobileGs} element
 * @param {string} bench value of the URL parameter
 * @param {ReturnType<typeof loaded>} loading of the scene that the page opens
 * @param {string[]} others addresses of the other scenes
 */
export async function measure(element, bench, loading, others) {
  const screen = {
    width: Math.round(innerWidth * devicePixelRatio),
    height: Math.round(innerHeight * devicePixelRatio),
  };
  const plan = parsePlan(bench, screen);
  const scenes = [];
  let awake;
  for (const url of [null, ...others]) {
    if (url !== null) loading = loaded(element);
    if (url !== null) element.setAttribute("src", url);
    const file = await loading;
    const { viewer } = element;
    if (!file || !viewer) return; // the page shows why
    await viewer.calibrated;
    // keep the screen on; pages served over plain http may not
    awake ??= await navigator.wakeLock?.request("screen").catch(() => null);
    try {
      const found = await runBench(viewer, plan, (share) => element.progress(0, share));
      scenes.push({
        scene: element.getAttribute("src") ?? "own",
        gaussians: viewer.count,
        file_bytes: file.bytes,
        milliseconds_to_load: Math.round(file.milliseconds),
        ...viewer.device,
        ...found,
      });
    } catch (error) {
      void awake?.release();
      element.failed(0, `the frame rate cannot be measured: ${/** @type {Error} */ (error).message}`);
      return;
    }
    element.loaded(0, file.milliseconds, file.bytes);
  }
  void awake?.release();
  showReport(element, {
    date: new Date().toISOString(),
    ...plan,
    viewer: PACKAGE_VERSION,
    browser: navigator.userAgent,
    device_pixel_ratio: devicePixelRatio,
    scenes,
  });
}

/** @param {import("../element.js").MobileGs} element @param {Record<string, unknown>} figures */
function showReport(element, figures) {
  const { root, dialogs } = element.inside;
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
