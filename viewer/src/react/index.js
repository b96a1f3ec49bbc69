/**
 * Entry point `mobilegs/react`: `<mobile-gs>` as a component.
 *
 *     <MobileGS src="scene.mgs" autorotate style={{ height: "60vh" }}>
 *       <Annotation at={[0, 1, 0]}>The door</Annotation>
 *     </MobileGS>
 *
 * On a server it renders the tags. The viewer is loaded in the browser, after hydration.
 */

import { createElement, forwardRef, useCallback, useEffect, useRef } from "react";

/** @import { CameraChange, MobileGs } from "../element.js" */
/** @typedef {[number, number, number]} Point world units */
/** @typedef {{at: Point, text: string, eye?: Point}} Dot a numbered dot that opens a text, and where the camera flies */
/**
 * @typedef {object} OwnProps
 * @property {string} [src] address of a `.mgs`, `.ply` or `.spz`
 * @property {string} [compare] address of a second scene behind a handle, or `sorted`
 * @property {string} [camera] the camera, as the event `camera` has it
 * @property {string} [follow] id of another element, whose camera this one takes
 * @property {Dot[]} [annotations] in place of those in the file
 * @property {string} [path] camera path, in place of that in the file
 * @property {boolean} [autoplay] whether the camera follows the path until the first input
 * @property {boolean} [autorotate] whether the scene turns until the first input
 * @property {boolean} [noui] whether there are no buttons, title or hint
 * @property {boolean} [polite] whether the page scrolls by wheel and by one finger
 * @property {boolean} [free] whether visitors may move anywhere
 * @property {boolean} [lazy] whether loading starts when the element is nearly in sight
 * @property {string} [poster] address of a picture to show until the scene appears
 * @property {string} [background] a CSS colour
 * @property {number} [fov] degrees
 * @property {"x" | "-x" | "y" | "-y" | "z" | "-z"} [up] the axis that points up
 * @property {string} [start] first view
 * @property {string} [startPortrait] first view on high screens
 * @property {string} [limits] limits of the camera
 * @property {string} [heading] title
 * @property {string} [credit] whom to thank
 * @property {string} [alt] description for screen readers
 * @property {"auto" | "webgpu" | "webgl"} [renderer]
 * @property {number} [scale] share of the screen's resolution
 * @property {number} [levels]
 * @property {string} [variant]
 * @property {(detail: {milliseconds: number, bytes: number}) => void} [onLoad] the whole scene is decoded
 * @property {(detail: {sentence: string}) => void} [onError] the scene cannot be shown
 * @property {(detail: CameraChange) => void} [onCamera] the camera has moved
 * @property {(detail: import("../viewer/stats.js").Stats) => void} [onFrame] a frame was drawn
 */
/** @typedef {OwnProps & Omit<import("react").HTMLAttributes<MobileGs>, keyof OwnProps>} MobileGSProps */
/** @typedef {{at: Point} & import("react").HTMLAttributes<HTMLDivElement>} AnnotationProps */

/** Names of attributes that differ from their property's. @type {Record<string, string>} */
const NAMES = { startPortrait: "start-portrait", className: "class" };
/** Properties with `true` and `false`. */
const SWITCHES = new Set(["autoplay", "autorotate", "noui", "polite", "free"]);
const EVENTS = { onLoad: "load", onError: "error", onCamera: "camera", onFrame: "frame" };

/**
 * `<mobile-gs>` with its attributes as properties. The ref is the element.
 *
 * @type {import("react").ForwardRefExoticComponent<MobileGSProps & import("react").RefAttributes<MobileGs>>}
 */
export const MobileGS = forwardRef(function MobileGS(/** @type {MobileGSProps} */ props, outer) {
  const latest = useRef(props);
  /** Ends listening to the element. */
  const listening = useRef(new AbortController());
  useEffect(() => {
    latest.current = props;
  });
  useEffect(() => {
    void import("../element.js");
  }, []);
  const ref = useCallback((/** @type {MobileGs | null} */ element) => {
    listening.current.abort();
    const { signal } = (listening.current = new AbortController());
    for (const [property, kind] of Object.entries(EVENTS)) {
      element?.addEventListener(kind, (event) => {
        if (event.target !== element) return; // of an element inside an annotation
        const { [/** @type {keyof typeof EVENTS} */ (property)]: listener } = latest.current;
        listener?.(/** @type {any} */ (event).detail);
      }, { signal });
    }
    if (typeof outer === "function") return outer(element);
    if (outer) outer.current = element;
  }, [outer]);
  return createElement("mobile-gs", { ...attributesOf(props), ref });
});

/**
 * HTML over the scene, which follows a point of it in world units.
 *
 * @param {AnnotationProps} props
 * @returns {import("react").ReactElement}
 */
export function Annotation({ at, ...rest }) {
  return createElement("div", { slot: "annotation", "data-at": at.join(" "), ...rest });
}

/** The attributes that React sets on the element. @param {Record<string, any>} props */
function attributesOf(props) {
  /** @type {Record<string, any>} */
  const attributes = {};
  for (const [name, value] of Object.entries(props)) {
    if (name in EVENTS || value === undefined || value === null) continue;
    if (SWITCHES.has(name)) {
      if (value) attributes[name] = "";
    } else if (name === "lazy") {
      if (value) attributes.loading = "lazy";
    } else attributes[NAMES[name] ?? name] = name === "annotations" ? JSON.stringify(value) : value;
  }
  return attributes;
}
