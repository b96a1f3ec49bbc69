/** Elements in step: one takes the camera of another. */

/** @typedef {import("../element.js").MobileGs} MobileGs */
/** @typedef {import("./pose.js").Pose} Pose */

/**
 * Follow the camera of the element whose id the attribute `follow` names, also of one that comes later.
 *
 * @param {MobileGs} element
 * @param {AbortSignal} signal ends it
 * @param {(pose: Pose, origin: MobileGs) => void} place takes a pose, and the element whose camera was moved
 */
export function followCamera(element, signal, place) {
  const id = element.getAttribute("follow");
  if (!id) return;
  const root = /** @type {Document} */ (element.getRootNode());
  /** @param {MobileGs} leader @param {MobileGs} origin */
  const take = (leader, origin) => {
    // two elements may follow each other
    if (origin !== element && leader.viewer?.count) place(leader.viewer.pose.copy(), origin);
  };
  root.addEventListener("camera", (event) => {
    const leader = /** @type {MobileGs} */ (event.target);
    if (leader.id === id) take(leader, /** @type {CustomEvent} */ (event).detail.origin);
  }, { signal });
  const leader = /** @type {MobileGs | null} */ (root.getElementById(id));
  if (leader) take(leader, leader);
}
