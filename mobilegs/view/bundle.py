"""The viewer's ES modules as one script, for pages that bring everything along."""

import json
import re
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
WEB = FOLDER / "web"
SHADERS = FOLDER / "shaders"
IMPORT = re.compile(r'^import (?:\{([^}]*)\} from )?"([^"]+)";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async function|function|class|const) (\w+))", re.MULTILINE)
NOTHING = re.compile(r"^export \{\};\n", re.MULTILINE)
COMMENT = re.compile(r"^ */\*\*(?:(?!\*/).)*\*/\n", re.MULTILINE | re.DOTALL)


def bundle(entry: Path, replaced: dict[Path, str]) -> str:
    """One script that does what the module `entry` and all that it imports do.

    Each module becomes a function that is called once and returns what it exports. It is no
    general tool: our modules import by name and export declarations, and none in a circle.
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
        text = COMMENT.sub("", replaced.get(path) or path.read_text())

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
        number = len(parts)
        parts.append(
            f"const module{number} = (() => {{\n{text}return {{ {', '.join(exported)} }};\n}})();\n"
        )
        numbers[path] = number
        return number

    add(entry)
    return "".join(parts)


def page_script() -> str:
    """The viewer's page as one script, with its shaders and its loading thread inside.

    It shows the scene in the page's element `scene`, as base64, unless the address names another.
    """
    worker = json.dumps(bundle(WEB / "load" / "worker.js", {}))
    shaders = json.dumps({path.name: path.read_text() for path in sorted(SHADERS.glob("*.*sl"))})
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
  const text = atob(document.getElementById("scene").textContent);
  return new Blob([Uint8Array.from(text, (letter) => letter.charCodeAt(0))]);
}}
"""
    # what ends a script for HTML may stand in a text, where a backslash changes nothing
    return bundle(WEB / "page.js", {WEB / "files.js": own_files}).replace("</", "<\\/")
