/**
 * The page of `mobilegs train --live`: frames that the training renders, and the cameras of its photos.
 *
 * It posts its camera and gets the newest frame, with the state of the training.
 */

import { visible } from "./viewer/localize.js";
import { Input } from "./viewer/input.js";
import { Pose, cameraOf } from "./viewer/pose.js";

/** @typedef {import("./mgs/header.js").View & {name: string}} Photo */
/** @typedef {{modes: string[], up: import("./viewer/vector.js").Vector, extent: number, photos: Photo[]}} About */
/**
 * @typedef {object} State
 * @property {boolean} paused
 * @property {[string, string][]} rows names and values
 * @property {number} seen number of the newest frame
 * @property {number} nearest photo
 * @property {number[] | null} camera of the frame: its matrix, focal length and height; null for a photo
 */

const MOVING = 40; // milliseconds between two requests while the camera moves
const RESTING = 200;
const PATIENCE = 20000; // milliseconds until an answer
const LOST = 2000; // before the next attempt to reach the training
const FRUSTUM = 0.04; // depth of a drawn camera, in extents of the scene
const NEAR_CLICK = 14; // pixels around a camera's place
const ORANGE = "#fa9632";
const CHOOSE = "choose one";

/** @template {Element} T @param {string} selector @returns {T} */
const one = (selector) => /** @type {T} */ (document.querySelector(selector));
const canvas = /** @type {HTMLCanvasElement} */ (one("canvas"));
const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
const rows = /** @type {HTMLElement} */ (one("dl"));
const pauseButton = /** @type {HTMLButtonElement} */ (one("#pause"));
const modes = /** @type {HTMLSelectElement} */ (one("#mode"));
const withCameras = /** @type {HTMLInputElement} */ (one("#cameras"));
const photoList = /** @type {HTMLSelectElement} */ (one("#photos"));

/** @type {About} */
const { photos, up, extent, ...about } = await (await fetch("photos")).json();
const visitor = Math.floor(Math.random() * 2 ** 52);
let pose = poseOf(0);
/** @type {State | null} */
let state = null;
/** @type {ImageBitmap | null} */
let frame = null;
let movedAt = 0;
/** True if the canvas must be painted again. */
let changed = true;

/** The pose of a photo's camera, from where the whole photo is in the picture. @param {number} index */
function poseOf(index) {
  const made = Pose.fromViews(photos, index, up);
  const { K, width, height } = photos[index];
  made.box = [width / (2 * K[0]), height / (2 * K[4])];
  return made;
}

function moved() {
  movedAt = performance.now();
}

/** @param {number} index */
function goTo(index) {
  pose = poseOf(index);
  photoList.selectedIndex = index + 1;
  moved();
}

/** @param {string} address @param {unknown} content @returns {Promise<Response>} */
async function post(address, content) {
  const headers = { "Content-Type": "application/json" };
  const signal = AbortSignal.timeout(PATIENCE);
  try {
    return await fetch(address, { method: "POST", headers, body: JSON.stringify(content), signal });
  } catch {
    throw new Error("not reached: it has ended, or its machine is away");
  }
}

/** The camera of the canvas, in device pixels. */
function camera() {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
  return cameraOf(pose, null, width, height, 0);
}

/** Post the camera, and take the answer. */
async function look() {
  const { viewmat, fx: focal, width, height } = camera();
  const seen = state?.seen ?? 0;
  const answer = await post("look", { visitor, seen, mode: modes.value, viewmat, focal, width, height });
  if (answer.status === 404) throw new Error("another training runs at this address: open the one that it printed");
  if (!answer.ok) throw new Error((await answer.json()).error);
  const bytes = await answer.arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const next = /** @type {State} */ (JSON.parse(new TextDecoder().decode(bytes.slice(4, 4 + length))));
  if (bytes.byteLength > 4 + length) {
    const image = await createImageBitmap(new Blob([bytes.slice(4 + length)]));
    frame?.close();
    frame = image;
  }
  state = next; // with its frame: the cameras are drawn as the frame was seen
  changed = true;
  say(state.rows);
  pauseButton.textContent = state.paused ? "Resume" : "Pause";
}

/** @param {[string, string][]} lines */
function say(lines) {
  const text = lines.flat().join("\n");
  if (rows.dataset.text === text) return;
  rows.dataset.text = text;
  rows.replaceChildren(
    ...lines.flatMap(([name, value]) => {
      const made = [document.createElement("dt"), document.createElement("dd")];
      [made[0].textContent, made[1].textContent] = [visible(name), visible(value)];
      return made;
    }),
  );
}

/** The frame, with the cameras of the photos in it. */
function paint() {
  const { width, height } = camera();
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  else if (!changed) return;
  changed = false;
  context.fillStyle = "#171717";
  context.fillRect(0, 0, width, height);
  if (frame === null) return;
  const scale = Math.min(width / frame.width, height / frame.height);
  const [w, h] = [frame.width * scale, frame.height * scale];
  context.drawImage(frame, (width - w) / 2, (height - h) / 2, w, h);
  context.strokeStyle = context.fillStyle = ORANGE;
  context.lineWidth = 1.5 * devicePixelRatio;
  if (!withCameras.checked || !state?.camera) return;
  photos.forEach((photo, index) => {
    const corners = frustum(photo).map(project);
    context.beginPath();
    for (const [a, b] of EDGES) {
      const [from, to] = [corners[a], corners[b]];
      if (from === null || to === null) continue;
      context.moveTo(from[0], from[1]);
      context.lineTo(to[0], to[1]);
    }
    context.stroke();
    const place = placeOf(index);
    if (place === null) return;
    context.beginPath();
    context.arc(place[0], place[1], 4 * devicePixelRatio, 0, 2 * Math.PI);
    context.fill();
  });
}

/** Corners of `frustum` that lines join. */
const EDGES = [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1]]; // prettier-ignore

/** A camera's place and the corners of its picture in the world. @param {Photo} photo */
function frustum({ viewmat: m, K, width, height }) {
  const depth = FRUSTUM * extent;
  const [x, y] = [(depth * width) / (2 * K[0]), (depth * height) / (2 * K[4])];
  return [[0, 0, 0], [-x, -y, depth], [x, -y, depth], [x, y, depth], [-x, y, depth]].map((at) => {
    const [a, b, c] = at.map((value, row) => value - m[4 * row + 3]);
    return [0, 1, 2].map((k) => m[k] * a + m[4 + k] * b + m[8 + k] * c);
  });
}

/** A point in pixels of the canvas, as the frame was seen; null behind the camera. @param {number[]} point */
function project(point) {
  const m = state?.camera;
  if (!m) return null;
  const [x, y, z] = [0, 1, 2].map((row) => m[4 * row] * point[0] + m[4 * row + 1] * point[1] + m[4 * row + 2] * point[2] + m[4 * row + 3]);
  if (z < 1e-3 * extent) return null;
  const focal = (m[16] * canvas.height) / m[17];
  return [canvas.width / 2 + (focal * x) / z, canvas.height / 2 + (focal * y) / z];
}

/** Pixels of a photo's camera, which a click takes. @param {number} index */
const placeOf = (index) => project(frustum(photos[index])[0]);

/** The photo whose camera is drawn under the pointer, or -1. @param {PointerEvent} event */
function cameraUnder({ offsetX, offsetY }) {
  if (!withCameras.checked) return -1;
  const away = photos.map((_, index) => {
    const place = placeOf(index);
    return place ? Math.hypot(place[0] / devicePixelRatio - offsetX, place[1] / devicePixelRatio - offsetY) : Infinity;
  });
  const nearest = away.indexOf(Math.min(...away));
  return away[nearest] < NEAR_CLICK ? nearest : -1;
}

const input = new Input(canvas, {
  pose: () => pose,
  mode: () => "orbit",
  held: () => {},
  changed() {
    photoList.selectedIndex = 0; // the camera is at no photo any more
    moved();
  },
  focus: () => {},
});

/** Place of the last press of a pointer, in CSS pixels. */
let pressed = [0, 0];
canvas.addEventListener("pointerdown", (event) => (pressed = [event.offsetX, event.offsetY]));
canvas.addEventListener("pointerup", (event) => {
  const still = event.isPrimary && event.button === 0 && Math.hypot(event.offsetX - pressed[0], event.offsetY - pressed[1]) < 4;
  const index = still ? cameraUnder(event) : -1;
  if (index >= 0) goTo(index);
});
canvas.addEventListener("pointermove", (event) => (canvas.style.cursor = cameraUnder(event) >= 0 ? "pointer" : ""));
pauseButton.onclick = () => void post("pause", { paused: !state?.paused }).catch(() => {}); // `follow` says why
withCameras.onchange = () => (changed = true);
modes.append(...about.modes.map((name) => new Option(name)));
modes.onchange = moved;
photoList.append(...[CHOOSE, ...photos.map(({ name }) => visible(name))].map((name) => new Option(name)));
photoList.onchange = () => photoList.selectedIndex && goTo(photoList.selectedIndex - 1);
one("#nearest").addEventListener("click", () => state && goTo(state.nearest));
one("#start").addEventListener("click", () => goTo(0));

async function follow() {
  for (;;) {
    let pause = performance.now() - movedAt < 500 ? MOVING : RESTING;
    try {
      if (document.visibilityState === "visible") await look();
    } catch (error) {
      say([["training", /** @type {Error} */ (error).message]]);
      pause = LOST;
    }
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
}

/** @param {number} before milliseconds */
function animate(before) {
  requestAnimationFrame((now) => {
    input.advance((now - before) / 1000);
    paint();
    animate(now);
  });
}
animate(performance.now());
void follow();
