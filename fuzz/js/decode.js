/**
 * Decodes `.mgs` files completely, for a comparison with the other decoders: `agreement.py` starts it.
 *
 *     node decode.js [--without-wasm]
 *
 * Each line of its input is `{"path", "out"}`: a file of rows (u32 length, bytes), and a file for arrays of
 * float32. Each gets a line in answer: for each row the sentence of a refusal, or `{count, layout}` with
 * [name, first number, numbers] of each array; and which rows reached code that none before did.
 */

import { readFileSync, writeFileSync } from "node:fs";
import { createInterface } from "node:readline";

import { Coverage } from "../../tests/fuzz/coverage.js";

const coverage = new Coverage();
await coverage.start();
// before the decoder looks for it
if (process.argv.includes("--without-wasm")) Reflect.deleteProperty(globalThis, "WebAssembly");
const { SceneError } = await import("../../viewer/src/mgs/error.js");
const { openScene } = await import("../../tests/web/whole.js");

for await (const line of createInterface({ input: process.stdin })) {
  const { path, out } = JSON.parse(line);
  process.stdout.write(`${JSON.stringify(await answers(path, out))}\n`);
}

/** @param {string} path @param {string} out */
async function answers(path, out) {
  const data = new Uint8Array(readFileSync(path));
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  /** @type {Uint8Array[]} */
  const kept = [];
  const rows = [];
  /** @type {number[]} */
  const novel = [];
  let numbers = 0;
  for (let start = 0; start < data.length; ) {
    const end = start + 4 + view.getUint32(start, true);
    rows.push(decode(data.slice(start + 4, end)));
    if (await coverage.grew()) novel.push(rows.length - 1);
    start = end;
  }
  writeFileSync(out, Buffer.concat(kept));
  return { rows, novel, blocks: coverage.blocks };

  /** @param {Uint8Array} bytes */
  function decode(bytes) {
    try {
      const { means, logScales, quats, sh, lobes, count } = openScene(bytes).scene;
      const layout = Object.entries({ means, logScales, quats, sh, lobes }).map(([name, array]) => {
        kept.push(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
        numbers += array.length;
        return [name, numbers - array.length, array.length];
      });
      return { count, layout };
    } catch (error) {
      return error instanceof SceneError ? error.message : { error: `${error instanceof Error ? error.stack : error}` };
    }
  }
}
