/** The camera in the page's address, so that a link shows what its sender saw. */

import { Pose } from "./pose.js";

/** @typedef {import("./vector.js").Vector} Vector */

/** @param {Pose} pose @returns {string} for behind the # */
export function writePose({ eye, target, up }) {
  const text = (/** @type {Vector} */ vector) => vector.map((x) => Number(x.toPrecision(5))).join(",");
  return `eye=${text(eye)}&at=${text(target)}&up=${text(up)}`;
}

/** @param {string} hash with or without its # @returns {Pose | null} null if it holds none */
export function readPose(hash) {
  const fields = new URLSearchParams(hash.replace(/^#/, ""));
  const vectors = ["eye", "at", "up"].map((name) => (fields.get(name) ?? "").split(",").map(Number));
  if (vectors.some((vector) => vector.length !== 3 || !vector.every(Number.isFinite))) return null;
  const [eye, target, up] = /** @type {Vector[]} */ (vectors);
  if (eye.every((x, k) => x === target[k])) return null;
  return new Pose(eye, target, up);
}
