/**
 * Parts of the viewer that are loaded when they are needed. `chunks_bundle.js` replaces this module in
 * `viewer.js`, whose parts are files of their own; `mobile-gs.js` contains them.
 */

/** The readers of other formats than `.mgs`. */
export const formats = () => import("./load/formats.js");

/** The WebGL2 renderer and its shaders. */
export const webgl = () => import("./render/webgl_chunk.js");

/** The texts in other languages than English. */
export const languages = () => import("./viewer/languages.js");

/** The benchmark, QR codes, annotations and camera paths. */
export const extras = () => import("./viewer/extras.js");

/** Sessions of WebXR, where the device offers them. */
export const xr = () => import("./viewer/xr.js");

/** JavaScript that a worker runs before the viewer's script. */
export const workerPrefix = () => "";
