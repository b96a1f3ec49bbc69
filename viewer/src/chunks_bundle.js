/** Loads parts of the viewer from files beside `viewer.js`. It replaces `chunks.js` there and exports the same functions. */

/** The address of `viewer.js`, in the page and in its workers. */
const address = () =>
  globalThis.viewerAddress ??
  globalThis.document?.querySelector(/** @type {"script"} */ ('script[src*="viewer.js"]'))?.src ??
  location.href;

/** @param {string} name */
const load = async (name) => {
  try {
    return await import(new URL(CHUNKS[name], address()).href);
  } catch {
    throw new Error("the viewer's own files could not be loaded: reload the page");
  }
};

export const formats = () => load("formats");
export const webgl = () => load("webgl");
export const languages = () => load("languages");
export const extras = () => load("extras");
export const xr = () => load("xr");

// a worker that runs source text does not know where it is from
export const workerPrefix = () => `viewerAddress=${JSON.stringify(address())};`;
