/**
 * The viewer's readers under watch, as readers.py has ours: scenes or sentences, at a fair price.
 *
 * Each line of its input asks for a batch, `{"kind", "path", "every", "seconds"}`: a file of rows (u32
 * length, bytes). Each gets a line in answer: a list of null (a scene), a sentence, or `{"error"}`. One
 * in `every` scenes is decoded to the last number, and one in `every` files opened in pieces, too; none
 * may take more `seconds` of processor time.
 *
 * With `"coverage": true` the answer is `{verdicts, novel, blocks}`: which inputs reached code of the viewer
 * that none before them did, and how many blocks of it all inputs have reached.
 */

import { readFileSync, writeFileSync } from "node:fs";
import { createInterface } from "node:readline";

import { readPly } from "../../viewer/src/load/ply.js";
import { readSpz } from "../../viewer/src/load/spz.js";
import { SceneError } from "../../viewer/src/mgs/error.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { pieces, randomNumbers } from "../web/pieces.js";
import { sceneOf } from "../web/whole.js";
import { Coverage } from "./coverage.js";

const SENTENCE = 300; // characters
const FREE = 96 << 20; // bytes in addition to twice the file and the scene: garbage is collected late
const PARTS = ["means", "logScales", "quats", "sh", "lobes"];
const PLAIN = ["shapes", "colors", "lobes"];
const random = randomNumbers(1);

/** @type {Coverage | null} */
let coverage = null;

for await (const line of createInterface({ input: process.stdin })) {
  const { kind, path, every, seconds, coverage: guided } = JSON.parse(line);
  if (guided && !coverage) await (coverage = new Coverage()).start();
  /** @type {number[]} */
  const novel = [];
  const found = await verdicts(kind, rowsOf(path), every, seconds, novel);
  const answer = guided ? { verdicts: found, novel, blocks: coverage?.blocks } : found;
  process.stdout.write(`${JSON.stringify(answer)}\n`);
}

/** @param {string} path of a file of rows */
function rowsOf(path) {
  const data = new Uint8Array(readFileSync(path));
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const rows = [];
  for (let start = 0; start < data.length; ) {
    const end = start + 4 + view.getUint32(start, true);
    rows.push(data.slice(start + 4, end));
    start = end;
  }
  return rows;
}

/**
 * @param {string} kind @param {Uint8Array<ArrayBuffer>[]} inputs @param {number} every @param {number} seconds
 * @param {number[]} novel gets the numbers of inputs that reached new code
 */
async function verdicts(kind, inputs, every, seconds, novel) {
  const found = [];
  let largest = 0;
  const before = memory("VmRSS", true);
  for (const [i, bytes] of inputs.entries()) {
    const begun = performance.now();
    const { size, verdict } = await opened(kind, bytes, i % every === 0);
    found.push(verdict);
    if (await coverage?.grew()) novel.push(i);
    largest = Math.max(largest, size + bytes.length);
    if (performance.now() - begun < 1000 * seconds) continue;
    // a busy machine, or a slow reader?
    const used = process.cpuUsage();
    await opened(kind, bytes, i % every === 0);
    const { user, system } = process.cpuUsage(used);
    if (user + system > 1e6 * seconds) found[i] = { error: `took ${(user + system) / 1e6} s` };
  }
  if (memory("VmHWM", false) - before < FREE + 2 * largest) return found;
  for (const [i, bytes] of inputs.entries()) {
    const start = memory("VmRSS", true);
    const { size } = await opened(kind, bytes, i % every === 0);
    const peak = memory("VmHWM", false) - start;
    if (peak > FREE + 2 * (size + bytes.length)) found[i] = { error: `took ${peak >> 20} MiB for ${size} bytes` };
  }
  return found;
}

/** Bytes that the process has (`VmRSS`), or the most it has had since the last reset (`VmHWM`). */
function memory(name, reset) {
  if (reset) writeFileSync("/proc/self/clear_refs", "5");
  const text = readFileSync("/proc/self/status", "latin1");
  return 1024 * Number(new RegExp(`${name}:\\s*(\\d+)`).exec(text)[1]);
}

/** Bytes of the scene, and null, a sentence, or an error. */
async function opened(kind, bytes, thorough) {
  try {
    if (kind === "ply") return { size: sizeOf(readPly(bytes), PLAIN), verdict: null };
    if (kind === "spz") return { size: sizeOf(await readSpz(bytes), PLAIN), verdict: null };
    const whole = sentenceOf(() => open([bytes]));
    if (thorough) {
      const other = sentenceOf(() => open(pieces(bytes, random)));
      if ((whole === null) !== (other === null)) {
        return { size: 0, verdict: { error: `'${whole}' whole, but '${other}' in pieces` } };
      }
    }
    if (whole !== null || !thorough) return { size: 0, verdict: whole };
    return { size: sizeOf(sceneOf(open([bytes])).scene, PARTS), verdict: null };
  } catch (error) {
    const own = error.constructor === (kind === "mgs" ? SceneError : Error);
    if (own && plain(error.message)) return { size: 0, verdict: error.message };
    return { size: 0, verdict: { error: own ? `no plain sentence: ${error.message}` : error.stack } };
  }
}

/** @param {string} text */
function plain(text) {
  return text.length > 0 && text.length <= SENTENCE && !/[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/u.test(text);
}

/** Everything but colours and lobes, which are decoded from it. @param {Iterable<Uint8Array>} parts */
function open(parts) {
  const reader = new SceneReader();
  for (const part of parts) {
    reader.append(part);
    while (reader.step());
  }
  reader.end();
  while (reader.step());
  return reader;
}

/** Why a file is refused, or null. @param {() => unknown} read */
function sentenceOf(read) {
  try {
    read();
    return null;
  } catch (error) {
    if (error instanceof SceneError && plain(error.message)) return error.message;
    throw error;
  }
}

/** Bytes of arrays, all numbers of which must be finite. */
function sizeOf(scene, parts) {
  let size = 0;
  for (const part of parts) {
    if (!scene[part].every(Number.isFinite)) throw new TypeError(`${part} is not finite`);
    size += scene[part].byteLength;
  }
  return size;
}
