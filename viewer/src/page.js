/** The viewer's page: the URL names the scene, its fragment the camera. */

import "./element.js";
import { embeddedScene, version } from "./assets.js";
import { extras } from "./chunks.js";
import { poseFromHash, poseToHash } from "./viewer/pose_hash.js";

/** Attributes of the element that URL parameters of the same names set. */
const ATTRIBUTES =
  "renderer variant levels scale noui poster background fov up start start-portrait limits free autorotate autoplay compare heading credit lang".split(" ");
const QUIET = 400; // milliseconds without a frame before the URL is updated

/** Shows the scene that the address names, or the embedded one, in the page's `<mobile-gs>`. */
export function startPage() {
  const element = /** @type {import("./element.js").MobileGs} */ (document.querySelector("mobile-gs"));
  const parameters = new URLSearchParams(location.search);
  for (const name of ATTRIBUTES) {
    const value = parameters.get(name);
    if (value !== null) element.setAttribute(name, value);
  }
  element.lang ||= navigator.language; // that of the page is its author's
  const url = parameters.get("url");
  if (url) element.setAttribute("src", url);
  // the element starts in a microtask after this script
  setTimeout(() => {
    const own = embeddedScene();
    if (!url && own) void element.open(own);
    else if (!element.hasAttribute("src")) {
      element.failed(0, "no scene is given: open a .mgs, .ply or .spz file, or add ?url=... to the address");
    }
    goTo();
    if (parent === self) element.focus({ preventScroll: true }); // in a frame, the outer page keeps the focus
  }, 0);

  const goTo = () => {
    const pose = poseFromHash(location.hash);
    if (pose) element.viewer?.place(pose);
  };
  addEventListener("hashchange", goTo);

  let timer = 0;
  let shown = "";
  const fragment = () => (element.viewer ? poseToHash(element.viewer.pose) : "");
  element.addEventListener("frame", () => {
    shown ||= fragment(); // where the scene opened: a first drag may come at once
    clearTimeout(timer);
    timer = setTimeout(() => {
      const text = fragment();
      const moved = shown !== "" && text !== shown;
      shown = text;
      try {
        if (moved) history.replaceState(null, "", `#${text}`);
      } catch {
        // pages without a URL of their own, such as srcdoc frames, cannot change it
      }
    }, QUIET);
  });

  const bench = parameters.get("bench");
  if (bench !== null) void measure(element, bench, parameters.getAll("url").slice(1));
}

/**
 * Measure the scene that the page opens, then others, and show one report.
 *
 * @param {import("./element.js").MobileGs} element
 * @param {string} bench value of the URL parameter
 * @param {string[]} others addresses of the other scenes
 */
async function measure(element, bench, others) {
  const screen = {
    width: Math.round(innerWidth * devicePixelRatio),
    height: Math.round(innerHeight * devicePixelRatio),
  };
  let loading = loaded(element);
  const { parsePlan, runBench } = await extras();
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
  await element.report({
    date: new Date().toISOString(),
    ...plan,
    viewer: version(),
    browser: navigator.userAgent,
    device_pixel_ratio: devicePixelRatio,
    scenes,
  });
}

/**
 * Wait until a scene is loaded; null if that fails.
 *
 * @param {import("./element.js").MobileGs} element
 * @returns {Promise<{milliseconds: number, bytes: number} | null>}
 */
function loaded(element) {
  return new Promise((resolve) => {
    element.addEventListener("load", (event) => resolve(/** @type {CustomEvent} */ (event).detail), { once: true });
    element.addEventListener("error", () => resolve(null), { once: true });
  });
}
