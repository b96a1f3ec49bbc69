/** The shaders of the npm package. */

import { unpacked } from "./unpacked.js";

/** The texts of the shaders by file. @type {Promise<Record<string, string>> | undefined} */
let shaders;

/** @param {string} file @returns {Promise<string>} */
export async function shaderText(file) {
  shaders ??= unpacked(PACKED_SHADERS).then((text) => JSON.parse(text));
  return (await shaders)[file];
}
