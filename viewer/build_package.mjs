/**
 * Builds the npm package into `build/npm`, or the folder that the command line names; `npm pack` makes a tarball of it.
 *
 * Entries share chunks. Worker, shaders and languages are compressed texts in the modules that need them, so that
 * bundlers, import maps and content networks need no settings. Types come from the JSDoc of the sources.
 */

import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, posix, relative } from "node:path";
import { gzipSync } from "node:zlib";

import { build } from "esbuild";
import ts from "typescript";

import { toDigits } from "./src/package/unpacked.js";
import * as languages from "./src/viewer/languages.js";
import { here, options, replace, script, shadersOf, smaller, version } from "./bundling.mjs";

const root = join(here, "..");
const output = process.argv[2] ?? join(root, "build", "npm");
/** Sources of the entries. @type {Record<string, string>} */
const ENTRIES = {
  index: "package/index.js",
  element: "element.js",
  three: "three/index.js",
  react: "react/index.js",
  "react-three": "react/three.js",
};
const VERSION = { PACKAGE_VERSION: JSON.stringify(version) };

/** @param {string} text @returns {string} JavaScript of a string */
const packed = (text) => JSON.stringify(toDigits(gzipSync(text, { level: 9 })));

/** Write the scripts. */
async function writeScripts() {
  const parts = ["assets.js", "chunks.js"].map((name) => replace(name, "package/worker_parts.js"));
  const worker = await script("package/worker.js", { plugins: parts });
  const plugins = [
    ...["assets.js", "chunks.js", "extras.js"].map((name) => replace(name, `package/${name}`)),
    smaller,
  ];
  const { outputFiles } = await build({
    ...options,
    entryPoints: Object.entries(ENTRIES).map(([out, file]) => ({ out, in: join("src", file) })),
    outdir: join(output, "dist"),
    splitting: true,
    chunkNames: "chunk-[hash]",
    charset: "utf8",
    external: ["three", "react", "@react-three/fiber"],
    define: {
      ...VERSION,
      PACKED_WORKER: packed(worker),
      PACKED_SHADERS: packed(shadersOf()),
      PACKED_TEXTS: packed(JSON.stringify(languages)),
    },
    plugins,
  });
  mkdirSync(join(output, "dist"));
  for (const { path, text } of outputFiles) {
    // components with effects: servers of React send them to the browser
    const start = /react(-three)?\.js$/.test(path) ? '"use client";\n' : "";
    // esbuild drops comments: bundlers must leave the import of the worker in Node.js alone
    writeFileSync(path, start + text.replace("import(`data:", "import(/* webpackIgnore: true */ /* @vite-ignore */`data:"));
  }
}

/** Write the declarations that the entries reach. */
function writeTypes() {
  const source = join(here, "src");
  const entries = Object.values(ENTRIES).map((file) => join(source, file));
  const config = ts.readConfigFile(join(here, "tsconfig.json"), ts.sys.readFile).config;
  const { options: strict } = ts.convertCompilerOptionsFromJson(config.compilerOptions, here);
  const program = ts.createProgram([...entries, join(source, "globals.d.ts")], {
    ...strict,
    noEmit: false,
    declaration: true,
    emitDeclarationOnly: true,
    rootDir: here,
    outDir: "/",
  });
  /** Declarations by path from `src`. @type {Map<string, string>} */
  const all = new Map();
  program.emit(undefined, (path, text) => all.set(posix.relative("/src", path.replaceAll("\\", "/")), text));
  const waiting = Object.values(ENTRIES).map((file) => file.replace(/\.js$/, ".d.ts"));
  const INDEX = "package/index.d.ts"; // names types of other modules
  const written = new Set();
  for (let file; (file = waiting.pop()); ) {
    if (written.has(file)) continue;
    written.add(file);
    const more = join(root, "npm", "types", file); // what JSDoc cannot say
    const own = all.get(file) ?? "";
    const text = (file === INDEX ? own : withoutInternal(own)) + (ts.sys.fileExists(more) ? readFileSync(more, "utf8") : "");
    for (const [, name] of text.matchAll(/(?:from |import\()"(\.[^"]+)\.js"/g)) {
      waiting.push(posix.join(posix.dirname(file), `${name}.d.ts`));
    }
    const path = join(output, "dist", "types", file);
    mkdirSync(dirname(path), { recursive: true });
    writeFileSync(path, withoutRepetition(text));
  }
}

/** Declarations without what the compiler copies from JSDoc although it has declared it. @param {string} text */
const withoutRepetition = (text) =>
  text
    .replace(/^\/\*\*(?:(?!\*\/)[^])*?@(?:typedef|import)(?:(?!\*\/)[^])*\*\/\n/gm, "")
    .replace(/ @(?:type|returns) \{[^}\n]*\}(?= \*\/|$)/gm, "")
    .replace(/(@param|@returns) \{(?:[^{}\n]|\{[^{}\n]*\})*\}/g, "$1")
    .replace(/(?:\n *\*)+(?=\n *\*\/)/g, "");

/** Declarations without members marked `@internal`, and without types that only those need. @param {string} text */
function withoutInternal(text) {
  const file = ts.createSourceFile("types.d.ts", text, ts.ScriptTarget.Latest, true);
  const internal = file.statements
    .flatMap((node) => (ts.isClassDeclaration(node) ? [...node.members] : []))
    .filter((member) => ts.getJSDocTags(member).some(({ tagName }) => tagName.text === "internal"));
  let rest = text;
  for (const member of internal.reverse()) rest = rest.slice(0, member.getFullStart()) + rest.slice(member.getEnd());
  const uses = (/** @type {string} */ name) => rest.match(new RegExp(`\\b${name}\\b`, "g"))?.length;
  return rest
    .replace(/^export type (\w+) = import\("[^"]+"\)\.\w+;\n/gm, (line, name) => (uses(name) === 2 ? "" : line))
    .replace(/^import (?:type )?\{ (\w+) \} from .*\n/gm, (line, name) => (uses(name) === 1 ? "" : line));
}

/** Write package.json: that of `npm/` with the version of the viewer. */
function writeManifest() {
  const { name, ...rest } = JSON.parse(readFileSync(join(root, "npm", "package.json"), "utf8"));
  writeFileSync(join(output, "package.json"), JSON.stringify({ name, version, ...rest }, null, 2) + "\n");
}

rmSync(output, { recursive: true, force: true });
mkdirSync(output, { recursive: true });
await writeScripts();
writeTypes();
writeManifest();
copyFileSync(join(root, "npm", "README.md"), join(output, "README.md"));
// without the appendix, which says how to apply the licence
const [terms] = readFileSync(join(root, "LICENSE"), "utf8").split(/(?<=END OF TERMS AND CONDITIONS\n)/);
writeFileSync(join(output, "LICENSE"), terms);
console.log(`the npm package is in ${relative(process.cwd(), output)}`);
