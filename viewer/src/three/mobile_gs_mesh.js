/** A sort-free scene as an object of three.js. */

import { Box3, BufferAttribute, BufferGeometry, Matrix4, Mesh, MeshBasicMaterial, Ray, Sphere, Vector3 } from "three";
import { boxOf, surfaceAlong } from "./ellipsoids.js";
import { SceneStore } from "./scene_store.js";
import { dropMesh, drawMeshes, loadShaders } from "./stages.js";

/** @typedef {import("three").Camera} Camera */
/** @typedef {import("three").Frustum} Frustum */
/** @typedef {import("three").Intersection} Intersection */
/** @typedef {import("three").Object3D} Object3D */
/** @typedef {import("three").Raycaster} Raycaster */
/** @typedef {{floats: boolean, strips: boolean}} Variant as in render/types.js */
/**
 * @typedef {object} MobileGSMeshOptions
 * @property {string} [url] of a `.mgs` file
 * @property {Blob} [file] the file itself, in place of an address
 * @property {(share: number) => void} [onProgress] called with the share of the file, 0 to 1; NaN while its size is
 *     unknown
 * @property {(mesh: MobileGSMesh) => void} [onLoad] called when everything is decoded
 * @property {(error: Error) => void} [onError] called with the reason if it cannot be loaded or drawn
 */

const inverse = new Matrix4();
const localRay = new Ray();
const worldSphere = new Sphere();

/**
 * A scene of mobilegs in three.js, for WebGLRenderer and WebGPURenderer.
 *
 *     const mesh = new MobileGSMesh({ url: "scene.mgs" });
 *     scene.add(mesh);
 *     await mesh.loaded;
 *
 * Several meshes hide each other by their depths, pixel by pixel, and opaque meshes of three.js hide what is behind
 * them. It writes its own depth where transparent objects follow, and with `mesh.material.depthWrite = true` for effects.
 *
 * @extends {Mesh<BufferGeometry, MeshBasicMaterial>}
 */
export class MobileGSMesh extends Mesh {
  /** @readonly */
  isMobileGSMesh = true;
  /** Factor of the opacity of every Gaussian, 0 to 1. */
  opacity = 1;
  /** Changes colours as displayed (sRGB): (r, g, b, 1) is multiplied by it; null: no change. @type {Matrix4 | null} */
  grade = null;
  /** Pixels that are drawn and averaged along a side of each pixel; null: as many as the training cameras suggest. @type {number | null} */
  supersampling = null;
  /** Smallest standard deviation at a coarser level, in its pixels; 0: all at full size; null: the usual one. @type {number | null} */
  levelSigma = null;
  /** The way to draw; null: the fastest on this device, which is measured once. @type {Variant | null} */
  variant = null;
  /** Resolves to the mesh when everything is decoded. @type {Promise<MobileGSMesh>} */
  loaded;
  /** Resolves when the fastest way to draw is known; measured after the first frame with the whole scene. @type {Promise<unknown>} */
  calibrated = Promise.resolve();
  /** Around all Gaussians, in the units of the scene; null until `computeBoundingBox`. @type {Box3 | null} */
  boundingBox = null;
  /** Around all Gaussians, in the units of the scene; null until `computeBoundingSphere`. @type {Sphere | null} */
  boundingSphere = null;

  #store;
  #onError;
  #complete = false; // whether everything is decoded
  #failed = false; // whether it cannot be drawn
  #ready = false; // whether the shaders are loaded

  /** @param {MobileGSMeshOptions} options */
  constructor({ url, file, onProgress, onLoad, onError }) {
    const geometry = new BufferGeometry();
    // one triangle of no area: three.js draws nothing, and calls onBeforeRender
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(9), 3));
    const material = new MeshBasicMaterial({ transparent: true, depthTest: false, depthWrite: false, colorWrite: false });
    super(geometry, material);
    this.type = "MobileGSMesh";
    this.renderOrder = -1; // before other transparent objects, which may be tested against its depth
    if (!url && !file) throw new Error("MobileGSMesh needs the url of a .mgs file, or the file");
    /** @type {(value?: unknown) => void} */
    let done = () => {};
    /** @type {(error: Error) => void} */
    let failed = () => {};
    const decoded = new Promise((resolve, reject) => ([done, failed] = [resolve, reject]));
    const address = url && new URL(url, globalThis.location?.href).href; // a worker has another base
    this.#store = new SceneStore(address ? { url: address } : { file: /** @type {Blob} */ (file) }, {
      progress: (share) => onProgress?.(share),
      changed: () => this.#changed(),
      loaded: () => done(),
      failed: (error) => failed(error),
    });
    this.#onError = onError;
    const shaders = loadShaders().then(() => (this.#ready = true));
    this.loaded = Promise.all([decoded, shaders]).then(() => {
      this.#complete = true;
      this.#changed();
      onLoad?.(this);
      return this;
    });
    // an error without a listener is an unhandled rejection
    if (onError) this.loaded.catch(onError);
  }

  /** Number of Gaussians that are drawn. */
  get gaussians() {
    return this.data?.count ?? 0;
  }

  /** The packed scene; null before its first part is decoded. @internal */
  get data() {
    return this.#store.data;
  }

  /** Parts of `data` that have changed since it was set. @internal */
  get changes() {
    return this.#store.changes;
  }

  /** Training cameras of the file. @returns {import("../package/decode.js").MgsCamera[]} */
  get views() {
    return this.#store.views;
  }

  /** Gaussians that are nearer than this are not drawn, in the units of the scene. */
  get near() {
    return this.#store.near;
  }

  /** Background colour of the file as it is displayed (sRGB), each from 0 to 1. @returns {[number, number, number] | null} */
  get background() {
    return this.data?.background ?? null;
  }

  /** True if there is something to draw. */
  get drawable() {
    return this.#ready && !this.#failed && this.gaussians > 0 && this.opacity > 0;
  }

  /** True if everything is decoded. */
  get complete() {
    return this.#complete;
  }

  /** Draw nothing from now on, because a renderer cannot. @param {Error} error */
  fail(error) {
    this.#failed = true;
    if (this.#onError) this.#onError(error);
    else console.error(`MobileGSMesh: ${error.message}`);
  }

  /** Compute `boundingBox`, which is empty before Gaussians are here. */
  computeBoundingBox() {
    const box = this.data && boxOf(this.data, this.#store.means);
    this.boundingBox = box ? new Box3(new Vector3(...box.min), new Vector3(...box.max)) : new Box3();
    return this.boundingBox;
  }

  /** Compute `boundingSphere`, which is empty before Gaussians are here. */
  computeBoundingSphere() {
    const box = this.boundingBox ?? this.computeBoundingBox();
    this.boundingSphere = box.getBoundingSphere(new Sphere());
    return this.boundingSphere;
  }

  /** Whether a part may be visible; three.js calls this. @param {Frustum} frustum */
  intersectsFrustum(frustum) {
    const sphere = this.boundingSphere ?? this.computeBoundingSphere();
    return frustum.intersectsSphere(worldSphere.copy(sphere).applyMatrix4(this.matrixWorld));
  }

  /**
   * Add the point where half of the ray's light is gone.
   *
   * @param {Raycaster} raycaster
   * @param {Intersection[]} intersects
   */
  raycast(raycaster, intersects) {
    if (!this.data) return;
    localRay.copy(raycaster.ray).applyMatrix4(inverse.copy(this.matrixWorld).invert());
    if (!localRay.intersectsBox(this.boundingBox ?? this.computeBoundingBox())) return;
    const { origin, direction } = localRay;
    const { means, logits } = this.#store;
    const along = surfaceAlong(this.data, means, logits, origin.toArray(), direction.toArray(), this.opacity);
    if (along === null) return;
    const point = localRay.at(along, new Vector3()).applyMatrix4(this.matrixWorld);
    const distance = raycaster.ray.origin.distanceTo(point);
    if (distance < raycaster.near || distance > raycaster.far) return;
    intersects.push({ distance, point, object: this });
  }

  /**
   * Draw all meshes of the scene, if this is the first one of the render call; three.js calls this.
   *
   * @param {unknown} renderer
   * @param {Object3D} scene
   * @param {Camera} camera
   * @param {BufferGeometry} _geometry
   * @param {unknown} material
   */
  onBeforeRender = (renderer, scene, camera, _geometry, material) => {
    // passes for normals and depths replace the materials: there is nothing to draw in them
    const { overrideMaterial } = /** @type {import("three").Scene} */ (scene);
    if (material === this.material && !overrideMaterial) drawMeshes(this, renderer, scene, camera);
  };

  /** Stop loading and free everything, in all renderers. */
  dispose() {
    this.removeFromParent();
    dropMesh(this);
    this.#store.destroy();
    this.geometry.dispose();
    this.material.dispose();
    this.loaded.catch(() => {}); // it may never be decoded
  }

  #changed() {
    this.boundingBox = this.boundingSphere = null;
  }
}
