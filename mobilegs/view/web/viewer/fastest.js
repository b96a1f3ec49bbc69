/** How this device draws fastest: found out once, and remembered. */

import { fastestVariant } from "../render/calibrate.js";
import { chooseRenderer } from "../render/choose.js";

/** @typedef {import("../render/types.js").Variant} Variant */

/** By API, for all of the page. @type {Map<string, Promise<Variant>>} */
const found = new Map();

/** Not by several at a time. @param {"webgpu" | "webgl"} choice @returns {Promise<Variant>} */
export function fastestHere(choice) {
  const variant = found.get(choice) ?? measured(choice);
  found.set(choice, variant);
  return variant;
}

/** With a renderer that nobody sees. @param {"webgpu" | "webgl"} choice */
async function measured(choice) {
  const { renderer } = await chooseRenderer(document.createElement("canvas"), choice);
  try {
    return await fastestVariant(renderer, storage());
  } finally {
    renderer.destroy();
  }
}

/** What this page remembers of the device; null where pages may not. */
export function storage() {
  try {
    return localStorage;
  } catch {
    return null;
  }
}
