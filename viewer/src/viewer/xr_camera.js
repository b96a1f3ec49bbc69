/** Cameras of the eyes of a headset, from the matrices of WebXR. */

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("./xr_place.js").Place} Place */

/**
 * The camera of an eye. It has the scene's unit of length, so that depths and weights are those of training.
 *
 * @param {XRView} view
 * @param {{width: number, height: number}} size of its picture, pixels
 * @param {Place} place of the scene in the view's reference space
 * @param {number} depthNear of the session, metres
 * @returns {Camera}
 */
export function cameraOfEye({ projectionMatrix, transform }, { width, height }, place, depthNear) {
  return {
    viewmat: viewmatOf(transform.inverse.matrix, place),
    ...lensOf(projectionMatrix, width, height),
    width,
    height,
    near: depthNear / place.scale,
  };
}

/**
 * Focal lengths and principal point of a projection, which need not be symmetric. WebXR's matrices go column by
 * column, its y axis points up, and it looks along -z.
 *
 * @param {ArrayLike<number>} matrix
 * @param {number} width pixels
 * @param {number} height
 */
export function lensOf(matrix, width, height) {
  return {
    fx: (matrix[0] * width) / 2,
    fy: (matrix[5] * height) / 2,
    cx: ((1 - matrix[8]) * width) / 2,
    cy: ((1 + matrix[9]) * height) / 2,
  };
}

/**
 * World to camera in the scene's units, row by row, OpenCV axes.
 *
 * @param {ArrayLike<number>} view reference space to eye, column by column, metres
 * @param {Place} place
 */
function viewmatOf(view, { axes, scale, at }) {
  const rows = [1, -1, -1].map((sign, i) => {
    const row = [0, 1, 2].map((k) => sign * view[4 * k + i]);
    const turned = axes[0].map((_, j) => row[0] * axes[0][j] + row[1] * axes[1][j] + row[2] * axes[2][j]);
    const shift = row[0] * at[0] + row[1] * at[1] + row[2] * at[2] + sign * view[12 + i];
    return [...turned, shift / scale];
  });
  return [...rows.flat(), 0, 0, 0, 1];
}
