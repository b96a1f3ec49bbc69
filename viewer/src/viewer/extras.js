/** Parts of the element that few visits need. */

export { showNotes } from "./annotations.js";
export { flyTo } from "./camera_path.js";
export { followCamera } from "./follow.js";
export { makeJoystick } from "./joystick.js";
export { Split } from "./split.js";
export { FrameStats } from "./stats.js";
export { Slotted } from "./slotted.js";
export { save } from "./share.js";
export { svgCode } from "./qr.js";
