/**
 * Decodes files with the package in Node.js and writes what came out, for a comparison in Python.
 *
 *     node decode.js FILE...
 *
 * Writes FILE.json with all but the arrays, and FILE.bin with those.
 */

import { readFileSync, writeFileSync } from "node:fs";

import { decodeMgs } from "mobilegs";

for (const path of process.argv.slice(2)) {
  const scene = await decodeMgs(readFileSync(path));
  const arrays = Object.entries(scene).filter(([name, value]) => value instanceof Float32Array && name !== "background");
  const layout = arrays.map(([name, array]) => [name, array.length]);
  const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
  const rest = Object.fromEntries(Object.entries(scene).filter(([name]) => !layout.some(([other]) => other === name)));
  writeFileSync(`${path}.json`, JSON.stringify({ ...rest, layout }, plain));
  writeFileSync(`${path}.bin`, Buffer.concat(arrays.map(([, array]) => Buffer.from(array.buffer))));
}
