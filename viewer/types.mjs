/** Declarations of the npm package, from the JSDoc of the sources. */

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, posix } from "node:path";
import { fileURLToPath } from "node:url";

import ts from "typescript";

const here = fileURLToPath(new URL(".", import.meta.url));

/** Write the declarations that some entries of `src` reach. @param {string[]} files @param {string} output folder */
export function writeTypes(files, output) {
  const source = join(here, "src");
  const entries = files.map((file) => join(source, file));
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
  const waiting = files.map((file) => file.replace(/\.js$/, ".d.ts"));
  const NAMING = ["package/index.d.ts", "three/index.d.ts"]; // they name types of other modules
  const written = new Set();
  for (let file; (file = waiting.pop()); ) {
    if (written.has(file)) continue;
    written.add(file);
    const more = join(here, "..", "npm", "types", file); // what JSDoc cannot say
    const own = all.get(file) ?? "";
    const text = (NAMING.includes(file) ? own : withoutInternal(own)) + (ts.sys.fileExists(more) ? readFileSync(more, "utf8") : "");
    for (const [, name] of text.matchAll(/(?:from |import\()"(\.[^"]+)\.js"/g)) {
      waiting.push(posix.join(posix.dirname(file), `${name}.d.ts`));
    }
    const path = join(output, file);
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
