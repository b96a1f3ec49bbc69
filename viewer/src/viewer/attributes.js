/** Passes the attributes of `<mobile-gs>` on to its viewer. */

import { colorOf } from "./color.js";
import { FREE } from "./framing.js";
import { poseFromHash } from "./pose_hash.js";

/** @typedef {import("./viewer.js").Viewer} Viewer */

const FRAMING = ["start", "start-portrait", "limits", "free"];
/** Attributes that can change at any time. */
export const VIEWER_ATTRIBUTES = ["camera", "scale", "background", "fov", "up", "autorotate", ...FRAMING];
/** Media query: the visitor prefers reduced motion. */
export const STILL = "(prefers-reduced-motion: reduce)";

/** The options of an element's viewer that hold as long as it exists. @param {HTMLElement} element */
export function optionsOf(element) {
  const variant = element.getAttribute("variant");
  const [floats, strips] = ["floats", "strips"].map((word) => Boolean(variant?.includes(word)));
  const levels = Number(element.getAttribute("levels") ?? NaN);
  return {
    variant: variant === null ? null : { floats, strips },
    levels: levels === 0 || (levels >= 0.6 && levels <= 100) ? levels : null,
    patient: element.hasAttribute("poster"),
    editable: element.hasAttribute("editable"),
  };
}

/** Apply an attribute. @param {HTMLElement} element @param {Viewer} viewer @param {string} name one of VIEWER_ATTRIBUTES */
export function applyAttribute(element, viewer, name) {
  const text = element.getAttribute(name);
  const number = Number(text);
  if (name === "scale") viewer.scale = number > 0 && number <= 1 ? number : null;
  else if (name === "fov") viewer.fov = number >= 1 && number <= 150 ? number : null;
  else if (name === "background") viewer.background = colorOf(text);
  else if (name === "autorotate") viewer.turning = text !== null && !matchMedia(STILL).matches;
  else if (name === "camera") {
    const pose = poseFromHash(text ?? "");
    if (pose) viewer.place(pose);
  } else {
    if (name === "up") viewer.up = text;
    viewer.given = framingOf(element);
  }
  viewer.redraw();
}

/** The notes of first views, limits and the upward direction that attributes give. @param {HTMLElement} element */
function framingOf(element) {
  /** @type {Record<string, string>} */
  const given = {};
  const up = element.getAttribute("up");
  if (up !== null) given.up = up; // an axis is no direction here
  for (const name of FRAMING) {
    const text = element.getAttribute(name);
    if (name === "free" && text !== null) given.limits = FREE;
    else if (text !== null) {
      given[name.replace("-", "_")] = text;
      if (!name.includes("-")) given[`${name}_portrait`] = ""; // the file's own would hide this one
    }
  }
  return given;
}
