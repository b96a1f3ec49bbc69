/** The levels of sort-free scenes: targets of a half, a quarter and an eighth of the image's size. */

/** @typedef {import("../mgs/header.js").Footprint} Footprint */

export const LEVELS = 4; // as in view.wgsl and view.glsl
export const PASS_LEVEL = 2; // the picture of the depth pass has the size of this level's target

/**
 * The `levelSigma` that a scene is drawn with; `usual_level_sigma` in mobilegs/render/levels.py. Without a
 * soft edge, ellipses end in a step, which coarse targets show.
 *
 * @param {Footprint | undefined} footprint
 */
export function usualLevelSigma(footprint) {
  return footprint?.soft_edge ? 1 : 1.4;
}

/**
 * Width and height of the targets of all levels; `level_sizes` in mobilegs/render/levels.py.
 *
 * @param {number} width
 * @param {number} height
 */
export function levelSizes(width, height) {
  const sizes = [[width, height]];
  for (let level = 1; level < LEVELS; level++) {
    sizes.push(sizes[level - 1].map((side) => ((side - (level === 1 ? 0 : 1)) >> 1) + 2));
  }
  return sizes;
}

/**
 * First pixels of the targets in one texture that has them all, and that texture's size: level 0, and the
 * others one below the other on its right; `level_places` in mobilegs/render/levels.py.
 *
 * @param {number} width
 * @param {number} height
 */
export function levelPlaces(width, height) {
  const [, ...coarse] = levelSizes(width, height);
  const places = [[0, 0]];
  let row = 0;
  for (const [, rows] of coarse) {
    places.push([width, row]);
    row += rows;
  }
  return { places, size: [width + coarse[0][0], Math.max(height, row)] };
}
