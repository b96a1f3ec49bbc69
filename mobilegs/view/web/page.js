/** The viewer's own page: a scene named in the address, the camera behind the #. */

import "./element.js";
import { ownScene, version } from "./files.js";
import { planOf, runBench } from "./viewer/bench.js";
import { readPose, writePose } from "./viewer/address.js";

/** Attributes of the element that the address may set by the same names. */
const WISHES =
  "renderer variant scale noui poster background fov autorotate compare".split(" ");
const QUIET = 400; // milliseconds without a change before the address follows

const element = /** @type {import("./element.js").MobileGs} */ (document.querySelector("mobile-gs"));
const wishes = new URLSearchParams(location.search);
for (const name of WISHES) {
  const value = wishes.get(name);
  if (value !== null) element.setAttribute(name, value);
}
const url = wishes.get("url");
if (url) element.setAttribute("src", url);
// the element begins as soon as this script has come to its end
setTimeout(() => {
  const own = ownScene();
  if (!url && own) void element.open(own);
  else if (!element.hasAttribute("src")) {
    element.failed(0, "no scene is named: open a .mgs, .ply or .spz file, or add ?url=... to the address");
  }
  goTo();
  if (parent === self) element.focus({ preventScroll: true }); // in a frame, the page around it has the keys
}, 0);

const goTo = () => {
  const pose = readPose(location.hash);
  if (pose) element.viewer?.place(pose);
};
addEventListener("hashchange", goTo);

let timer = 0;
let shown = "";
element.addEventListener("frame", () => {
  clearTimeout(timer);
  timer = setTimeout(() => {
    const text = element.viewer ? writePose(element.viewer.pose) : "";
    const moved = shown !== "" && text !== shown;
    shown = text;
    try {
      if (moved) history.replaceState(null, "", `#${text}`);
    } catch {
      // a page without an address of its own has none to change
    }
  }, QUIET);
});

const asked = wishes.get("bench");
if (asked !== null) {
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
    let interrupted = document.hidden; // then browsers draw nothing
    const leave = () => (interrupted ||= document.hidden);
    document.addEventListener("visibilitychange", leave);
    // keeps a phone from switching its screen off; pages that come over plain http may not
    const awake = await navigator.wakeLock?.request("screen").catch(() => null);
    try {
      found = await runBench(viewer, planOf(asked, screen), (share) => element.progress(0, share));
    } catch (error) {
      element.failed(0, `the frame rate cannot be measured: ${/** @type {Error} */ (error).message}`);
      return;
    } finally {
      document.removeEventListener("visibilitychange", leave);
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
