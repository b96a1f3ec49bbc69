/**
 * Decodes files and writes what came out, for a comparison in Python.
 *
 * node dump.js SEED FILE... writes FILE.json (what is small, and where the arrays lie) and
 * FILE.bin (the arrays). With SEED 0 files are opened whole, else in pieces of random sizes.
 */

import { readFileSync, writeFileSync } from "node:fs";

import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { pieces, randomNumbers } from "./pieces.js";
import { openScene, sceneOf } from "./whole.js";

const [seed, ...paths] = process.argv.slice(2);
const random = randomNumbers(Number(seed));
for (const path of paths) {
  const bytes = new Uint8Array(readFileSync(path));
  const { header, scene } = seed === "0" ? openScene(bytes) : openInPieces(bytes);
  const { network, means, logScales, quats, sh, lobes, count, lobeDegree } = scene;
  const arrays = { means, logScales, quats, sh, lobes, ...network };
  let start = 0;
  const layout = Object.entries(arrays).map(([name, array]) => {
    const row = [name, start, array.length];
    start += array.length;
    return row;
  });
  const described = { ...header, cuts: Object.fromEntries(header.cuts) };
  // typed arrays would become objects
  const plain = (_, value) => (ArrayBuffer.isView(value) ? [...value] : value);
  writeFileSync(`${path}.json`, JSON.stringify({ header: described, count, lobeDegree, layout }, plain));
  const bytesOf = (array) => new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  writeFileSync(`${path}.bin`, Buffer.concat(Object.values(arrays).map(bytesOf)));
}

function openInPieces(bytes) {
  const reader = new SceneReader();
  for (const piece of pieces(bytes, random)) {
    reader.append(piece);
    while (random() < 0.9 && reader.step());
  }
  reader.end();
  while (reader.step());
  return sceneOf(reader);
}
