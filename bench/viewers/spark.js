/** Spark, in three.js. */

import { SparkRenderer, SplatMesh } from "@sparkjsdev/spark";
import { Scene, WebGLRenderer } from "three";
import { place, threeCamera } from "./three-camera.js";

export async function open({ stage, scene: url, camera }) {
  const renderer = new WebGLRenderer({ antialias: false });
  renderer.setSize(camera.width, camera.height);
  stage.append(renderer.domElement);
  const scene = new Scene();
  // the blur that 3DGS trains with; the default is for scenes trained with anti-aliasing
  scene.add(new SparkRenderer({ renderer, preBlurAmount: 0.3, blurAmount: 0 }));
  const mesh = new SplatMesh({ url });
  scene.add(mesh);
  await mesh.initialized;
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
