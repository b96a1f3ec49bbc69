/** Parts of the page that few visits need. */

export { showNotes } from "./annotations.js";
export { parsePlan, runBench } from "./bench.js";
export { qrCode } from "./qr.js";
