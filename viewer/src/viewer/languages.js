/** The texts in other languages than English, which are loaded when they are needed. */

export { de, es, ja, zh } from "./texts.js";
