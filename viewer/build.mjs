/**
 * Builds `mobilegs/view/dist`, or the folder that the command line names, from `src` and `shaders`:
 *
 *     npm ci && npm run build
 *
 * The output is committed, so that an installation needs no Node.js.
 */

import { createHash } from "node:crypto";
import { mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";

import { here, plugins, replace, script, selfContained, shaders, shadersOf, version } from "./bundling.mjs";

const dist = join(here, "..", "mobilegs", "view", "dist");
const output = process.argv[2] ?? dist;

/** Parts of viewer.js that are loaded when they are needed, with the functions of `chunks.js` that load them. */
const chunks = {
  formats: "load/formats.js",
  webgl: "render/webgl_chunk.js",
  languages: "viewer/languages.js",
  extras: "viewer/extras.js",
  xr: "viewer/xr.js",
};
const VERSION = { PACKAGE_VERSION: JSON.stringify(version) };
/** @type {Record<string, string>} */
const parts = {};
/** Addresses of the parts, which change with their content: browsers may keep them. @type {Record<string, string>} */
const addresses = {};
for (const [name, entry] of Object.entries(chunks)) {
  const text = await script(entry, { plugins, define: { ...VERSION, SHADERS: shadersOf("glsl") } });
  parts[`${name}.js`] = text;
  addresses[name] = `${name}.js?${createHash("sha256").update(text).digest("hex").slice(0, 16)}`;
}
const inParts = {
  plugins: [replace("chunks.js", "chunks_bundle.js"), ...plugins],
  define: { ...VERSION, SHADERS: shadersOf("wgsl"), CHUNKS: JSON.stringify(addresses) },
};

const files = {
  "index.html": readFileSync(join(here, "src", "index.html"), "utf8"),
  "viewer.js": await selfContained("viewer.js", inParts),
  "mobile-gs.js": await selfContained("mobile-gs.js", { define: { ...VERSION, SHADERS: shadersOf() } }),
  "preload.js": await script("preload.js", { define: { WEBGL_CHUNK: JSON.stringify(addresses.webgl) } }),
  "edit.js": await script("edit.js"),
  "live.html": readFileSync(join(here, "src", "live.html"), "utf8"),
  "live.js": await script("live.js"),
  "service_worker.js": readFileSync(join(here, "src", "service_worker.js"), "utf8"),
  ...parts,
  ...Object.fromEntries(Object.entries(shaders).filter(([file]) => file.endsWith(".wgsl"))),
};
mkdirSync(output, { recursive: true });
for (const [file, text] of Object.entries(files)) writeFileSync(join(output, file), text);
if (output === dist) {
  for (const file of readdirSync(dist)) if (!(file in files)) rmSync(join(dist, file));
}
console.log(`${Object.keys(files).length} files in ${relative(process.cwd(), output)}`);
