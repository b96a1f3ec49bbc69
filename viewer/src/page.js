/** The viewer's page: the URL names the scene, its fragment the camera. */

import "./element.js";
import { embeddedScene, version } from "./assets.js";
import { parsePlan, runBench } from "./viewer/bench.js";
import { poseFromHash, poseToHash } from "./viewer/pose_hash.js";

/** Attributes of the element that URL parameters of the same names set. */
const ATTRIBUTES =
  "renderer variant scale noui poster background fov autorotate compare".split(" ");
const QUIET = 400; // milliseconds without a frame before the URL is updated

/** Shows the scene that the address names, or the embedded one, in the page's `<mobile-gs>`. */
export function startPage() {
  const element = /** @type {import("./element.js").MobileGs} */ (document.querySelector("mobile-gs"));
  const parameters = new URLSearchParams(location.search);
  for (const name of ATTRIBUTES) {
    const value = parameters.get(name);
    if (value !== null) element.setAttribute(name, value);
  }
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
  if (bench !== null) {
    element.addEventListener("load", async (event) => {
      const { viewer } = element;
      if (!viewer) return;
      await viewer.calibrated;
      const screen = {
        width: Math.round(innerWidth * devicePixelRatio),
        height: Math.round(innerHeight * devicePixelRatio),
      };
      const { milliseconds, bytes } = /** @type {CustomEvent} */ (event).detail;
      let found;
      let interrupted = document.hidden; // browsers render nothing in hidden pages
      const onHidden = () => (interrupted ||= document.hidden);
      document.addEventListener("visibilitychange", onHidden);
      // keep the screen on; pages served over plain http may not
      const awake = await navigator.wakeLock?.request("screen").catch(() => null);
      try {
        found = await runBench(viewer, parsePlan(bench, screen), (share) => element.progress(0, share));
      } catch (error) {
        element.failed(0, `the frame rate cannot be measured: ${/** @type {Error} */ (error).message}`);
        return;
      } finally {
        document.removeEventListener("visibilitychange", onHidden);
        void awake?.release();
      }
      element.loaded(0, milliseconds, bytes);
      element.report({
        scene: element.getAttribute("src") ?? "own",
        date: new Date().toISOString(),
        gaussians: viewer.count,
        file_bytes: bytes,
        milliseconds_to_load: Math.round(milliseconds),
        interrupted,
        ...found,
        ...viewer.device,
        viewer: version(),
        browser: navigator.userAgent,
        device_pixel_ratio: devicePixelRatio,
      });
    }, { once: true });
  }
}
