/** The camera of three.js in the training units of a mesh, and the uniforms of a frame. */

import { Matrix4, Vector3 } from "three";
import { magnified, viewUniforms } from "../render/view_uniforms.js";

/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("three").Camera} ThreeCamera */
/** @typedef {import("three").Mesh & {opacity: number, grade: Matrix4 | null}} Drawn */
/**
 * How a frame is drawn; the same for all meshes of a scene.
 *
 * @typedef {object} Frame
 * @property {ThreeCamera} camera
 * @property {number} width pixels
 * @property {number} height
 * @property {boolean} upward whether rows are counted from below, as WebGL does
 * @property {number} supersampling
 * @property {number} weightScale
 */

const view = new Matrix4();
const eye = new Vector3();
const NONE = /** @type {[number, number, number]} */ ([0, 0, 0]);

/** The depth at which the nearness of a fragment is 1, world units. @param {ThreeCamera} camera */
export function nearestOf(camera) {
  const { near } = /** @type {{near?: number}} */ (/** @type {unknown} */ (camera));
  return near && near > 0 ? near : 0.1;
}

/** Focal lengths and principal point in pixels. @param {Frame} frame */
export function lensOf({ camera, width, height, upward }) {
  const p = camera.projectionMatrix.elements;
  return {
    fx: 0.5 * width * p[0],
    fy: 0.5 * height * p[5],
    cx: 0.5 * width * (1 - p[8]),
    cy: 0.5 * height * (upward ? 1 - p[9] : 1 + p[9]),
  };
}

/**
 * The uniforms of a mesh in a frame.
 *
 * Rows of the view matrix are divided by the scale of the mesh, so that depths are in training units. The
 * projection does not change, even if the axes are scaled differently.
 *
 * @param {Frame} frame
 * @param {Drawn} mesh
 * @param {SceneData} scene
 * @param {number} near of the scene, training units
 * @param {number} levelSigma
 * @returns {Float32Array<ArrayBuffer>}
 */
export function meshUniforms(frame, mesh, scene, near, levelSigma) {
  const { camera, width, height, upward, supersampling, weightScale } = frame;
  view.multiplyMatrices(camera.matrixWorldInverse, mesh.matrixWorld);
  const scale = Math.cbrt(Math.abs(view.determinant())) || 1;
  const e = view.elements;
  const row = (/** @type {number} */ i, /** @type {number} */ sign) =>
    [e[i], e[i + 4], e[i + 8], e[i + 12]].map((value) => (sign * value) / scale);
  const viewmat = [...row(0, 1), ...row(1, upward ? 1 : -1), ...row(2, -1), 0, 0, 0, 1];
  const seen = magnified({ viewmat, ...lensOf(frame), width, height, near }, supersampling);
  const floats = viewUniforms({ ...scene, background: NONE }, seen, weightScale, levelSigma, supersampling);
  eye.set(0, 0, 0).applyMatrix4(view.invert());
  floats.set([eye.x, eye.y, eye.z], 12);
  floats[70] = nearestOf(camera) / scale;
  floats[71] = 1 - Math.min(Math.max(mesh.opacity, 0), 1);
  if (mesh.grade) {
    const g = mesh.grade.elements;
    for (let i = 0; i < 3; i++) {
      const factors = [g[i], g[i + 4], g[i + 8], g[i + 12]];
      factors[i] -= 1; // the shader adds
      floats.set(factors, 72 + 4 * i);
    }
  }
  return floats;
}
