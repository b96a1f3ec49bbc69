/** What the worker of the npm package needs of `assets.js` and `chunks.js`, which it replaces there. */

/** Start a helper, which runs the same module. @returns {Worker} */
export function newWorker() {
  return new Worker(import.meta.url, { type: "module" });
}

export const formats = () => import("../load/formats.js");
