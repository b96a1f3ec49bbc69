/**
 * Builds the viewer from `src` and `shaders`:
 *
 *     node build.mjs            # mobilegs/view/dist, which is committed: an installation needs no Node.js
 *     node build.mjs npm        # build/npm, of which `npm pack` makes a tarball
 *
 * A second argument names another folder.
 */

import { createHash } from "node:crypto";
import { copyFileSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { basename, join, relative } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { deflateSync } from "node:zlib";

import { build, transform } from "esbuild";

import * as texts from "./src/viewer/texts.js";
import { writeTypes } from "./types.mjs";

const here = fileURLToPath(new URL(".", import.meta.url));
const root = join(here, "..");
const { version } = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
/** Scripts of workers, in pages and in the package. */
const WORKERS = { worker: "load/worker.js", formats: "load/formats_worker.js" };
const PACKAGE_WORKER = { worker: "package/decode_worker.js" };
/** Texts in other languages than English. */
const { en: _, LANGUAGES: __, ...languages } = texts;
/** Parts of viewer.js that are loaded when they are needed. */
const PARTS = ["render/webgl.js", "viewer/extras.js", "viewer/report.js", "viewer/xr.js"];
/** Entries of the npm package. @type {Record<string, string>} */
const ENTRIES = {
  index: "package/index.js",
  element: "element.js",
  three: "three/index.js",
  react: "react/index.js",
  "react-three": "react/three.js",
};

/** Texts of shaders without comments, indentation and blank lines. @param {string} text */
const slim = (text) =>
  text
    .replace(/\/\/.*/g, "")
    .split("\n")
    .map((line) => line.trim())
    .filter(Boolean)
    .join("\n") + "\n";

/** A slim text without spaces that no token needs; those of macros stay. @param {string} text */
const tight = (text) =>
  text.replace(/^[^#].*$/gm, (line) =>
    // `>` may end a type, and the next character would belong to it
    line.replace(/ ?([,;{}()+*/?:]) ?/g, "$1").replace(/(?<!>) ([!=<+*/-]?=|&&|\|\|) /g, "$1"),
  );

/** Shaders of a language by file. @param {string} language */
const shadersOf = (language) =>
  readdirSync(join(here, "shaders"))
    .filter((file) => file.endsWith(language))
    .sort()
    .map((file) => [file, slim(readFileSync(join(here, "shaders", file), "utf8"))]);

/** Minifies the style sheet, the HTML and shaders in scripts. @type {import("esbuild").Plugin} */
const smaller = {
  name: "smaller",
  setup({ onLoad }) {
    onLoad({ filter: /[\\/]style\.js$/ }, async ({ path }) => {
      const { STYLE } = await import(pathToFileURL(path).href);
      const { code } = await transform(STYLE, { loader: "css", minify: true });
      const text = readFileSync(path, "utf8");
      const [head, rest] = [text.slice(0, text.indexOf("`")), text.slice(text.lastIndexOf("`;") + 1)];
      return { contents: head + JSON.stringify(code.trim()) + rest };
    });
    onLoad({ filter: /[\\/]template\.js$/ }, ({ path }) => ({
      contents: readFileSync(path, "utf8").replace(/\n\s+/g, "\n"),
    }));
    onLoad({ filter: /_texts\.js$/ }, ({ path }) => ({ contents: tight(slim(readFileSync(path, "utf8"))) }));
  },
};

/** The modules `NAME.packed.js`. @type {import("esbuild").Plugin} */
const packed = {
  name: "packed",
  setup({ onLoad, onResolve }) {
    onResolve({ filter: /\.packed\.js$/ }, ({ path }) => ({ path: basename(path, ".packed.js"), namespace: "packed" }));
    onLoad({ filter: /.*/, namespace: "packed" }, ({ path }) => ({ contents: modules[path] }));
  },
};

/** Leaves the parts and the packed modules to files beside viewer.js. @type {import("esbuild").Plugin} */
const apart = {
  name: "apart",
  setup({ onResolve }) {
    onResolve({ filter: /.*/ }, ({ path, kind }) =>
      kind === "dynamic-import" ? { path: `./${basename(path).replace(".packed", "")}`, external: true } : null,
    );
  },
};

/**
 * Scripts by name.
 *
 * @param {Record<string, string>} entries files of `src` by name
 * @param {import("esbuild").BuildOptions} [options]
 * @returns {Promise<Record<string, string>>}
 */
async function scripts(entries, options) {
  const { outputFiles } = await build({
    absWorkingDir: here,
    entryPoints: Object.entries(entries).map(([out, file]) => ({ out, in: join("src", file) })),
    outdir: "out",
    bundle: true,
    minify: true,
    format: "esm",
    target: "es2022",
    charset: "utf8",
    chunkNames: "chunk-[hash]",
    define: { PACKAGE_VERSION: JSON.stringify(version) },
    legalComments: "none",
    logLevel: "warning",
    write: false,
    ...options,
    plugins: [...(options?.plugins ?? []), smaller],
  });
  return Object.fromEntries(outputFiles.map(({ path, text }) => [basename(path, ".js"), text]));
}

/** Modules with packed texts by name. @type {Record<string, string>} */
const modules = {};
for (const language of ["wgsl", "glsl"]) {
  const names = shadersOf(language).map(([file, text]) => [file.replace(`.${language}`, ""), tight(text)]);
  modules[language] = JSON.stringify(Object.fromEntries(names));
}
modules.languages = JSON.stringify(languages);
const [product = "view", output] = process.argv.slice(2);
const isPackage = product === "npm";
const workers = isPackage ? { ...WORKERS, ...PACKAGE_WORKER } : WORKERS;
Object.assign(modules, await scripts(workers, { format: "iife", globalName: isPackage ? "decoder" : undefined }));
for (const [name, text] of Object.entries(modules)) {
  modules[name] = `export const text = "${deflateSync(text, { level: 9, memLevel: 7 }).toString("base64")}";\n`;
}

/** Files of the viewer's page. */
async function page() {
  const entries = Object.fromEntries(["viewer.js", "preload.js", "edit.js", "live.js", ...PARTS].map((file) => [basename(file, ".js"), file]));
  /** @type {Record<string, string>} */
  const loaded = { ...modules, ...(await scripts(entries, { plugins: [apart] })) };
  /** A script with the addresses of its parts, which change with their content: browsers may keep them. @param {string} name @returns {string} */
  const addressed = (name) =>
    loaded[name].replace(/(?<=import\("\.\/)(\w+)\.js/g, (file, part) => `${file}?${digest(addressed(part))}`);
  const digest = (/** @type {string} */ text) => createHash("sha256").update(text).digest("hex").slice(0, 16);
  const whole = await scripts({ "mobile-gs": "mobile-gs.js" }, { plugins: [packed], format: "iife" });
  return {
    ...Object.fromEntries(Object.keys(loaded).map((name) => [`${name}.js`, addressed(name)])),
    "preload.js": `(()=>{${addressed("preload").trim()}})();\n`, // it stands in pages
    "mobile-gs.js": whole["mobile-gs"],
    "index.html": readFileSync(join(here, "src", "index.html"), "utf8"),
    "live.html": readFileSync(join(here, "src", "live.html"), "utf8"),
    "service_worker.js": readFileSync(join(here, "src", "service_worker.js"), "utf8"),
    ...Object.fromEntries(shadersOf("wgsl")), // of the native renderer
  };
}

/** Scripts of the npm package, which share chunks. */
async function packageScripts() {
  const external = ["three", "react", "@react-three/fiber"];
  const all = await scripts(ENTRIES, { plugins: [packed], splitting: true, external });
  return Object.fromEntries(
    Object.entries(all).map(([name, text]) => [
      `${name}.js`,
      // components with effects: servers of React send them to the browser
      (name.startsWith("react") ? '"use client";\n' : "") +
        // esbuild drops comments: bundlers must leave the import of the decoder in Node.js alone
        text.replace("import(`data:", "import(/* webpackIgnore: true */ /* @vite-ignore */`data:"),
    ]),
  );
}

/** @param {string} output folder, which is made anew @param {Record<string, string>} files */
function write(output, files) {
  rmSync(output, { recursive: true, force: true });
  mkdirSync(output, { recursive: true });
  for (const [file, text] of Object.entries(files)) writeFileSync(join(output, file), text);
  console.log(`${Object.keys(files).length} files in ${relative(process.cwd(), output)}`);
}

/** @param {string} output */
async function writePackage(output) {
  const { name, ...rest } = JSON.parse(readFileSync(join(root, "npm", "package.json"), "utf8"));
  // without the appendix, which says how to apply the licence
  const [terms] = readFileSync(join(root, "LICENSE"), "utf8").split(/(?<=END OF TERMS AND CONDITIONS\n)/);
  write(output, { "package.json": JSON.stringify({ name, version, ...rest }, null, 2) + "\n", LICENSE: terms });
  copyFileSync(join(root, "npm", "README.md"), join(output, "README.md"));
  write(join(output, "dist"), await packageScripts());
  writeTypes(Object.values(ENTRIES), join(output, "dist", "types"));
}

if (isPackage) await writePackage(output ?? join(root, "build", "npm"));
else write(output ?? join(root, "mobilegs", "view", "dist"), await page());
