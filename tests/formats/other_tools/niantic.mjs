/**
 * Makes `spz_js.spz` with spz-js, and `*.niantic.json`: values that Niantic's code reads from it
 * and from our file, in the axes of the file.
 *
 * Run `npm install spz-js@1.2.5 @spz-loader/core@0.3.1` in another folder OTHER, then here:
 *
 *     node tests/formats/other_tools/niantic.mjs OTHER/node_modules
 *
 * spz-js is a writer in JavaScript; @spz-loader/core is Niantic's C++ library as WebAssembly.
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
