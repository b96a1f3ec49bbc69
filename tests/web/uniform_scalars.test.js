/** Browsers without WebAssembly, such as those that lock themselves down, open the same scenes. */

import assert from "node:assert/strict";
import test from "node:test";

import { BLOCK } from "../../viewer/src/mgs/block_memory.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { GaussianDecoder } from "../../viewer/src/mgs/gaussian_decoder.js";
import { packRows } from "../../viewer/src/render/pack.js";
import { openScene } from "./whole.js";
import { seal, smallScene } from "./write.js";

const { fields, streams } = smallScene(300);
const bytes = seal(fields, streams);

test("everything works without WebAssembly", () => {
  const { scene } = openScene(bytes);
  const real = globalThis.WebAssembly;
  delete globalThis.WebAssembly;
  const reader = new SceneReader();
  reader.append(bytes);
  while (reader.step());
  reader.end();
  const decoder = new GaussianDecoder(reader.decoder.decoderInputs);
  const rows = reader.decoder.levels[0].rows(0, 300);
  const block = decoder.decode(rows, 0);
  assert.equal(block.memory, null);
  for (const part of ["scales", "quats", "sh", "lobes"]) {
    const width = scene[part].length / 300;
    for (let i = 0; i < BLOCK * width; i++) {
      const expected = scene[part][i];
      const found = block[part][(i % width) * BLOCK + Math.floor(i / width)];
      assert.ok(Math.abs(found - expected) < 1e-5 * (1 + Math.abs(expected)), `${part} ${i}`);
    }
  }
  assert.equal(packRows(decoder, rows).shapes.length, 4 * 300);
  globalThis.WebAssembly = real;
});
