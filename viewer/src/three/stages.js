/** Finds the meshes of a render call, and draws them together. */

import { parsed } from "../assets.js";
import { Frustum, Matrix4, Vector3 } from "three";
import { selectVariant } from "../viewer/variant_select.js";
import { MOST_LAYERS } from "./placed_camera.js";
import { WebGlStage } from "./webgl_stage.js";
import { WebGpuStage } from "./webgpu_stage.js";

/** @typedef {import("three").Camera} Camera */
/** @typedef {import("three").Material} Material */
/** @typedef {import("three").Object3D} Object3D */
/** @typedef {any} AnyRenderer WebGLRenderer, or WebGPURenderer, whose types are in `three/webgpu` */
/** @typedef {import("./mobile_gs_mesh.js").MobileGSMesh} MobileGSMesh */
/**
 * @typedef {object} Call
 * @property {number} frame
 * @property {Camera} camera
 * @property {unknown} target
 */

/**
 * What draws in a renderer.
 *
 * @typedef {object} Drawing
 * @property {WebGlStage | WebGpuStage} stage
 * @property {Call | null} call the render call that it drew in last
 * @property {boolean} measured whether the fastest way to draw is known, or being measured
 */

/** @type {Promise<unknown> | null} */
let loading = null;
/** Shaders by name. @type {Record<string, string>[]} */
let [glsl, wgsl] = /** @type {Record<string, string>[]} */ ([]);

/** By renderer. @type {Map<AnyRenderer, Drawing>} */
const stages = new Map();
let warned = false; // of an orthographic camera
const frustum = new Frustum();
const projection = new Matrix4();
const [eye, middle] = [new Vector3(), new Vector3()];

/** Load the shaders once. */
export function loadShaders() {
  loading ??= Promise.all([
    parsed(import("../glsl.packed.js")),
    parsed(import("../wgsl.packed.js")),
  ]).then((texts) => ([glsl, wgsl] = texts));
  return loading;
}

/**
 * Draw all meshes of a scene, unless another one of them has done so in this render call.
 *
 * @param {MobileGSMesh} mesh
 * @param {AnyRenderer} renderer
 * @param {Object3D} scene
 * @param {Camera} camera
 */
export function drawMeshes(mesh, renderer, scene, camera) {
  if (!mesh.drawable) return;
  if (camera.projectionMatrix.elements[15] !== 0) {
    if (!warned) console.warn("MobileGSMesh is drawn by perspective cameras only, and this one is orthographic");
    warned = true;
    return;
  }
  const known = stageOf(mesh, renderer);
  if (!known) return;
  const target = renderer.getRenderTarget();
  const frame = renderer.isWebGPURenderer ? renderer.info.calls : renderer.info.render.frame;
  const last = known.call;
  if (last && last.frame === frame && last.camera === camera && last.target === target) return;
  known.call = { frame, camera, target };
  const found = visibleIn(rootOf(mesh, scene), camera);
  const meshes = found.meshes.filter((one) => {
    const refusal = known.stage.refusal(one);
    if (refusal) one.fail(new Error(refusal));
    return !refusal;
  });
  if (!meshes.length) return;
  // without a clear, an earlier render call may have written depths
  const tested = found.others || !renderer.autoClear || !renderer.autoClearDepth;
  const keeps = found.transparent || meshes.some((one) => one.material.depthWrite);
  known.stage.draw(layersOf(meshes, camera), camera, { tested, keeps });
  if (known.measured || meshes[0].variant || !meshes.every(({ complete }) => complete)) return;
  known.measured = true;
  const calibrated = selectVariant(known.stage.api).then(
    (variant) => (known.stage.variant = variant),
    () => {}, // a device that fails here also fails when it draws
  );
  for (const one of meshes) one.calibrated = calibrated;
}

/** Free the resources of a mesh in all renderers. @param {MobileGSMesh} mesh */
export function dropMesh(mesh) {
  for (const [renderer, { stage }] of stages) {
    stage.forget(mesh);
    if (!stage.empty) continue;
    stage.destroy();
    stages.delete(renderer);
  }
}

/** What draws in a renderer; null if it cannot. @param {MobileGSMesh} mesh @param {AnyRenderer} renderer */
function stageOf(mesh, renderer) {
  const known = stages.get(renderer);
  if (known) return known;
  try {
    const made = { stage: newStage(renderer), call: null, measured: false };
    stages.set(renderer, made);
    renderer.domElement.addEventListener("webglcontextlost", () => stages.delete(renderer), { once: true });
    return /** @type {Drawing} */ (made);
  } catch (error) {
    mesh.fail(error instanceof Error ? error : new Error(String(error)));
    return null;
  }
}

/** @param {AnyRenderer} renderer */
function newStage(renderer) {
  if (!renderer.isWebGPURenderer) return new WebGlStage(renderer, glsl);
  if (renderer.backend.isWebGPUBackend) return new WebGpuStage(renderer, wgsl);
  throw new Error("WebGPURenderer has no WebGPU in this browser: use WebGLRenderer here");
}

/** The scene of a mesh; three.js gives another one if it renders an object without one. @param {MobileGSMesh} mesh @param {Object3D} scene */
function rootOf(mesh, scene) {
  /** @type {Object3D} */
  let root = mesh;
  while (root.parent && root !== scene) root = root.parent;
  return root;
}

/**
 * The meshes that a camera may see, whether anything else may have written a depth, and whether anything transparent is
 * tested against depths later.
 *
 * @param {Object3D} root
 * @param {Camera} camera
 */
function visibleIn(root, camera) {
  /** @type {MobileGSMesh[]} */
  const meshes = [];
  let [others, transparent] = [false, false];
  projection.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const { reversedDepth } = /** @type {{reversedDepth?: boolean}} */ (/** @type {unknown} */ (camera));
  frustum.setFromProjectionMatrix(projection, camera.coordinateSystem, reversedDepth);
  root.traverseVisible((object) => {
    if (!object.layers.test(camera.layers)) return;
    const mesh = /** @type {MobileGSMesh} */ (object);
    if (!mesh.isMobileGSMesh) {
      const all = materialsOf(object);
      others ||= all.some(({ visible, depthWrite }) => visible && depthWrite);
      transparent ||= all.some((one) => one.visible && one.transparent && one.depthTest);
    } else if (mesh.drawable && mesh.material.visible && (!mesh.frustumCulled || mesh.intersectsFrustum(frustum))) meshes.push(mesh);
  });
  return { meshes, others, transparent };
}

/**
 * The meshes of each layer of a picture: one each; the farthest of many share the last layer, blended as one.
 *
 * @param {MobileGSMesh[]} meshes
 * @param {Camera} camera
 */
function layersOf(meshes, camera) {
  if (meshes.length <= MOST_LAYERS) return meshes.map((mesh) => [mesh]);
  eye.setFromMatrixPosition(camera.matrixWorld);
  const distance = (/** @type {MobileGSMesh} */ mesh) => {
    const { center } = mesh.boundingSphere ?? mesh.computeBoundingSphere();
    return middle.copy(center).applyMatrix4(mesh.matrixWorld).distanceTo(eye);
  };
  const order = meshes.map((mesh) => ({ mesh, at: distance(mesh) })).sort((a, b) => a.at - b.at);
  const sorted = order.map(({ mesh }) => mesh);
  const near = sorted.slice(0, MOST_LAYERS - 1).map((mesh) => [mesh]);
  return [...near, sorted.slice(MOST_LAYERS - 1)];
}

/** @param {Object3D} object */
function materialsOf(object) {
  const { material } = /** @type {{material?: Material | Material[]}} */ (object);
  return material ? [material].flat() : [];
}
