/** Parts of the page that few visits need. */

export { showNotes } from "./annotations.js";
export { flyTo } from "./camera_path.js";
export { Slotted } from "./slotted.js";
export { parsePlan, runBench } from "./bench.js";
export { qrCode } from "./qr.js";
export { showReport } from "./report.js";
