"""The viewer's ES modules as one script, for pages that bring everything along."""

import json
import re
from functools import cache
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
WEB = FOLDER / "web"
SHADERS = FOLDER / "shaders"
IMPORT = re.compile(r'^import (?:\{([^}]*)\} from )?"([^"]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async function|function|class|const) (\w+))", re.MULTILINE)
NOTHING = re.compile(r"^export \{\};\n", re.MULTILINE)
COMMENT = re.compile(r"/\*\*(?:(?!\*/).)*\*/|(?:^| +)//[^\n]*", re.MULTILINE | re.DOTALL)
REMARK = re.compile(r"//[^\n]*")  # shaders have no texts in which it could stand
INDENT = re.compile(r"\s*\n\s*")
PRIVATE = re.compile(r"^(?:get |async )?#(\w{3,})\b", re.MULTILINE)


def bundle(entry: Path, replaced: dict[Path, str]) -> str:
    """One script that does what the module `entry` and all that it imports do.

    Each module becomes a function that is called once and returns what it exports. It is no
    general tool: our modules import by name and export declarations, and none in a circle.
    Comments and indentation are left out, private names are short.
    `replaced` gives other texts for some modules.
    """
    numbers: dict[Path, int] = {}
    parts: list[str] = []

    def add(path: Path) -> int:
        path = path.resolve()
        if path in numbers:
            assert numbers[path] >= 0, f"{path} imports itself by way of others"
            return numbers[path]
        numbers[path] = -1
        text = INDENT.sub("\n", COMMENT.sub("", replaced.get(path) or path.read_text())).lstrip()

        def imported(match: re.Match[str]) -> str:
            names, source = match.groups()
            number = add(path.parent / source)
            if names is None:
                return ""
            return f"const {{{names.replace(' as ', ': ')}}} = module{number};\n"

        text = NOTHING.sub("", IMPORT.sub(imported, text))
        exported = [match[1] for match in EXPORT.finditer(text)]
        text = EXPORT.sub("", text)
        assert "import.meta" not in text, f"{path} asks where it lies"
        text = _short_names(text)
        number = len(parts)
        parts.append(
            f"const module{number} = (() => {{\n{text}return {{ {', '.join(exported)} }};\n}})();\n"
        )
        numbers[path] = number
        return number

    add(entry)
    return "".join(parts)


def _short_names(text: str) -> str:
    """The same module with short names for what is private to its classes."""
    for i, name in enumerate(sorted(set(PRIVATE.findall(text)), key=len, reverse=True)):
        used = re.compile(rf"(?:(?<=\.)|(?<=^)|(?<=^get )|(?<=^async ))#{name}\b", re.MULTILINE)
        text = used.sub(f"#{chr(97 + i % 26)}{i // 26 or ''}", text)
    return text


def slim_shader(text: str) -> str:
    """The same shader without remarks and indentation."""
    return INDENT.sub("\n", REMARK.sub("", text)).lstrip()


@cache
def viewer_script() -> str:
    """The viewer's page as one script, with its shaders and its loading thread inside.

    It shows the scene that the address names, or else the one in the page's element `scene`, as
    base64, or else the one of the page's `<mobile-gs>`.
    """
    return _whole(WEB / "page.js")


@cache
def element_script() -> str:
    """`<mobile-gs>` for other pages as one script."""
    return _whole(WEB / "element.js")


def _whole(entry: Path) -> str:
    worker = json.dumps(bundle(WEB / "load" / "worker.js", {}))
    files = sorted(SHADERS.glob("*.*sl"))
    shaders = json.dumps({file.name: slim_shader(file.read_text()) for file in files})
    own_files = f"""
const WORKER = {worker};
const SHADERS = {shaders};
export function loadingWorker() {{
  const url = URL.createObjectURL(new Blob([WORKER], {{ type: "text/javascript" }}));
  setTimeout(() => URL.revokeObjectURL(url), 60000);
  return new Worker(url);
}}
export async function shaderText(file) {{
  return SHADERS[file];
}}
export function ownScene() {{
  const element = document.getElementById("scene");
  if (element === null) return null;
  const text = atob(element.textContent);
  return new Blob([Uint8Array.from(text, (letter) => letter.charCodeAt(0))]);
}}
"""
    # what ends a script for HTML may stand in a text, where a backslash changes nothing
    return bundle(entry, {WEB / "files.js": own_files}).replace("</", "<\\/")
