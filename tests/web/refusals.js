/**
 * Opens damaged files, one after the other, and writes which ones were refused.
 *
 * node refusals.js CASES RESULTS reads a file of rows (u32 length, bytes) and writes a list of
 * sentences, null where a file was opened. Any error but a SceneError ends the program.
 */

import { readFileSync, writeFileSync } from "node:fs";

import { SceneError } from "../../viewer/src/mgs/error.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { pieces, randomNumbers } from "./pieces.js";
import { openScene, sceneOf } from "./whole.js";

const [cases, results] = process.argv.slice(2);
const data = new Uint8Array(readFileSync(cases));
const numbers = new DataView(data.buffer, data.byteOffset, data.byteLength);
const random = randomNumbers(1);
const found = [];
for (let start = 0; start < data.length; ) {
  const end = start + 4 + numbers.getUint32(start, true);
  const bytes = data.slice(start + 4, end);
  const whole = refusal(() => openScene(bytes));
  const inPieces = refusal(() => openInPieces(bytes));
  if ((whole === null) !== (inPieces === null)) {
    throw new Error(`file ${found.length}: '${whole}' whole, but '${inPieces}' in pieces`);
  }
  found.push(whole);
  start = end;
}
writeFileSync(results, JSON.stringify(found));

function refusal(open) {
  try {
    open();
    return null;
  } catch (error) {
    if (error instanceof SceneError) return error.message;
    throw error;
  }
}

/** Whatever has arrived when a scene is there must be finite. */
function openInPieces(bytes) {
  const reader = new SceneReader();
  for (const piece of pieces(bytes, random)) {
    reader.append(piece);
    while (reader.step());
  }
  reader.end();
  while (reader.step());
  const { scene } = sceneOf(reader);
  for (const part of ["means", "logScales", "quats", "sh", "lobes"]) {
    if (!scene[part].every(Number.isFinite)) throw new Error(`${part} is not finite`);
  }
}
