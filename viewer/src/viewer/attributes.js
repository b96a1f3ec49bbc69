/**
 * Passes the attributes of `<mobile-gs>` on to its viewer.
 *
 * Attributes:
 *
 * - `src`: URL of a .mgs, .ply or .spz file
 * - `compare`: URL of a second scene, which a handle uncovers; or `sorted`, the same scene rendered sorted
 * - `renderer`: auto, webgpu or webgl
 * - `variant`: how it renders, instead of the fastest way: floats (or halves) and strips (or batches)
 * - `levels`: large Gaussians are added up in smaller targets, if their least standard deviation there is so
 *   many pixels, 0.6 to 100; `0` draws all at full size; by default 1, or 1.4 without soft edges
 * - `scale`: share of the screen's resolution, instead of one chosen by the frame time
 * - `background`: a CSS colour instead of the scene's own
 * - `fov`: field of view in degrees
 * - `up`: the axis of the scene that points up: x, -x, y, -y, z or -z; or the direction `X Y Z` of a scene whose file
 *   tells none; by default as the file or its cameras tell
 * - `start` and `start-portrait`: first view on wide and on high screens, in place of the file's notes of these
 *   names, with eight numbers: eye, target, tangents of half the width and height that must be in the picture
 * - `camera`: the camera, in the form of a page's fragment (`eye=x,y,z&at=x,y,z&up=x,y,z`); also a property
 * - `follow`: id of another element, whose camera this one takes
 * - `limits`: limits of the camera in place of the file's note; `free`: none
 * - `autorotate`: rotates the scene until the first input, within the limits
 * - `annotations` and `path`: in place of the file's notes of these names
 * - `autoplay`: follows that path until the first input
 * - `editable`: for the editor (edit.js), which can hide Gaussians and shows annotations itself
 * - `noui`: hides the buttons, the title and the hint
 * - `heading` and `credit`: the scene's title and whom to thank, instead of those in the file
 * - `lang`: language of the interface, instead of that of the page or of the visitor
 * - `poster`: URL of an image to show until the scene appears; empty if a style of the page shows one
 * - `loading`: with the value lazy, loading starts when the element is nearly in sight
 * - `alt`: description of the scene for screen readers
 * - `polite`: the page scrolls by wheel and by one finger; Ctrl and wheel, or two fingers, zoom
 * - `linkable`: with `page` or viewer.js, the address may name another scene, `compare`, `poster`, `heading` and
 *   `credit` too: whoever makes a link decides what the page shows
 * - `page`: the element is a whole page, whose address names options and the view (in `mobile-gs.js`)
 */

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

/** Make attributes properties, unless there are such. @param {HTMLElement} prototype @param {string[]} observed */
export function reflect(prototype, observed) {
  const others = "poster path renderer levels variant loading autoplay noui polite";
  for (const name of [...observed, ...others.split(" ")]) {
    const property = name.replace("-p", "P");
    if (property in prototype) continue;
    const isSwitch = /^(auto|noui|polite|free)/.test(name);
    Object.defineProperty(prototype, property, {
      /** @this {HTMLElement} */
      get() {
        const text = this.getAttribute(name);
        return isSwitch ? text !== null : (text ?? "");
      },
      /** @this {HTMLElement} @param {unknown} value React sets the text of a switch */
      set(value) {
        if (isSwitch ? !value && value !== "" : value == null) this.removeAttribute(name);
        else this.setAttribute(name, isSwitch ? "" : String(value));
      },
    });
  }
}
