/**
 * The viewer's readers under watch: scenes or sentences, in bounded time and memory.
 *
 *     node readers.js [--coverage] [--without-wasm]
 *
 * Each line of its input asks for a batch, `{"kind", "path", "every", "seconds", "out"}`: a file of rows (u32
 * length, bytes). Each gets a line in answer, `{verdicts, novel, blocks}`. A verdict is null (a scene), a
 * sentence, or `{error}`. One in `every` scenes is decoded to the last number and read in pieces, too; none may
 * take more `seconds` of processor time. With `out` each `.mgs` is decoded completely into that file of float32,
 * and its verdict is a list of [name, first number, numbers]. With `--coverage`, `novel` tells which inputs reached
 * blocks of the viewer's code that none before them did, and `blocks` how many all have reached.
 */

import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { Session } from "node:inspector/promises";
import { createInterface } from "node:readline";

/** No control characters, no halves of pairs. */
const PLAIN_SENTENCE = /^[^\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]{1,300}$/u;
const FREE = 96 << 20; // bytes in addition to twice the file and the scene: garbage is collected late
const PARTS = ["means", "logScales", "quats", "sh", "lobes"];
const PLAIN = ["shapes", "colors", "lobes"];

/** Code whose coverage counts. */
const OURS = /\/viewer\/src\//;
/** Blocks that were reached. @type {Set<string>} */
const reached = new Set();
/** @type {Session | null} */
let session = null;
if (process.argv.includes("--coverage")) {
  session = new Session();
  session.connect();
  await session.post("Profiler.enable");
  await session.post("Profiler.startPreciseCoverage", { callCount: true, detailed: true });
}
// before the decoder looks for it
if (process.argv.includes("--without-wasm")) Reflect.deleteProperty(globalThis, "WebAssembly");
const { readPly } = await import("../../viewer/src/load/ply.js");
const { readSpz } = await import("../../viewer/src/load/spz.js");
const { SceneError } = await import("../../viewer/src/mgs/error.js");
const { SceneReader } = await import("../../viewer/src/mgs/reader.js");
const { pieces, randomNumbers } = await import("../../tests/web/pieces.js");
const { sceneOf } = await import("../../tests/web/whole.js");
const random = randomNumbers(1);

for await (const line of createInterface({ input: process.stdin })) {
  process.stdout.write(`${JSON.stringify(await answer(JSON.parse(line)))}\n`);
}

async function answer({ kind, path, every, seconds, out }) {
  const inputs = rowsOf(path);
  /** @type {Uint8Array[] | undefined} */
  const arrays = out && [];
  /** @type {number[]} */
  const novel = [];
  const verdicts = [];
  let largest = 0;
  const before = memory("VmRSS", true);
  for (const [i, bytes] of inputs.entries()) {
    const begun = performance.now();
    const { size, verdict } = await opened(kind, bytes, i % every === 0, arrays);
    verdicts.push(verdict);
    if (await grew()) novel.push(i);
    largest = Math.max(largest, size + bytes.length);
    if (performance.now() - begun < 1000 * seconds) continue;
    // a busy machine, or a slow reader?
    const used = process.cpuUsage();
    await opened(kind, bytes, i % every === 0);
    const { user, system } = process.cpuUsage(used);
    if (user + system > 1e6 * seconds) verdicts[i] = { error: `took ${(user + system) / 1e6} s` };
  }
  if (arrays) writeFileSync(out, Buffer.concat(arrays));
  else if (memory("VmHWM", false) - before > FREE + 2 * largest) {
    for (const [i, bytes] of inputs.entries()) {
      const start = memory("VmRSS", true);
      const { size } = await opened(kind, bytes, i % every === 0);
      const peak = memory("VmHWM", false) - start;
      if (peak > FREE + 2 * (size + bytes.length)) verdicts[i] = { error: `took ${peak >> 20} MiB for ${size} bytes` };
    }
  }
  return { verdicts, novel, blocks: reached.size };
}

/** @param {string} path of a file of rows */
function rowsOf(path) {
  const data = readFileSync(path);
  const rows = [];
  for (let at = 4; at <= data.length; at += 4 + rows.at(-1).length) {
    rows.push(new Uint8Array(data.subarray(at, at + data.readUInt32LE(at - 4))));
  }
  return rows;
}

/** True if a block was reached since the last call that was not before; how often, in powers of two, counts as well. */
async function grew() {
  if (!session) return false;
  const { result } = await session.post("Profiler.takePreciseCoverage");
  const before = reached.size;
  for (const { url, functions } of result) {
    if (!OURS.test(url)) continue;
    for (const { startOffset, endOffset, count } of functions.flatMap(({ ranges }) => ranges)) {
      if (count > 0) reached.add(`${url}:${startOffset}-${endOffset}:${Math.min(3, Math.log2(count) >> 1)}`);
    }
  }
  return reached.size > before;
}

/** Bytes that the process has (`VmRSS`), or the most it has had since the last reset (`VmHWM`); 0 where not known. */
function memory(name, reset) {
  if (!existsSync("/proc/self/clear_refs")) return 0;
  if (reset) writeFileSync("/proc/self/clear_refs", "5");
  const text = readFileSync("/proc/self/status", "latin1");
  return 1024 * Number(new RegExp(`${name}:\\s*(\\d+)`).exec(text)[1]);
}

/** Bytes of the scene, and the verdict; the scene's arrays are appended to `arrays`. */
async function opened(kind, bytes, thorough, arrays) {
  try {
    if (kind === "ply") return { size: sizeOf(readPly(bytes), PLAIN), verdict: null };
    if (kind === "spz") return { size: sizeOf(await readSpz(bytes), PLAIN), verdict: null };
    const { reader, sentence } = open([bytes]);
    const other = thorough ? open(pieces(bytes, random)).sentence : sentence;
    if (!sentence !== !other) throw new TypeError(`'${sentence}' whole, but '${other}' in pieces`);
    if (sentence !== null || !(thorough || arrays)) return { size: 0, verdict: sentence };
    const { scene } = sceneOf(reader);
    return { size: sizeOf(scene, PARTS), verdict: arrays ? appended(scene, arrays) : null };
  } catch (error) {
    const own = error.constructor === (kind === "mgs" ? SceneError : Error);
    if (own && PLAIN_SENTENCE.test(error.message)) return { size: 0, verdict: error.message };
    return { size: 0, verdict: { error: own ? `no plain sentence: ${error.message}` : error.stack } };
  }
}

/** Append the arrays of a scene; return [name, first number, numbers] of each. */
function appended(scene, arrays) {
  return PARTS.map((name) => {
    const start = arrays.reduce((sum, { length }) => sum + length, 0) / 4;
    arrays.push(new Uint8Array(scene[name].buffer, scene[name].byteOffset, scene[name].byteLength));
    return [name, start, scene[name].length];
  });
}

/** Read everything but colours and lobes, or tell why not. @param {Iterable<Uint8Array>} parts */
function open(parts) {
  const reader = new SceneReader();
  try {
    for (const part of parts) {
      reader.append(part);
      while (reader.step());
    }
    reader.end();
    while (reader.step());
    return { reader, sentence: null };
  } catch (error) {
    if (!(error instanceof SceneError && PLAIN_SENTENCE.test(error.message))) throw error;
    return { reader, sentence: error.message };
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
