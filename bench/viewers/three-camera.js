/** The plan's cameras in three.js, whose camera looks along -z, y up. */

import { Matrix4, PerspectiveCamera } from "three";

/** @typedef {import("./drive.js").Camera} Camera */

const FAR = 1000;

/** @param {Camera} camera @returns {PerspectiveCamera} */
export function threeCamera({ fy, width, height, near }) {
  const degrees = (2 * Math.atan(height / (2 * fy)) * 180) / Math.PI;
  return new PerspectiveCamera(degrees, width / height, near, FAR);
}

/** @param {PerspectiveCamera} taken @param {Camera} camera whose place it takes */
export function place(taken, { viewmat }) {
  const world = new Matrix4().set(...viewmat).invert();
  world.multiply(new Matrix4().makeScale(1, -1, -1));
  world.decompose(taken.position, taken.quaternion, taken.scale);
  taken.updateMatrixWorld(true);
}
