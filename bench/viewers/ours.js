/**
 * Our own viewer: what `<mobile-gs>` begins and loads, with the way to draw named where that is
 * wished for. The element is imported for its bytes: pages ship it.
 */

import "/viewer/src/element.js";
import { Pose } from "/viewer/src/viewer/pose.js";
import { Viewer } from "/viewer/src/viewer/viewer.js";

/** @typedef {import("./drive.js").Camera} Camera */

/** @param {Camera} camera @returns {Pose} */
function poseOf({ viewmat: m }) {
  const eye = [0, 1, 2].map((k) => -(m[k] * m[3] + m[4 + k] * m[7] + m[8 + k] * m[11]));
  const target = eye.map((x, k) => x + m[8 + k]);
  return new Pose(eye, target, [-m[4], -m[5], -m[6]]);
}

export async function open({ stage, scene, api, sums, levels, camera }) {
  const canvas = document.createElement("canvas");
  Object.assign(canvas.style, { width: "100%", height: "100%" });
  stage.append(canvas);
  let [heard, seen] = [{ resolve: () => {}, reject: () => {} }, () => {}];
  const coming = () => new Promise((resolve, reject) => (heard = { resolve, reject }));
  const loaded = coming();
  const listener = {
    progress: () => {},
    loaded: () => heard.resolve(),
    failed: (_, sentence) => heard.reject(new Error(sentence)),
    drawn: () => seen(),
  };
  const variant = sums ? { floats: sums === "floats", strips: false } : null;
  const viewer = new Viewer(canvas, listener, { variant, levels: levels === undefined ? null : Number(levels) });
  viewer.scale = 1;
  let [now, began] = [camera, NaN];
  // the field of view is the scene's own otherwise, and a .ply has none
  viewer.camera = (width, height) => {
    began = performance.now();
    return { ...now, width, height, cx: width / 2, cy: height / 2 };
  };
  viewer.place(poseOf(now));
  const { href } = new URL(scene, location.href);
  if (await viewer.begin(api)) viewer.load({ url: href });
  await loaded;
  await viewer.calibrated;
  // frames are asked for one by one; a new order would ask for one of its own between two of them
  const redraw = viewer.redraw.bind(viewer);
  viewer.redraw = () => {};
  const draw = (next) =>
    new Promise((resolve) => {
      seen = () => resolve(began);
      now = next;
      viewer.place(poseOf(next));
      redraw();
    });
  const about = () => {
    const { renderer, adapter, variant } = viewer.device;
    return [renderer, adapter, variant].join(", ");
  };
  const again = () => {
    const next = coming();
    viewer.load({ url: href });
    return next;
  };
  return { canvas, draw, about, again, fragments: () => viewer.fragments() };
}
