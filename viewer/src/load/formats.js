/** The readers of other formats than `.mgs`. */

export { readPly } from "./ply.js";
export { readSpz } from "./spz.js";
