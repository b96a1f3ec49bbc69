/** The PlayCanvas engine, which SuperSplat's viewer is made of. */

import {
  AppBase, AppOptions, Asset, CameraComponentSystem, Color, Entity, FILLMODE_NONE,
  GSplatComponentSystem, GSplatHandler, Mat4, Quat, RESOLUTION_FIXED, TONEMAP_NONE,
  createGraphicsDevice,
} from "playcanvas"; // prettier-ignore

const FAR = 1000;

/** @param {Entity} entity @param {import("./drive.js").Camera} camera */
function place(entity, { viewmat: m }) {
  // its camera looks along -z, y up, and matrices lie column by column
  const view = new Mat4();
  const signs = [1, -1, -1, 1];
  view.data.set(m.map((_, i) => signs[i % 4] * m[4 * (i % 4) + Math.floor(i / 4)]));
  const world = view.clone().invert();
  entity.setPosition(world.getTranslation());
  entity.setRotation(new Quat().setFromMat4(world));
}

export async function open({ stage, scene, api, stochastic, camera }) {
  const { width, height, fy, near } = camera;
  const canvas = document.createElement("canvas");
  stage.append(canvas);
  const device = await createGraphicsDevice(canvas, {
    deviceTypes: [api === "webgpu" ? "webgpu" : "webgl2"],
    antialias: false,
  });
  if (device.isWebGPU !== (api === "webgpu")) throw new Error(`there is no ${api} here`);
  const app = new AppBase(canvas);
  const options = new AppOptions();
  options.graphicsDevice = device;
  options.componentSystems = [CameraComponentSystem, GSplatComponentSystem];
  options.resourceHandlers = [GSplatHandler];
  app.init(options);
  app.autoRender = false; // frames are asked for one by one
  app.setCanvasFillMode(FILLMODE_NONE, width, height);
  app.setCanvasResolution(RESOLUTION_FIXED, width, height);
  app.start();
  app.scene.gsplat.stochastic = Boolean(stochastic);

  const asset = new Asset("scene", "gsplat", { url: scene });
  await new Promise((resolve, reject) => {
    asset.once("load", resolve);
    asset.once("error", (reason) => reject(new Error(reason)));
    app.assets.add(asset);
    app.assets.load(asset);
  });
  const splats = new Entity();
  splats.addComponent("gsplat", { asset });
  app.root.addChild(splats);
  const eye = new Entity();
  eye.addComponent("camera", {
    clearColor: new Color(0, 0, 0),
    fov: (2 * Math.atan(height / (2 * fy)) * 180) / Math.PI,
    nearClip: near,
    farClip: FAR,
    toneMapping: TONEMAP_NONE,
  });
  app.root.addChild(eye);
  const draw = (next) =>
    new Promise((resolve) => {
      let began = NaN;
      app.once("frameupdate", () => {
        began = performance.now();
        place(eye, next);
      });
      app.once("frameend", () => resolve(began));
      app.renderNextFrame = true;
    });
  return { canvas, draw };
}
