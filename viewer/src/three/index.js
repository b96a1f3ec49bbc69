/** `mobilegs/three`: sort-free scenes in three.js, which the page brings itself. */

export { MobileGSMesh } from "./mobile_gs_mesh.js";

/** @typedef {import("./mobile_gs_mesh.js").MobileGSMeshOptions} MobileGSMeshOptions */
/** @typedef {import("./mobile_gs_mesh.js").FirstView} FirstView */
