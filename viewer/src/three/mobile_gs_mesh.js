/** A sort-free scene as an object of three.js. */

import { Box3, BufferAttribute, BufferGeometry, Matrix4, Mesh, MeshBasicMaterial, Object3D, Ray, Sphere, Vector3 } from "three";
import { firstPose } from "../viewer/framing.js";
import { cameraOf } from "../viewer/pose.js";
import { bodyOf, boxOf, surfaceAlong } from "./ellipsoids.js";
import { joinScene } from "./scene_store.js";
import { dropMesh, drawMeshes, loadShaders } from "./stages.js";

/** @typedef {import("three").Camera} Camera */
/** @typedef {import("three").Frustum} Frustum */
/** @typedef {import("three").Intersection} Intersection */
/** @typedef {import("three").Raycaster} Raycaster */
/** @typedef {import("../viewer/vector.js").Vector} Vector */
/** @typedef {{floats: boolean, strips: boolean}} Variant as in render/types.js */
/**
 * @typedef {object} MobileGSMeshOptions
 * @property {string | URL} [url] of a `.mgs` file, which is loaded once for all meshes with this address
 * @property {Blob | BufferSource} [file] the file itself, in place of an address
 * @property {(share: number) => void} [onProgress] called with the share of the file, 0 to 1; NaN while its size is
 *     unknown
 * @property {(mesh: MobileGSMesh) => void} [onLoad] called when everything is decoded
 * @property {(error: Error) => void} [onError] called with the reason if it cannot be loaded or drawn
 * @property {AbortSignal} [signal] ends loading: `loaded` rejects with its reason, and `onError` is not called
 */

/**
 * A camera, in world units.
 *
 * @typedef {object} FirstView
 * @property {Vector3} position
 * @property {Vector3} target what it looks at, and turns around
 * @property {Vector3} up
 * @property {number} fov vertical field of view in degrees
 */

const inverse = new Matrix4();
const localRay = new Ray();
const inside = new Vector3();
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
  /** Factor of the opacity of the picture, 0 to 1. */
  opacity = 1;
  /** Gaussians whose means lie outside are not drawn; in the units of the scene; null: all are. @type {Box3 | null} */
  crop = null;
  /** Changes colours as displayed (sRGB): (r, g, b, 1) is multiplied by it; null: no change. @type {Matrix4 | null} */
  grade = null;
  /** Pixels that are drawn and averaged along a side of each pixel; null: as many as the training cameras suggest. @type {number | null} */
  supersampling = null;
  /** Smallest standard deviation at a coarser level, in its pixels; 0: all at full size; null: the usual one. @type {number | null} */
  levelSigma = null;
  /** The way to draw; null: the fastest on this device, which is measured once. @type {Variant | null} */
  variant = null;
  /** Resolves to the mesh when everything is decoded; rejects if it cannot be, or is disposed of before. @type {Promise<MobileGSMesh>} */
  loaded;
  /** Resolves when the fastest way to draw is known; measured after the first frame with the whole scene. @type {Promise<unknown>} */
  calibrated = Promise.resolve();
  /** Around the scene without its outliers, in its units; null until `computeBoundingBox`. @type {Box3 | null} */
  boundingBox = null;
  /** Around that box; null until `computeBoundingSphere`. @type {Sphere | null} */
  boundingSphere = null;

  #source;
  #store;
  #listener;
  #onError;
  /** Box and sphere that hold all Gaussians. @type {{box: Box3, sphere: Sphere} | null} */
  #whole = null;
  #end;
  #warned = false; // that exporters leave the Gaussians out
  #complete = false; // whether everything is decoded
  #left = false; // whether the store is left
  #stopped = false; // whether the page ended loading
  #failed = false; // whether it cannot be drawn
  #ready = false; // whether the shaders are loaded

  /** @param {MobileGSMeshOptions} options */
  constructor({ url, file, onProgress, onLoad, onError, signal }) {
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
    const blob = file instanceof Blob || !file ? file : new Blob([file]);
    this.#source = blob ?? new URL(/** @type {string} */ (url), globalThis.location?.href).href; // a worker has another base
    this.#listener = {
      progress: (/** @type {number} */ share) => onProgress?.(share),
      changed: () => this.#changed(),
      loaded: () => done(),
      failed: (/** @type {Error} */ error) => failed(error),
    };
    this.#store = joinScene(this.#source, this.#listener);
    this.userData = this.#watched({});
    this.#onError = onError;
    this.#end = failed;
    signal?.addEventListener("abort", () => this.#stop(signal.reason), { once: true });
    if (signal?.aborted) this.#stop(signal.reason);
    const shaders = loadShaders().then(() => (this.#ready = true));
    this.loaded = Promise.all([decoded, shaders]).then(() => {
      this.#complete = true;
      this.#changed();
      onLoad?.(this);
      return this;
    });
    // an error without a listener is an unhandled rejection
    if (onError) this.loaded.catch((error) => this.#stopped || onError(error));
  }

  /** Custom data whose listing, which only exporters do, tells once that they leave the Gaussians out. @param {Record<string, any>} data */
  #watched(data) {
    const ownKeys = () => {
      if (!this.#warned) console.warn("MobileGSMesh: its Gaussians are not exported, only an empty triangle: keep the .mgs file");
      this.#warned = true;
      return Reflect.ownKeys(data);
    };
    return new Proxy(data, { ownKeys });
  }

  /** Another mesh of the same scene, which is not loaded again. @param {boolean} [recursive] with its children @returns {any} */
  clone(recursive) {
    const source = this.#source;
    const made = new MobileGSMesh(typeof source === "string" ? { url: source } : { file: source });
    const warned = this.#warned;
    this.#warned = true; // three.js copies by listing
    Object3D.prototype.copy.call(made, this, recursive);
    this.#warned = warned;
    made.userData = made.#watched(made.userData);
    const { opacity, supersampling, levelSigma, variant, grade, crop, material } = this;
    Object.assign(made, { opacity, supersampling, levelSigma, variant });
    made.grade = grade?.clone() ?? null;
    made.crop = crop?.clone() ?? null;
    made.material.depthWrite = material.depthWrite;
    return made;
  }

  /** Number of Gaussians that are drawn. */
  get gaussians() {
    return this.data?.count ?? 0;
  }

  /** The packed scene; null before its first part is decoded. @internal */
  get data() {
    return this.#left ? null : this.#store.data;
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

  /** Notes of the file, such as `title` and `credit`. @returns {Record<string, string | number | boolean | null>} */
  get notes() {
    return this.#store.notes;
  }

  /** Upward direction that the file tells, in the axes of the scene; null if it tells none. (`up` is three.js' own.) @returns {Vector3 | null} */
  get upward() {
    return this.#store.up && new Vector3(...this.#store.up);
  }

  /**
   * The first view of the file, where the mesh stands: what its author chose, or else where the first photo was taken.
   *
   * @param {number} [aspect] width of the picture by its height
   * @returns {FirstView}
   */
  firstView(aspect = 1) {
    const { notes, views, up, near } = this.#store;
    const pose = firstPose({ notes, views, up, means: () => this.#store.means }, aspect, 1);
    const { fy } = cameraOf(pose, views[0] ?? null, aspect, 1, near);
    this.updateWorldMatrix(true, false);
    const [position, target] = [pose.eye, pose.target].map((at) => new Vector3(...at).applyMatrix4(this.matrixWorld));
    const upward = new Vector3(...pose.up).transformDirection(this.matrixWorld);
    return { position, target, up: upward, fov: (2 * Math.atan(0.5 / fy) * 180) / Math.PI };
  }

  /** Background colour of the file as it is displayed (sRGB), each from 0 to 1. @returns {[number, number, number] | null} */
  get background() {
    return this.data?.background ?? null;
  }

  /** True if there is something to draw. @internal */
  get drawable() {
    return this.#ready && !this.#failed && this.gaussians > 0 && this.opacity > 0;
  }

  /** True if everything is decoded. @internal */
  get complete() {
    return this.#complete;
  }

  /** Draw nothing from now on, because a renderer cannot. @internal @param {Error} error */
  fail(error) {
    this.#failed = true;
    if (this.#onError) this.#onError(error);
    else console.error(`MobileGSMesh: ${error.message}`);
  }

  /** Compute `boundingBox`, which is empty before Gaussians are here. */
  computeBoundingBox() {
    const { means, logits } = this.#store;
    this.boundingBox = boxFrom(this.data && bodyOf(this.data, means, logits));
    return this.boundingBox;
  }

  /** Compute `boundingSphere`, which is empty before Gaussians are here. */
  computeBoundingSphere() {
    const box = this.boundingBox ?? this.computeBoundingBox();
    this.boundingSphere = box.getBoundingSphere(new Sphere());
    return this.boundingSphere;
  }

  /** The box and the sphere that hold all Gaussians. */
  get #bounds() {
    if (this.#whole) return this.#whole;
    const box = boxFrom(this.data && boxOf(this.data, this.#store.means));
    return (this.#whole = { box, sphere: box.getBoundingSphere(new Sphere()) });
  }

  /** True if a part may be visible; three.js calls this. @internal @param {Frustum} frustum */
  intersectsFrustum(frustum) {
    return frustum.intersectsSphere(worldSphere.copy(this.#bounds.sphere).applyMatrix4(this.matrixWorld));
  }

  /**
   * Add the point where half of the ray's light is gone; `index` is that of the Gaussian, in the order of the file.
   *
   * @param {Raycaster} raycaster
   * @param {Intersection[]} intersects
   */
  raycast(raycaster, intersects) {
    if (!this.data) return;
    localRay.copy(raycaster.ray).applyMatrix4(inverse.copy(this.matrixWorld).invert());
    if (!localRay.intersectsBox(this.#bounds.box)) return;
    const { origin, direction } = localRay;
    const { means, logits } = this.#store;
    const { crop } = this;
    const isShown = (/** @type {Vector} */ mean) => !crop || crop.containsPoint(inside.set(...mean));
    const met = surfaceAlong(this.data, means, logits, origin.toArray(), direction.toArray(), isShown);
    if (met === null) return;
    const point = localRay.at(met.distance, new Vector3()).applyMatrix4(this.matrixWorld);
    const distance = raycaster.ray.origin.distanceTo(point);
    if (distance < raycaster.near || distance > raycaster.far) return;
    intersects.push({ distance, point, index: met.index, object: this });
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

  /** Stop loading and free everything, in all renderers. `loaded` rejects with an `AbortError` unless it is settled. */
  dispose() {
    this.removeFromParent();
    dropMesh(this);
    this.loaded.catch(() => {}); // nobody needs to wait for it
    this.#stop(new DOMException("the mesh was disposed of before it was loaded", "AbortError"));
    this.#leave();
    this.geometry.dispose();
    this.material.dispose();
  }

  /** @param {Error} reason */
  #stop(reason) {
    if (this.#complete) return;
    this.#stopped = true;
    this.#leave();
    this.#end(reason);
  }

  #leave() {
    this.#left = true;
    this.#store.leave(this.#listener);
  }

  #changed() {
    this.boundingBox = this.boundingSphere = this.#whole = null;
  }
}

/** @param {{min: Vector, max: Vector} | null} ends */
const boxFrom = (ends) => (ends ? new Box3(new Vector3(...ends.min), new Vector3(...ends.max)) : new Box3());
