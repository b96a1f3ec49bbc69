/** Reads a scene away from the page's own thread, sends it on as it arrives, and sorts if needed. */

import { readScene } from "../mgs/reader.js";
import { packRows, packScene, packedParts } from "../render/pack.js";
import { farFirst } from "./order.js";
import { isPly, readPly } from "./ply.js";
import { isSpz, readSpz } from "./spz.js";

/** @typedef {import("../mgs/header.js").View} View */
/** @typedef {import("../render/types.js").Numbers} Numbers */
/** @typedef {import("../render/types.js").Part} Part */
/** @typedef {import("../render/types.js").SceneData} SceneData */
/** @typedef {{url: string} | {file: Blob} | {forward: [number, number, number]}} Request */
/**
 * @typedef {{kind: "scene", data: SceneData, centers: Float32Array<ArrayBuffer>, views: View[], near: number}
 *   | {kind: "rows", part: Part, from: number, numbers: Numbers}
 *   | {kind: "order", order: Uint32Array<ArrayBuffer>}
 *   | {kind: "progress", received: number, total: number}
 *   | {kind: "done", milliseconds: number}
 *   | {kind: "failed", sentence: string}} Message
 */

const NEAR = 0.2; // of a scene that does not say
const NETWORK =
  "this scene asks a network for every Gaussian in every frame, which no viewer does: train it " +
  "with --set student.view.kind=fitted";

/** Of a sorted scene. */
let centers = new Float32Array(0);

/** @param {Message} message @param {Transferable[]} [moved] */
const send = (message, moved = []) => self.postMessage(message, { transfer: moved });

/**
 * @param {SceneData} data
 * @param {Float32Array<ArrayBuffer>} centers
 * @param {View[]} views
 * @param {number} near
 */
function sendScene(data, centers, views, near) {
  const moved = [data.shapes.buffer, data.colors.buffer, data.lobes.buffer];
  send({ kind: "scene", data, centers, views, near }, [...moved, centers.buffer]);
}

/**
 * @param {{url: string} | {file: Blob}} request
 * @returns {Promise<{source: ReadableStream<Uint8Array<ArrayBuffer>>, total: number}>}
 */
async function bytesOf(request) {
  if ("file" in request) return { source: request.file.stream(), total: request.file.size };
  let response;
  try {
    response = await fetch(request.url);
  } catch {
    throw new Error(`${request.url} cannot be reached: is the address right, and the network there?`);
  }
  if (!response.ok || response.body === null) {
    throw new Error(`${request.url} could not be loaded: the server says ${response.status}`);
  }
  return { source: response.body, total: Number(response.headers.get("Content-Length")) || NaN };
}

/** @param {ReadableStream<Uint8Array>} source */
async function loadMgs(source) {
  let known = false;
  await readScene(source, (reader, { changed, from, to }) => {
    send({ kind: "progress", received: reader.received, total: reader.total });
    const { header, scene } = reader;
    if (header === null || scene === null) return;
    if (header.network) throw new Error(NETWORK);
    if (!known) {
      known = true;
      sendScene(packScene(header, scene), scene.means.slice(), header.views, header.near);
      return;
    }
    for (const part of packedParts(changed)) {
      const numbers = packRows(scene, part, from, to);
      send({ kind: "rows", part, from, numbers }, [numbers.buffer]);
    }
  });
}

/**
 * A plain scene, which is read when all of it is there.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 * @param {number} total bytes
 * @param {(bytes: Uint8Array<ArrayBuffer>) => SceneData | Promise<SceneData>} read
 */
async function loadPlain(source, total, read) {
  const pieces = [];
  let received = 0;
  const reader = source.getReader();
  for (let piece; !(piece = await reader.read()).done; ) {
    pieces.push(piece.value);
    received += piece.value.length;
    send({ kind: "progress", received, total });
  }
  const data = await read(new Uint8Array(await new Blob(pieces).arrayBuffer()));
  centers = new Float32Array(3 * data.count);
  for (let i = 0; i < centers.length; i++) centers[i] = data.shapes[4 * i + 3];
  sendScene(data, centers.slice(), [], NEAR);
}

/**
 * The first piece of a stream, and a stream that begins with it all the same.
 *
 * @param {ReadableStream<Uint8Array<ArrayBuffer>>} source
 */
async function peeked(source) {
  const reader = source.getReader();
  const { value: first = new Uint8Array(0) } = await reader.read();
  const whole = new ReadableStream({
    start: (to) => to.enqueue(first),
    pull: async (to) => {
      const { value, done } = await reader.read();
      if (done) to.close();
      else to.enqueue(value);
    },
    cancel: () => reader.cancel(),
  });
  return { first, whole };
}

/** @param {{url: string} | {file: Blob}} request */
async function load(request) {
  const started = performance.now();
  const { source, total } = await bytesOf(request);
  const { first, whole } = await peeked(source);
  if (isPly(first)) await loadPlain(whole, total, readPly);
  else if (isSpz(first)) await loadPlain(whole, total, readSpz);
  else await loadMgs(whole);
  send({ kind: "done", milliseconds: performance.now() - started });
}

self.onmessage = async ({ data }) => {
  if ("forward" in data) {
    const order = farFirst(centers, data.forward);
    send({ kind: "order", order }, [order.buffer]);
    return;
  }
  try {
    await load(data);
  } catch (error) {
    send({ kind: "failed", sentence: error instanceof Error ? error.message : String(error) });
  }
};
