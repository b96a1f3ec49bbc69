/** Chooses how many pixels are rendered in place of one, where the picture is smaller than those of training. */

/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/types.js").Camera} Camera */

const MOST = 4; // pixels in place of one, along a side
const SIDE_MAX = 4096; // pixels of a picture that is rendered to be averaged

/**
 * The number n, 1 to 4, at which the camera has about the focal length of the training cameras; 1 without
 * any. Same formula: supersampling_for in mobilegs/render/supersampling.py.
 *
 * @param {Camera} camera
 * @param {View[]} views training cameras at the size of training, of which the first counts
 */
export function supersamplingFor({ fx, fy, width, height }, views) {
  if (views.length === 0) return 1;
  const trained = Math.sqrt(views[0].K[0] * views[0].K[4]);
  const most = Math.min(MOST, Math.floor(SIDE_MAX / Math.max(width, height)));
  return Math.max(1, Math.min(Math.floor(trained / Math.sqrt(fx * fy) + 0.5), most));
}
