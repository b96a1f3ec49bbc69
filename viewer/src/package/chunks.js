/** Parts of the element that are loaded when they are needed. It replaces `chunks.js` in the npm package; other formats are in the worker. */

export const webgl = () => import("../render/webgl_chunk.js");
export const languages = async () => (await import("./languages.js")).languages();
export const extras = () => import("../viewer/extras.js");
export const xr = () => import("../viewer/xr.js");
