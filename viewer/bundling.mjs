/** Steps that the builds of the viewer (build.mjs) and of the npm package (build_package.mjs) share. */

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

import { build, transform } from "esbuild";

export const here = fileURLToPath(new URL(".", import.meta.url));
export const { version } = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
export const options = {
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

export const shaders = Object.fromEntries(
  readdirSync(join(here, "shaders"))
    .sort()
    .map((file) => [file, slim(readFileSync(join(here, "shaders", file), "utf8"))]),
);

/** Shaders of one language, or all. @param {string} [suffix] */
export const shadersOf = (suffix = "") =>
  JSON.stringify(Object.fromEntries(Object.entries(shaders).filter(([file]) => file.endsWith(suffix))));

/** Replaces a module of the sources by another one. @param {string} name @param {string} by */
export const replace = (name, by) => ({
  name,
  setup: (/** @type {import("esbuild").PluginBuild} */ { onResolve }) =>
    onResolve({ filter: new RegExp(`/${name}$`) }, () => ({ path: join(here, "src", by) })),
});

/** Minifies the style sheet, the HTML and shaders in scripts. @type {import("esbuild").Plugin} */
export const smaller = {
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
    onLoad({ filter: /_texts\.js$/ }, ({ path }) => ({ contents: slim(readFileSync(path, "utf8")) }));
  },
};
/** The bundle has its own `assets.js`. */
export const plugins = [replace("assets.js", "assets_bundle.js"), smaller];

/** One script. @param {string} entry @param {object} [more] options @returns {Promise<string>} */
export async function script(entry, more) {
  const { outputFiles } = await build({ entryPoints: [join("src", entry)], ...options, ...more });
  return outputFiles[0].text;
}

/**
 * A script that can run its own source text in a worker, and that leaves no global names.
 *
 * @param {string} entry
 * @param {object} more options
 */
export const selfContained = (entry, more) =>
  script(entry, {
    plugins,
    banner: { js: '(function bundle(){"use strict";' },
    footer: { js: "})();" },
    ...more,
  });
