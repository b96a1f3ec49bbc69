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
import { fileURLToPath, pathToFileURL } from "node:url";

import { build, transform } from "esbuild";

const here = fileURLToPath(new URL(".", import.meta.url));
const dist = join(here, "..", "mobilegs", "view", "dist");
const output = process.argv[2] ?? dist;
const { version } = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
const options = {
  absWorkingDir: here, bundle: true, minify: true, format: "esm", target: "es2022",
  legalComments: "none", logLevel: "warning", write: false,
}; // prettier-ignore

/** Without comments, indentation and blank lines. @param {string} text */
const slim = (text) =>
  text
    .replace(/\/\/.*/g, "")
    .split("\n")
    .map((line) => line.trim())
    .filter(Boolean)
    .join("\n") + "\n";

const shaders = Object.fromEntries(
  readdirSync(join(here, "shaders"))
    .sort()
    .map((file) => [file, slim(readFileSync(join(here, "shaders", file), "utf8"))]),
);

/** Shaders of one language, or all. @param {string} [suffix] */
const shadersOf = (suffix = "") =>
  JSON.stringify(Object.fromEntries(Object.entries(shaders).filter(([file]) => file.endsWith(suffix))));

/** Replaces a module of the sources by another one. @param {string} name @param {string} by */
const replace = (name, by) => ({
  name,
  setup: (/** @type {import("esbuild").PluginBuild} */ { onResolve }) =>
    onResolve({ filter: new RegExp(`/${name}$`) }, () => ({ path: join(here, "src", by) })),
});

/** The bundle has its own `assets.js`, a minified style sheet, and HTML without indentation. */
const plugins = [replace("assets.js", "assets_bundle.js"), {
  name: "viewer",
  setup({ onLoad }) {
    onLoad({ filter: /[\\/]style\.js$/ }, async ({ path }) => {
      const { STYLE } = await import(pathToFileURL(path).href);
      const { code } = await transform(STYLE, { loader: "css", minify: true });
      return { contents: `export const STYLE = ${JSON.stringify(code.trim())};` };
    });
    onLoad({ filter: /[\\/]template\.js$/ }, ({ path }) => ({
      contents: readFileSync(path, "utf8").replace(/\n\s+/g, "\n"),
    }));
  },
}];

/** One script. @param {string} entry @param {object} [more] options @returns {Promise<string>} */
async function script(entry, more) {
  const { outputFiles } = await build({ entryPoints: [join("src", entry)], ...options, ...more });
  return outputFiles[0].text;
}

/**
 * A script that can run its own source text in a worker, and that leaves no global names.
 *
 * @param {string} entry
 * @param {object} more options
 */
const selfContained = (entry, more) =>
  script(entry, {
    plugins,
    banner: { js: '(function bundle(){"use strict";' },
    footer: { js: "})();" },
    ...more,
  });

/** Parts of viewer.js that are loaded when they are needed, with the functions of `chunks.js` that load them. */
const chunks = {
  formats: "load/formats.js",
  webgl: "render/webgl_chunk.js",
  languages: "viewer/languages.js",
  extras: "viewer/extras.js",
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
