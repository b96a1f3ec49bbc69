/**
 * Builds `mobilegs/view/dist`, or the folder that the command line names, from `src` and `shaders`:
 *
 *     npm ci && npm run build
 *
 * The output is committed, so that an installation needs no Node.js.
 */

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

/** The bundle has its own `assets.js`, a minified style sheet, and HTML without indentation. */
const plugin = {
  name: "viewer",
  setup({ onResolve, onLoad }) {
    onResolve({ filter: /\/assets\.js$/ }, () => ({ path: join(here, "src", "assets_bundle.js") }));
    onLoad({ filter: /[\\/]style\.js$/ }, async ({ path }) => {
      const { STYLE } = await import(pathToFileURL(path).href);
      const { code } = await transform(STYLE, { loader: "css", minify: true });
      return { contents: `export const STYLE = ${JSON.stringify(code.trim())};` };
    });
    onLoad({ filter: /[\\/]template\.js$/ }, ({ path }) => ({
      contents: readFileSync(path, "utf8").replace(/\n\s+/g, "\n"),
    }));
  },
};

/** One script. @param {string} entry @param {object} [more] options @returns {Promise<string>} */
async function script(entry, more) {
  const { outputFiles } = await build({ entryPoints: [join("src", entry)], ...options, ...more });
  return outputFiles[0].text;
}

/** A script that can run its own source text in a worker, and that leaves no global names. @param {string} entry */
const selfContained = (entry) =>
  script(entry, {
    plugins: [plugin],
    define: { SHADERS: JSON.stringify(shaders), PACKAGE_VERSION: JSON.stringify(version) },
    banner: { js: '(function bundle(){"use strict";' },
    footer: { js: "})();" },
  });

const files = {
  "index.html": readFileSync(join(here, "src", "index.html"), "utf8"),
  "viewer.js": await selfContained("viewer.js"),
  "mobile-gs.js": await selfContained("mobile-gs.js"),
  "preload.js": await script("preload.js"),
  "service_worker.js": readFileSync(join(here, "src", "service_worker.js"), "utf8"),
  ...Object.fromEntries(Object.entries(shaders).filter(([file]) => file.endsWith(".wgsl"))),
};
mkdirSync(output, { recursive: true });
for (const [file, text] of Object.entries(files)) writeFileSync(join(output, file), text);
if (output === dist) {
  for (const file of readdirSync(dist)) if (!(file in files)) rmSync(join(dist, file));
}
console.log(`${Object.keys(files).length} files in ${relative(process.cwd(), output)}`);
