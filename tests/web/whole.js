/** Scenes as a whole, for comparisons. */

import { toWorld } from "../../mobilegs/view/web/mgs/positions.js";
import { SceneReader } from "../../mobilegs/view/web/mgs/reader.js";
import { RowDecoder } from "../../mobilegs/view/web/mgs/rows.js";

/** The scene in a whole file. @param {Uint8Array} bytes */
export function openScene(bytes) {
  const reader = new SceneReader();
  reader.append(bytes);
  reader.end();
  while (reader.step());
  return sceneOf(reader);
}

/** All of a scene, as far as it is there: at least its positions are. @param {SceneReader} reader */
export function sceneOf({ header, decoder }) {
  const gaussians = new RowDecoder(decoder.recipe).decode(decoder.rows(0, header.count));
  const means = toWorld(gaussians.positions, header.frame);
  return { header, scene: { ...gaussians, means, network: decoder.network } };
}
