/** Scenes as a whole, for comparisons. */

import { toWorld } from "../../mobilegs/view/web/mgs/positions.js";
import { SceneReader } from "../../mobilegs/view/web/mgs/reader.js";
import { RowDecoder } from "../../mobilegs/view/web/mgs/rows.js";

const PARTS = ["positions", "logScales", "scales", "quats", "sh", "lobes"];

/** The scene in a whole file. @param {Uint8Array} bytes */
export function openScene(bytes) {
  const reader = new SceneReader();
  reader.append(bytes);
  reader.end();
  while (reader.step());
  return sceneOf(reader);
}

/** How many columns a part of a scene has: 1 if it is held row by row. @param {object} scene @param {string} part */
export function columnsOf(scene, part) {
  return ["sh", "lobes"].includes(part) ? scene[part].length / scene.count : 1;
}

/** All of a scene, as far as it is there: at least positions of its first layer are. @param {SceneReader} reader */
export function sceneOf({ header, decoder }) {
  const rows = new RowDecoder(decoder.recipe);
  const come = decoder.layers.filter(({ positions }) => positions);
  // what is decoded next takes its memory again
  const layers = come.map((layer) => structuredClone(rows.decode(layer.rows(0, layer.count))));
  const count = layers.reduce((sum, layer) => sum + layer.count, 0);
  const parts = PARTS.map((part) => {
    const [first] = layers;
    const all = new first[part].constructor((first[part].length / first.count) * count);
    let at = 0;
    for (const layer of layers) {
      const columns = columnsOf(layer, part);
      const size = layer[part].length / columns;
      for (let i = 0; i < columns; i++) {
        all.set(layer[part].subarray(i * size, (i + 1) * size), at + i * count);
      }
      at += size;
    }
    return [part, all];
  });
  const gaussians = { ...layers[0], count, ...Object.fromEntries(parts) };
  const means = toWorld(gaussians.positions, header.frame);
  return { header, scene: { ...gaussians, means, network: decoder.network } };
}
