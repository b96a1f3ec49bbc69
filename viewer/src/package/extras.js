/** Parts of the element that few visits need. It replaces `extras.js` in the npm package, which has no page and no benchmark. */

export { showNotes } from "../viewer/annotations.js";
export { flyTo } from "../viewer/camera_path.js";
export { qrCode } from "../viewer/qr.js";
export { Slotted } from "../viewer/slotted.js";
