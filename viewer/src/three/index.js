/** `mobilegs/three`: sort-free scenes in three.js, which the page brings itself. */

export { MobileGSMesh } from "./mobile_gs_mesh.js";
