/** The camera of three.js in the training units of a mesh, and the uniforms of a frame. */

import { Matrix4, Vector3 } from "three";
import { levelPlaces, usualLevelSigma } from "../render/levels.js";
import { hasDepthPass } from "../render/types.js";
import { float16Scale, magnified, viewUniforms } from "../render/view_uniforms.js";
import { supersamplingFor } from "../viewer/supersampling.js";

/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {import("three").Camera} ThreeCamera */
/** @typedef {import("three").Mesh & {opacity: number, grade: Matrix4 | null, crop: import("three").Box3 | null}} Drawn */
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
 * @property {number} typicalDepth of all scenes with a depth pass, world units; 0: each has its own
 */

/** Most layers of a picture. */
export const MOST_LAYERS = 8;

/** True if a mesh's scene is drawn with a depth pass. @param {import("./mobile_gs_mesh.js").MobileGSMesh} mesh */
export const passes = ({ data }) => data !== null && hasDepthPass(data);

/** World units of a unit of a mesh's scene. @param {import("three").Object3D} mesh */
const scaleOf = ({ matrixWorld }) => Math.cbrt(Math.abs(matrixWorld.determinant())) || 1;

const view = new Matrix4();
const eye = new Vector3();
const NONE = /** @type {[number, number, number]} */ ([0, 0, 0]);

/** The depth at which the nearness of a fragment is 1, world units. @param {ThreeCamera} camera */
export function nearestOf(camera) {
  const { near } = /** @type {{near?: number}} */ (/** @type {unknown} */ (camera));
  return near && near > 0 ? near : 0.1;
}

/** Focal lengths and principal point in pixels. @param {Frame} frame */
function lensOf({ camera, width, height, upward }) {
  const p = camera.projectionMatrix.elements;
  return {
    fx: 0.5 * width * p[0],
    fy: 0.5 * height * p[5],
    cx: 0.5 * width * (1 - p[8]),
    cy: 0.5 * height * (upward ? 1 - p[9] : 1 + p[9]),
  };
}

/**
 * Settings with which meshes are drawn together: the frame, its size with supersampling, the standard deviation of the
 * levels of each mesh (0: all at full size), and whether there are levels, which one texture must hold.
 *
 * @param {import("./mobile_gs_mesh.js").MobileGSMesh[]} meshes
 * @param {ThreeCamera} camera
 * @param {Pick<Frame, "width" | "height" | "upward">} picture
 * @param {boolean} floats whether sums are float32
 * @param {number} most pixels along a side of a texture
 */
export function frameOf(meshes, camera, picture, floats, most) {
  const passing = meshes.filter(passes);
  const weightScale = floats ? 1 : float16Scale(passing.length > 0);
  // of several in one layer, depths are compared in the world
  const [first] = meshes.length > MOST_LAYERS ? passing : [];
  const typicalDepth = first ? scaleOf(first) * (first.data?.weighting.sigma ?? 1) : 0;
  /** @type {Frame} */
  const frame = { camera, ...picture, supersampling: 1, weightScale, typicalDepth };
  const lens = { ...lensOf(frame), ...picture, viewmat: [], near: 0 };
  frame.supersampling = Math.max(...meshes.map((mesh) => mesh.supersampling ?? supersamplingFor(lens, mesh.views)));
  const fine = { width: frame.supersampling * picture.width, height: frame.supersampling * picture.height };
  const wanted = meshes.map((mesh) => mesh.levelSigma ?? usualLevelSigma(mesh.data?.footprint));
  const leveled = Math.max(...levelPlaces(fine.width, fine.height).size) <= most && Math.max(...wanted) > 0;
  return { frame, fine, sigmas: wanted.map((sigma) => (leveled ? sigma : 0)), leveled };
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
  const { camera, width, height, upward, supersampling, weightScale, typicalDepth } = frame;
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
  if (typicalDepth && hasDepthPass(scene)) floats[30] = typicalDepth / scale;
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
  if (mesh.crop) floats.set([...mesh.crop.min.toArray(), 1, ...mesh.crop.max.toArray()], 84);
  return floats;
}
