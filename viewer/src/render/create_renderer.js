/** Creates the renderer: WebGPU, or else WebGL2. */

import { shaderText } from "../assets.js";
import { webgl } from "../chunks.js";
import { WebGpuRenderer } from "./webgpu.js";

/** @typedef {WebGpuRenderer | import("./webgl.js").WebGlRenderer} Renderer */
/** @typedef {"auto" | "webgpu" | "webgl"} Choice */

/**
 * Create a renderer for a canvas without a context.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {Choice} choice
 * @returns {Promise<{name: "WebGPU" | "WebGL2", renderer: Renderer}>} rejects with an error message for visitors
 */
export async function createRenderer(canvas, choice) {
  let without = "";
  if (choice !== "webgl") {
    try {
      const shaders = await texts(WebGpuRenderer.files, shaderText);
      return { name: "WebGPU", renderer: await WebGpuRenderer.create(canvas, shaders) };
    } catch (error) {
      if (choice === "webgpu") throw error;
      without = error instanceof Error ? error.message : String(error);
    }
  }
  try {
    const { WebGlRenderer, shaderText } = await webgl();
    return { name: "WebGL2", renderer: WebGlRenderer.create(canvas, await texts(WebGlRenderer.files, shaderText)) };
  } catch (error) {
    const also = error instanceof Error ? error.message : String(error);
    throw new Error(`this browser cannot draw the scene: ${without ? `${without}; ` : ""}${also}`);
  }
}

/**
 * Load shaders, by file name without extension.
 *
 * @param {readonly string[]} files
 * @param {(file: string) => Promise<string>} load
 * @returns {Promise<Record<string, string>>}
 */
async function texts(files, load) {
  const pairs = files.map(async (file) => [file.replace(/\.[a-z]+$/, ""), await load(file)]);
  return Object.fromEntries(await Promise.all(pairs));
}
