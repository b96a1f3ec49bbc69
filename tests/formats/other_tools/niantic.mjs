/**
 * Makes `spz_js.spz`, and what Niantic's own code reads of that and of our file.
 *
 * Once `npm install spz-js@1.2.5 @spz-loader/core@0.3.1` was run in another folder:
 *
 *     node tests/other_tools/niantic.mjs OTHER/node_modules
 *
 * spz-js is a writer in JavaScript; @spz-loader/core is Niantic's C++ library as WebAssembly, which
 * says of each file the numbers in its own axes: `*.niantic.json`.
 */

import { createReadStream, readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { Readable } from "node:stream";
import { fileURLToPath, pathToFileURL } from "node:url";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const other = (path) => import(pathToFileURL(resolve(process.argv[2], path)).href);

const { loadPly, serializeSpz } = await other("spz-js/dist/index.js");
const scene = await loadPly(Readable.toWeb(createReadStream(here("scene.ply"))));
writeFileSync(here("spz_js.spz"), await serializeSpz(scene));

// it was built for browsers, and takes itself to be in one if this is no node
Object.defineProperty(process, "versions", { value: {} });
globalThis.window = globalThis;
const { loadSpz } = await other("@spz-loader/core/dist/index.js");
for (const name of ["spz_js.spz", "ours.spz"]) {
  // its own factor has three digits
  const options = { colorScaleFactor: 0.28209479177387814 };
  const { numPoints, ...parts } = await loadSpz(new Uint8Array(readFileSync(here(name))), options);
  const numbers = Object.entries(parts).filter(([, values]) => values instanceof Float32Array);
  const rounded = numbers.map(([part, values]) => [part, Array.from(values, (x) => Number(x.toPrecision(7)))]);
  writeFileSync(here(`${name}.niantic.json`), JSON.stringify(Object.fromEntries(rounded)) + "\n");
}
