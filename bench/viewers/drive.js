/**
 * Drives one viewer along the plan's cameras, as an animation does, and measures it.
 *
 * The viewer is a module with `open(wishes)`, which resolves when the scene is loaded, with `canvas`,
 * `draw(camera)` and perhaps `about()`, what it draws with, `fragments()`, and `again()`, which opens the scene anew. `draw` lets the viewer do all that it
 * does in a frame of its own loop, sorting included, and resolves within that same animation frame
 * with the time at which the frame began.
 */

/**
 * @typedef {object} Camera
 * @property {number[]} viewmat 16 numbers, row by row: world to camera, OpenCV axes
 * @property {number} fx focal lengths in pixels; the principal point is central
 * @property {number} fy
 * @property {number} width pixels
 * @property {number} height
 * @property {number} near world units
 */
/** @typedef {{canvas: HTMLCanvasElement, draw: (camera: Camera) => Promise<number>,
 *   about?: () => string, fragments?: () => Promise<number[] | null>, again?: () => Promise<void>}} Viewer */
/** @typedef {Uint8ClampedArray} Picture */

const SAME = 50; // dB between pictures that count as one: our sums' order changes the last bit
const QUIET = 1000; // milliseconds that a viewer gets to sort before its picture may count as settled
const REPEATS = 2; // equal pictures in a row that a settled viewer must show
const PAUSE = 300; // milliseconds without a frame, so that workers and read-backs finish
const ASIDE = 30; // degrees of the turn before a picture: enough for every viewer to sort and colour again
const PATIENCE = 60; // frames

const wishes = Object.fromEntries(new URLSearchParams(location.search));
/** @type {{ring: Camera[]}} a full turn around the scene, a camera every degree */
const { ring } = await (await fetch("/plan.json")).json();
const { width, height } = ring[0];
const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
const stage = document.getElementById("stage");
stage.style.width = `${width}px`;
stage.style.height = `${height}px`;

/** @type {Viewer} */
let viewer;

const cameraAt = (/** @type {number} */ degrees) => ring[((degrees % 360) + 360) % 360];

/** Reads the canvas; call it before the frame that drew it ends. @returns {Picture} */
function pictureOf(/** @type {HTMLCanvasElement} */ canvas) {
  copy.fillRect(0, 0, width, height); // some canvases are transparent, and what was there shines through
  copy.drawImage(canvas, 0, 0);
  return copy.getImageData(0, 0, width, height).data;
}

/** Waits until the device has done what it was asked. @param {HTMLCanvasElement} canvas */
async function finished(canvas) {
  const gpu = canvas.getContext("webgpu");
  if (gpu) return gpu.getConfiguration().device.queue.onSubmittedWorkDone();
  const gl = canvas.getContext("webgl2");
  const [target, buffer] = [gl.READ_FRAMEBUFFER_BINDING, gl.PIXEL_PACK_BUFFER_BINDING].map((name) =>
    gl.getParameter(name),
  );
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
}

/** One frame, waited for. @param {number} degrees @param {boolean} seen whether its picture is wanted */
async function frame(degrees, seen) {
  const began = await viewer.draw(cameraAt(degrees));
  const picture = seen ? pictureOf(viewer.canvas) : null;
  await finished(viewer.canvas);
  const ended = performance.now();
  return { degrees, began, ended, picture };
}

/** @param {Picture} a @param {Picture} b @returns {number} dB */
function psnr(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i += 4) {
    for (let k = i; k < i + 3; k++) sum += (a[k] - b[k]) ** 2;
  }
  return 10 * Math.log10((255 ** 2 * 0.75 * a.length) / sum);
}

/**
 * Draws from one place until the picture stays, also when the viewer gets time between frames: with
 * frames that follow one another at once, a stale picture may stay for long.
 *
 * @param {number} degrees
 * @param {boolean} [hurried] whether frames follow one another at first, as in an animation
 * @returns {Promise<{picture: Picture, ended: number, frames: number, milliseconds: number}>} the last
 *     picture; when the first one like it was done, which frame that was, and how long it took
 */
async function settle(degrees, hurried = true) {
  const asked = performance.now();
  const seen = [];
  let [paused, alike] = [!hurried, 0];
  while (seen.length < PATIENCE) {
    if (paused) await new Promise((resolve) => setTimeout(resolve, PAUSE));
    seen.push(await frame(degrees, true));
    const last = seen[seen.length - 1];
    const first = seen.findLastIndex(({ picture }) => psnr(picture, last.picture) <= SAME) + 1;
    alike = first < seen.length - 1 ? alike + 1 : 0; // this picture is like the one before
    if (alike < REPEATS || last.ended - asked < QUIET) continue;
    if (paused) {
      const { ended } = seen[first];
      return { picture: last.picture, ended, frames: first + 1, milliseconds: ended - asked };
    }
    [paused, alike] = [true, 0];
  }
  throw new Error(`the picture was not still after ${PATIENCE} frames`);
}

/** @param {string} name @param {Picture} picture */
async function keep(name, picture) {
  await fetch(`/pictures/${name}`, { method: "POST", body: picture });
}

/** Opens the viewer. @returns {Promise<number>} milliseconds from navigation to the first right picture */
async function load() {
  const { open } = await import(`./${wishes.module}.js`);
  viewer = await open({ ...wishes, stage, camera: cameraAt(0) });
  const { picture, ended } = await settle(0);
  await keep("first", picture);
  return ended;
}

export const loaded = load();

/** The renderer and variant that the viewer uses, if it reports them. */
export const about = () => viewer.about?.() ?? null;

/** Fragments per pixel of the last frame by level, if the viewer counts them. */
export const fragments = async () => (await viewer.fragments?.()) ?? null;

/** Opens the scene anew, and draws it, some times. @param {number} times @returns {Promise<boolean>} whether the viewer can */
export async function again(times) {
  for (let i = 0; i < times && viewer.again; i++) {
    await viewer.again();
    await frame(i, false);
  }
  return Boolean(viewer.again);
}

/** A slow orbit. @param {number} frames @param {number} step degrees @returns {Promise<number[]>} */
export async function orbit(frames, step) {
  const times = [];
  for (let i = 1; i <= frames; i++) {
    const { began, ended } = await frame(i * step, false);
    times.push(ended - began);
  }
  return times;
}

/** Jumps of the camera. @param {number[]} places degrees, one after the other */
export async function jumps(places) {
  const found = [];
  for (const degrees of places) {
    const { frames, milliseconds } = await settle(degrees);
    found.push({ frames, milliseconds });
  }
  return found;
}

/**
 * A fast turn, from a settled start; the frames' pictures are kept.
 *
 * @param {string} name of the pictures
 * @param {number} frames
 * @param {number} step degrees from frame to frame
 * @param {number} speed degrees a second, instead of a step where it is above 0
 * @returns {Promise<{degrees: number, milliseconds: number}[]>}
 */
export async function turn(name, frames, step, speed) {
  await settle(0);
  const seen = [];
  const started = performance.now();
  for (let i = 1; i <= frames; i++) {
    const passed = (performance.now() - started) / 1000;
    if (speed * passed > 360) break;
    seen.push(await frame(speed > 0 ? Math.max(1, Math.round(speed * passed)) : i * step, true));
  }
  for (const { degrees, picture } of seen) await keep(`${name}/${degrees}`, picture);
  return seen.map(({ degrees, began, ended }) => ({ degrees, milliseconds: ended - began }));
}

/** The settled pictures of places, each come to from aside. @param {number[]} places degrees */
export async function references(places) {
  for (const degrees of places) {
    await frame(degrees + ASIDE, false);
    const { picture } = await settle(degrees, false);
    await keep(`settled/${degrees}`, picture);
  }
}
