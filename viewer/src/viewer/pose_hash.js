/** The camera in the URL's fragment, so that links keep the view. */

import { Pose } from "./pose.js";
import { length, minus } from "./vector.js";

/** @typedef {import("./vector.js").Vector} Vector */

/** @param {Pose} pose @returns {string} the fragment without # */
export function poseToHash({ eye, target, up }) {
  // precision: a ten-thousandth of the distance to the target
  const digits = Math.min(20, Math.max(0, Math.ceil(4 - Math.log10(length(minus(target, eye))))));
  const text = (/** @type {Vector} */ vector, most = digits) => vector.map((x) => Number(x.toFixed(most))).join(",");
  return `eye=${text(eye)}&at=${text(target)}&up=${text(up, 5)}`;
}

/** @param {string} hash with or without its # @returns {Pose | null} null if there is no pose */
export function poseFromHash(hash) {
  const fields = new URLSearchParams(hash.replace(/^#/, ""));
  const vectors = ["eye", "at", "up"].map((name) => (fields.get(name) ?? "").split(",").map(Number));
  if (vectors.some((vector) => vector.length !== 3 || !vector.every(Number.isFinite))) return null;
  const [eye, target, up] = /** @type {Vector[]} */ (vectors);
  if (eye.every((x, k) => x === target[k])) return null;
  return new Pose(eye, target, up);
}
