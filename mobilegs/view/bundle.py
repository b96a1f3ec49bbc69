"""The viewer's ES modules as one script, for pages that bring everything along."""

import hashlib
import html
import json
import re
from functools import cache
from pathlib import Path

from mobilegs import __version__
from mobilegs.view.short_names import short_names

FOLDER = Path(__file__).resolve().parent
WEB = FOLDER / "web"
SHADERS = FOLDER / "shaders"
IMPORT = re.compile(r'^import (?:\{([^}]*)\} from )?"([^"]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async function|function|class|const) (\w+))", re.MULTILINE)
NOTHING = re.compile(r"^export \{\};\n", re.MULTILINE)
COMMENT = re.compile(r"/\*\*(?:(?!\*/).)*\*/|(?:^| +)//[^\n]*", re.MULTILINE | re.DOTALL)
REMARK = re.compile(r"//[^\n]*")  # shaders have no texts in which it could stand
INDENT = re.compile(r"\s*\n\s*")
BREAK = re.compile(r"(?<=[;{}])\n")  # where a line's end means nothing: all statements end in these
SHADER_BREAK = re.compile(r"(?<=[;{},])\n(?!#|\Z)")  # they are put together by lines
# texts, of which those in backquotes may have others within the braces of an expression
TEXT = re.compile(
    r"""("(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'"""
    r"|`(?:\\.|\$\{(?:[^`{}]|`(?:\\.|[^`\\])*`|\{[^{}]*\})*\}|[^`\\$]|\$(?!\{))*`)"
)
# where a line's end means nothing either: next to signs that no statement ends or begins with
WITHIN = re.compile(r"(?<=[,(\[=&|?:+])\n|\n(?=[)\]}.&|?:])")
# a name in brackets that say nothing: those of a cast, or of a function's only parameter
ALONE = re.compile(r"(?<=[=(,:?&|!])\((\w+)\)(?=[.,;)]|=>)")
SPACE = re.compile(r" ?([!=*<>?:|&,;{}()\[\]]+) ?")
# what an end that follows says as well: of a statement (loops have bodies), or of an item in a row
LAST = re.compile(r"[;,]+(?=})|,(?=\))")
CONST = re.compile(r"\bconst\b")  # one word packs better than two, and nothing relies on it
ZERO = re.compile(r"(?<![\w.])0(?=\.\d)")
SIGN = re.compile(r"(?<![-+]) ([-+/]=?) (?![-+])")  # two of them would be another sign
PRIVATE = re.compile(r"^(?:get |async )?#(\w{3,})\b", re.MULTILINE)
# of index.html, to be replaced
SCRIPT = '<script type="module" src="page.js"></script>'
TITLE = "<title>mobilegs</title>"
FILES = WEB / "files.js"
WORKER = WEB / "load" / "worker.js"
STYLE = WEB / "viewer" / "style.js"
STYLE_SPACE = re.compile(r"(?<=[:;,{])\s+|;?\s+(?=[{}])")


def bundle(entries: list[Path], replaced: dict[Path, str]) -> str:
    """A function `whole` that does what one of the modules `entries` does, told by its number.

    Each of them and of what they import is a function in it that returns what the module exports,
    in a row, called when it is first asked for. A function knows its own text, so `whole` can give
    it to a thread that does what another entry does. It is no general tool: our modules import by
    name and export declarations, and none in a circle. Comments, indentation and spaces around
    signs are left out; private, local and imported names are short. `replaced` gives other texts
    for some modules.
    """
    numbers = {path: number for number, path in enumerate(entries)}
    parts: dict[int, str] = {}
    exports: dict[int, list[str]] = {}  # each is known to others by its place in here
    under_way: set[Path] = set()

    def add(path: Path) -> int:
        path = path.resolve()
        assert path not in under_way, f"{path} imports itself by way of others"
        number = numbers.setdefault(path, len(numbers))
        if number in parts:
            return number
        under_way.add(path)
        text = INDENT.sub("\n", COMMENT.sub("", replaced.get(path) or path.read_text())).lstrip()

        def imported(match: re.Match[str]) -> str:
            names, source = match.groups()
            there = add(path.parent / source)
            if names is None:
                return f"module({there});\n"
            pairs = [name.strip().split(" as ") for name in names.split(",") if name.strip()]
            known = {pair[0]: pair[-1] for pair in pairs}
            places = ", ".join(known.pop(name, "") for name in exports[there])
            assert not known, f"{source} exports no {', '.join(known)}"
            return f"const [{places.rstrip(', ')}] = module({there});\n"

        text = NOTHING.sub("", IMPORT.sub(imported, text))
        exports[number] = [match[1] for match in EXPORT.finditer(text)]
        text = EXPORT.sub("", text) + f"return [{', '.join(exports[number])}];\n"
        assert "import.meta" not in text, f"{path} asks where it lies"
        parts[number] = f"() => {{\n{_short_locals(_short_names(text))}}},\n"
        under_way.remove(path)
        return number

    for entry in entries:
        add(entry)
    modules = BREAK.sub("", "".join(parts[number] for number in range(len(numbers))))
    modules = _squeezed(modules)
    return f"""function whole(entry) {{
const made = [];
const module = (number) => (made[number] ??= modules[number]());
const modules = [
{modules}];
module(entry);
}}"""


def _short_locals(text: str) -> str:
    """The same module with short names for what is local to it."""
    pieces = TEXT.split(text)
    pieces[::2] = short_names(pieces[::2], pieces[1::2])
    return "".join(pieces)


def _squeezed(text: str) -> str:
    """The same program without what signs do not need; patterns must not hold quotes or spaces."""
    pieces = TEXT.split(text)  # code and texts in turns
    assert all(piece.count("${") <= piece.count("}") for piece in pieces[1::2]), "texts in texts"
    for sign, instead in (
        (SIGN, r"\1"),
        (SPACE, r"\1"),
        (WITHIN, ""),
        (ALONE, r"\1"),
        (LAST, ""),
        (CONST, "let"),
        (ZERO, ""),
    ):
        pieces[::2] = [sign.sub(instead, code) for code in pieces[::2]]
    return "".join(pieces)


def _short_names(text: str) -> str:
    """The same module with short names for what is private to its classes."""
    for i, name in enumerate(sorted(set(PRIVATE.findall(text)), key=len, reverse=True)):
        used = re.compile(rf"(?:(?<=\.)|(?<=^)|(?<=^get )|(?<=^async ))#{name}\b", re.MULTILINE)
        text = used.sub(f"#{chr(97 + i % 26)}{i // 26 or ''}", text)
    return text


def slim_shader(text: str) -> str:
    """The same shader without remarks, indentation and spaces around signs. It has no macros."""
    assert "#define" not in text, "what a macro is depends on spaces"
    text = INDENT.sub("\n", REMARK.sub("", text)).lstrip()
    return SHADER_BREAK.sub("", SPACE.sub(r"\1", SIGN.sub(r"\1", text)))


@cache
def viewer_script() -> str:
    """The viewer's page as one script, with its shaders and its loading thread inside.

    It shows the scene that the address names, or else the one in the page's element `scene`, as
    base64, or else the one of the page's `<mobile-gs>`.
    """
    return _script(WEB / "page.js")


@cache
def viewer_version() -> str:
    """What changes with the viewer's script."""
    return hashlib.sha256(viewer_script().encode()).hexdigest()[:16]


def shown(title: str) -> str:
    """A title for a page; what is no text, as in names of files, is replaced."""
    return html.escape(title.encode(errors="surrogateescape").decode(errors="replace"))


def linked(path: str) -> str:
    """What in a page begins the viewer whose script is at a path, behind its element.

    Its address changes with it: browsers may keep it, and threads are of the page's version.
    """
    address = f"{path}?{viewer_version()}"
    early = INDENT.sub("\n", COMMENT.sub("", (WEB / "early.js").read_text())).strip()
    assert early.count('"viewer.js"') == 1
    early = early.replace('"viewer.js"', json.dumps(address))
    return f'<script>\n{early}\n</script>\n    <script type="module" src="{address}"></script>'


@cache
def element_script() -> str:
    """`<mobile-gs>` for other pages as one script."""
    return _script(WEB / "element.js")


def _script(entry: Path) -> str:
    """A page's part and its thread's: what each of them is finds out which it shall be."""
    files = sorted(SHADERS.glob("*.*sl"))
    shaders = json.dumps({file.name: slim_shader(file.read_text()) for file in files})
    own_files = f"""
const SHADERS = {shaders};
export function newWorker() {{
  const url = URL.createObjectURL(new Blob([`(${{whole}})(1)`], {{ type: "text/javascript" }}));
  setTimeout(() => URL.revokeObjectURL(url), 60000);
  return new Worker(url);
}}
export function loadingWorker(request, take) {{
  const early = globalThis.earlyWorker;
  delete globalThis.earlyWorker;
  let worker = early?.worker;
  if (early?.url !== request.url) worker = worker?.terminate();
  if (worker) early.held.forEach(take);
  else {{
    worker = newWorker();
    worker.postMessage(request);
  }}
  worker.onmessage = take;
  return worker;
}}
export async function findAdapter() {{
  const early = globalThis.earlyAdapter;
  delete globalThis.earlyAdapter;
  return (await early) ?? navigator.gpu.requestAdapter({{ powerPreference: "high-performance" }});
}}
export async function shaderText(file) {{
  return SHADERS[file];
}}
export function version() {{
  return "{__version__}";
}}
export function ownScene() {{
  const element = document.getElementById("scene");
  if (element === null) return null;
  const text = atob(element.textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  return new Blob([bytes]);
}}
"""
    replaced = {FILES: own_files, STYLE: STYLE_SPACE.sub("", STYLE.read_text())}
    text = f"({bundle([entry, WORKER], replaced)})(globalThis.document ? 0 : 1);\n"
    # what ends a script for HTML may stand in a text, where a backslash changes nothing
    return text.replace("</", "<\\/")
