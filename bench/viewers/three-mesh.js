/** MobileGSMesh in three.js, alone in a scene. */

import { MobileGSMesh } from "/viewer/src/three/index.js";
import { Scene, WebGLRenderer } from "three";
import { place, threeCamera } from "./three-camera.js";

export async function open({ stage, scene: url, api, camera }) {
  let renderer;
  if (api === "webgpu") {
    const { WebGPURenderer } = await import("three/webgpu");
    renderer = new WebGPURenderer({ antialias: false });
    await renderer.init();
    if (!renderer.backend.isWebGPUBackend) throw new Error("there is no webgpu here");
  } else {
    renderer = new WebGLRenderer({ antialias: false });
  }
  renderer.setSize(camera.width, camera.height);
  stage.append(renderer.domElement);
  const scene = new Scene();
  /** @type {MobileGSMesh} */
  let mesh;
  const again = async () => {
    mesh?.removeFromParent().dispose();
    scene.add((mesh = new MobileGSMesh({ url })));
    await mesh.loaded;
  };
  await again();
  const taken = threeCamera(camera);
  place(taken, camera);
  renderer.render(scene, taken);
  await mesh.calibrated; // the fastest way to draw, as in the viewer
  const draw = (next) =>
    new Promise((resolve) => {
      requestAnimationFrame(() => {
        const began = performance.now();
        place(taken, next);
        renderer.render(scene, taken);
        resolve(began);
      });
    });
  return { canvas: renderer.domElement, draw, again };
}
