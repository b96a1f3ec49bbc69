/** three.js' own splats, an addon that draws with WebGPURenderer. */

import { GaussianSplatPLYLoader } from "three/addons/loaders/GaussianSplatPLYLoader.js";
import { GaussianSplat } from "three/addons/objects/GaussianSplat.js";
import { Color, LinearSRGBColorSpace, Scene, WebGPURenderer } from "three/webgpu";
import { place, threeCamera } from "./three-camera.js";

export async function open({ stage, scene: url, camera }) {
  const renderer = new WebGPURenderer({ antialias: false });
  await renderer.init();
  if (!renderer.backend.isWebGPUBackend) throw new Error("there is no webgpu here");
  renderer.outputColorSpace = LinearSRGBColorSpace; // splats are sRGB already
  renderer.setSize(camera.width, camera.height);
  stage.append(renderer.domElement);
  const scene = new Scene();
  scene.background = new Color(0, 0, 0);
  scene.add(new GaussianSplat(await new GaussianSplatPLYLoader().loadAsync(url)));
  const taken = threeCamera(camera);
  const draw = (next) =>
    new Promise((resolve) => {
      requestAnimationFrame(() => {
        const began = performance.now();
        place(taken, next);
        renderer.render(scene, taken);
        resolve(began);
      });
    });
  return { canvas: renderer.domElement, draw };
}
