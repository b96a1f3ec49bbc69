/** Creates the renderer: WebGPU, or else WebGL2. */

import { own, parsed } from "../assets.js";
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
      const shaders = await parsed(import("../wgsl.packed.js"));
      return { name: "WebGPU", renderer: await WebGpuRenderer.create(canvas, shaders) };
    } catch (error) {
      if (choice === "webgpu") throw error;
      without = error instanceof Error ? error.message : String(error);
    }
  }
  try {
    const [{ WebGlRenderer }, shaders] = await Promise.all([
      own(import("./webgl.js")),
      parsed(import("../glsl.packed.js")),
    ]);
    return { name: "WebGL2", renderer: WebGlRenderer.create(canvas, shaders) };
  } catch (error) {
    const also = error instanceof Error ? error.message : String(error);
    throw new Error(`this browser cannot draw the scene: ${without ? `${without}; ` : ""}${also}`);
  }
}
