/** GaussianSplats3D of mkkellogg, in three.js. */

import { SceneRevealMode, Viewer } from "@mkkellogg/gaussian-splats-3d";
import { WebGLRenderer } from "three";
import { place, threeCamera } from "./three-camera.js";

const SH_DEGREE = 2; // the highest it draws; by default it draws none

export async function open({ stage, scene, camera }) {
  const renderer = new WebGLRenderer({ antialias: false, precision: "highp" });
  renderer.setSize(camera.width, camera.height);
  stage.append(renderer.domElement);
  const taken = threeCamera(camera);
  place(taken, camera);
  const viewer = new Viewer({
    renderer,
    camera: taken,
    selfDrivenMode: false,
    useBuiltInControls: false,
    sphericalHarmonicsDegree: SH_DEGREE,
    sceneRevealMode: SceneRevealMode.Instant, // otherwise it fades in, and a part would be timed
  });
  await viewer.addSplatScene(scene, { showLoadingUI: false });
  const draw = (next) =>
    new Promise((resolve) => {
      requestAnimationFrame(() => {
        const began = performance.now();
        place(taken, next);
        viewer.update();
        viewer.render();
        resolve(began);
      });
    });
  return { canvas: renderer.domElement, draw };
}
