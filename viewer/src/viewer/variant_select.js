/** Selects the fastest variant on this device: measured once per page and API, and stored. */

import { fastestVariant, knownVariant } from "../render/calibrate.js";
import { createRenderer } from "../render/create_renderer.js";

/** @typedef {import("../render/types.js").Variant} Variant */

/** Results by API. @type {Map<string, Promise<Variant>>} */
const found = new Map();

/** The fastest variant. Concurrent calls share one measurement. @param {"webgpu" | "webgl"} choice @returns {Promise<Variant>} */
export function selectVariant(choice) {
  const variant = found.get(choice) ?? measured(choice);
  found.set(choice, variant);
  return variant;
}

/** Measure with an invisible canvas. @param {"webgpu" | "webgl"} choice */
async function measured(choice) {
  const { renderer } = await createRenderer(document.createElement("canvas"), choice);
  try {
    return knownVariant(renderer, storage()) ?? (await fastestVariant(renderer, storage()));
  } finally {
    renderer.destroy();
  }
}

/** The page's storage; null where pages may not store data. */
export function storage() {
  try {
    return localStorage;
  } catch {
    return null;
  }
}
