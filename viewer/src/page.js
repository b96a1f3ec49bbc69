/** The viewer's page: the URL names the scene, its fragment the camera. */

import "./element.js";
import { bytesOfBase64, own } from "./assets.js";
import { loaded } from "./viewer/loaded.js";
import { poseFromHash, poseToHash } from "./viewer/pose_hash.js";

/** Attributes of the element that URL parameters of the same names set. */
const ATTRIBUTES =
  "renderer variant levels scale noui poster background fov up start start-portrait limits free autorotate autoplay compare heading credit lang".split(" ");
/** Those by which a link would put foreign words and pictures into the page. */
const FOREIGN = ["compare", "poster", "heading", "credit"];
const QUIET = 400; // milliseconds without a frame before the URL is updated

/** Shows the scene that the address names, or the embedded one, in the page's `<mobile-gs>`. */
export function startPage() {
  const element = /** @type {import("./element.js").MobileGs} */ (document.querySelector("mobile-gs"));
  const parameters = new URLSearchParams(location.search);
  const linkable = element.hasAttribute("linkable");
  for (const name of ATTRIBUTES) {
    const value = parameters.get(name);
    if (value !== null && (linkable || !FOREIGN.includes(name) || value === "sorted")) element.setAttribute(name, value);
  }
  element.lang ||= navigator.language; // that of the page is its author's
  const [url, ...others] = linkable ? parameters.getAll("url") : [];
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

  const plan = parameters.get("bench");
  if (plan === null) return;
  const loading = loaded(element);
  void own(import("./viewer/report.js")).then(({ measure }) => measure(element, plan, loading, others));
}

/** The scene that the page embeds. @returns {Blob | null} */
function embeddedScene() {
  const text = document.getElementById("scene")?.textContent;
  return text ? new Blob([bytesOfBase64(text)]) : null;
}
