/** Scenes as a whole, for comparisons. */

import { BLOCK } from "../../viewer/src/mgs/block_memory.js";
import { toWorld } from "../../viewer/src/mgs/positions.js";
import { SceneReader } from "../../viewer/src/mgs/reader.js";
import { GaussianDecoder } from "../../viewer/src/mgs/gaussian_decoder.js";
import { packRows } from "../../viewer/src/render/pack.js";

/** Columns of each part; of lobes it depends. */
const PARTS = { logScales: 3, scales: 3, quats: 4, sh: 12 };

/** The scene in a whole file. @param {Uint8Array} bytes */
export function openScene(bytes) {
  const reader = new SceneReader();
  reader.append(bytes);
  reader.end();
  while (reader.step());
  return sceneOf(reader);
}

/** Some rows as numbers, row by row. @param {GaussianDecoder} decoder @param {object} rows */
export function numbersOf(decoder, rows) {
  const count = rows.positions.length / 3;
  const columns = { ...PARTS, lobes: 2 * (decoder.lobeDegree + 1) ** 2 };
  const parts = Object.entries(columns).map(([part, width]) => [part, new Float32Array(width * count)]);
  const found = Object.fromEntries(parts);
  for (let from = 0; from < count; from += BLOCK) {
    const block = decoder.decode(rows, from);
    for (const [part, width] of Object.entries(columns)) {
      for (let i = 0; i < block.count * width; i++) {
        found[part][from * width + i] = block[part][(i % width) * BLOCK + Math.floor(i / width)];
      }
    }
  }
  return { count, ...found, positions: rows.positions };
}

/** All of a scene, as far as it is there: at least positions of its first layer are. @param {SceneReader} reader */
export function sceneOf({ header, decoder }) {
  const rows = new GaussianDecoder(decoder.decoderInputs);
  const levels = decoder.levels.filter(({ positions }) => positions).map((level) => level.rows(0, level.count));
  const scene = joined(levels.map((level) => numbersOf(rows, level)));
  const { lobeDegree, scaleRange } = rows;
  const means = toWorld(scene.positions, header.grid);
  const words = joined(levels.map((level) => packRows(rows, level)));
  return { header, words, scene: { ...scene, lobeDegree, scaleRange, means, network: decoder.network } };
}

/** Arrays of some objects one behind the other; numbers are added. */
function joined(objects) {
  return Object.fromEntries(
    Object.keys(objects[0]).map((name) => {
      const all = objects.map((object) => object[name]);
      if (typeof all[0] === "number") return [name, all.reduce((a, b) => a + b)];
      const found = new all[0].constructor(all.reduce((sum, { length }) => sum + length, 0));
      let at = 0;
      for (const one of all) {
        found.set(one, at);
        at += one.length;
      }
      return [name, found];
    }),
  );
}
