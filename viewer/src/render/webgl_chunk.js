/** The WebGL2 renderer with its shaders, which is loaded where there is no WebGPU. */

export { shaderText } from "../assets.js";
export { WebGlRenderer } from "./webgl.js";
