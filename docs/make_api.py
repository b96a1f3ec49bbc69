"""Writes docs/api.md and docs/settings.md from the sources: signatures, docstrings, defaults.

    python docs/make_api.py

A test holds the pages to what this makes. Signatures are the sources' own text, so that neither
decorators nor versions of Python change them.
"""

import ast
import dataclasses
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import mobilegs

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "mobilegs"
WIDTH = 92
LITERAL = 60  # characters: longer choices are named
API, SETTINGS = "docs/api.md", "docs/settings.md"
API_HEAD = """\
# The Python interface

Made by `python docs/make_api.py` from the sources. Everything here comes from the package itself,
`from mobilegs import open_scene`, and is imported when it is first asked for. What is not here may
change without a word. `examples/` has programs that use most of it; `docs/conventions.md` has axes,
units and shapes. Shapes stand in the types as [jaxtyping](https://docs.kidger.site/jaxtyping/)
writes them: `Float[Tensor, "n 3"]`.

Whatever cannot be used (a damaged file, a capture without poses, a setting that does not exist)
raises `InputError`, whose text is one sentence.
"""
SETTINGS_HEAD = """\
# Every setting of a training

Made by `python docs/make_api.py` from the sources. `mobilegs train --set PATH=VALUE ...` changes
any of these (`compress` has it, too), `with_settings` does it in Python, and `config.json` in a run
has what it was made with. Where presets differ, each is named; `--steps`, `--max-splats`,
`--method` and `--views-per-step` are short for some of them.
"""
SECTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "Scenes": (
        "A scene is `Gaussians` and how they are to be blended. `open_scene` reads all kinds of "
        "files.",
        ("open_scene", "inspect_scene", "Scene", "Gaussians", "InputError"),
    ),
    "Pictures": (
        "A `Camera` and a `Scene` give a picture: `scene.render(camera).image`. `render_sorted` "
        "and `render_sortfree` take tensors, have gradients for all of them, and run the kernels "
        "of the device on which these are.",
        (
            "Camera",
            "look_at",
            "Rendered",
            "to_bytes",
            "render_sorted",
            "render_sortfree",
            "Weighting",
            "GpuRenderer",
        ),
    ),
    "Captures": (
        "Photos with poses. Reading a capture decodes no photo yet.",
        (
            "load_capture",
            "Dataset",
            "Frame",
            "View",
            "load_view",
            "ViewLoader",
            "CaptureRun",
            "capture_photos",
            "sample_capture",
            "write_sample",
        ),
    ),
    "Training": (
        "`train_run` is `mobilegs train`, `compress_run` is `mobilegs compress`. A `Recipe` says "
        "all that decides what comes out, the capture and the seed aside; `docs/settings.md` lists "
        "its fields.",
        (
            "TrainRun",
            "train_run",
            "CompressRun",
            "compress_run",
            "SortedExport",
            "export_sorted",
            "Recipe",
            "cpu_recipe",
            "gpu_recipe",
            "demo_recipe",
            "with_steps",
            "with_method",
            "with_settings",
        ),
    ),
    "Figures": (
        "How near pictures are to photos.",
        ("evaluate_side_by_side", "psnr", "ssim", "as_displayed", "lpips_from"),
    ),
    "`.mgs` files": (
        "Codes are what a file holds; `CodedScene.decode` makes a scene of them "
        "(`docs/format.md`).",
        ("read_mgs", "write_mgs", "unpack", "pack", "CodedScene", "layered"),
    ),
    "Files of other tools": (
        "Plain 3DGS scenes (`docs/formats.md`).",
        (
            "read_ply",
            "write_ply",
            "read_spz",
            "write_spz",
            "read_sog",
            "write_sog",
            "read_glb",
            "write_glb",
            "read_splat",
        ),
    ),
    "Showing": (
        "The web viewer, packed or served (`docs/phone.md`).",
        ("export_html", "export_site", "Server"),
    ),
}

Definition = ast.FunctionDef | ast.ClassDef


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def source_of(module: str) -> Path:
    path = PACKAGE / module.replace(".", "/")
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def definition(module: str, name: str) -> Definition:
    """Where a module defines a name."""
    for node in parsed(source_of(module)).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return node
    raise LookupError(f"mobilegs.{module} defines no {name}: PUBLIC must name the module that does")


# --- signatures -----------------------------------------------------------------------------------


@cache
def choices() -> dict[str, str]:
    """What names of choices stand for: `PresetName` -> `Literal['cpu', ...]`."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in parsed(path).body:
            if isinstance(node, ast.Assign) and ast.unparse(node.value).startswith("Literal["):
                literal = ast.unparse(node.value)
                if len(literal) <= LITERAL:
                    found[ast.unparse(node.targets[0])] = literal
    return found


@cache
def constants() -> dict[str, str]:
    """What names of numbers and texts stand for: `NEAR` -> `0.2`."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in parsed(path).body:
            if isinstance(node, ast.Assign):
                value = ast.unparse(node.value)
                if re.fullmatch(r"[\d./ ]+|'[^']*'", value):
                    found[ast.unparse(node.targets[0])] = value.replace("'", '"')
    return found


def kind(annotation: ast.expr | None) -> str:
    """A type as text, without what only the command line needs."""
    if annotation is None:
        return ""
    text = ast.unparse(annotation)
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) == "Annotated":
        inner = annotation.slice
        text = kind(inner.elts[0] if isinstance(inner, ast.Tuple) else inner)
    text = re.sub(r"Positional\[(\w+)\]", r"\1", text)
    for name, literal in choices().items():
        text = re.sub(rf"\b{name}\b", literal, text)
    return text.replace("'", '"') if "[" in text else text.strip("'\"")


def laid_out(name: str, parts: list[str], returns: str) -> str:
    """A signature, a parameter a line where one line does not hold it."""
    end = f" -> {returns}" if returns else ""
    line = f"{name}({', '.join(parts)}){end}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{name}(", *(f"    {part}," for part in parts), f"){end}"])


def parameters(function: ast.FunctionDef) -> Iterator[str]:
    given = function.args
    ordinary = [*given.posonlyargs, *given.args]
    plain = [None] * (len(ordinary) - len(given.defaults))
    for argument, default in zip(ordinary, [*plain, *given.defaults], strict=True):
        if argument.arg not in ("self", "cls"):
            yield with_default(argument.arg, argument.annotation, default)
    if given.kwonlyargs:
        yield "*"
    for argument, default in zip(given.kwonlyargs, given.kw_defaults, strict=True):
        yield with_default(argument.arg, argument.annotation, default)


def with_default(name: str, annotation: ast.expr | None, default: ast.expr | None) -> str:
    text = f"{name}: {kind(annotation)}"
    if default is None:
        return text
    value = ast.unparse(default).replace("'", '"')
    value = constants().get(value, value)
    if match := re.search(r"field\(default_factory=(?:lambda: )?(.*)\)$", value):
        value = match[1] if match[1].endswith(")") else f"{match[1]}()"
    return f"{text} = {value}"


def fields_of(node: ast.ClassDef) -> list[tuple[ast.AnnAssign, str]]:
    """The fields of a dataclass or named tuple, each with the docstring beneath it."""
    found = []
    for item, below in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(item, ast.AnnAssign):
            text = below.value if isinstance(below, ast.Expr) else None
            said = text.value if isinstance(text, ast.Constant) else ""
            found.append((item, " ".join(str(said).split())))
    return found


# --- descriptions ---------------------------------------------------------------------------------

LISTED = re.compile(r"^(Attributes|Args|Raises|Returns):$")


def described(node: ast.FunctionDef | ast.ClassDef) -> str:
    """A docstring in Markdown: what is listed under `Attributes:` and the like becomes a list."""
    lines, inside = [], False
    for line in (ast.get_docstring(node) or "").splitlines():
        if match := LISTED.match(line):
            inside = True
            lines += [f"*{match[1]}*", ""]
        elif inside and re.match(r"^    \S", line):
            name, colon, rest = line.strip().partition(":")
            words = ", ".join(f"`{word}`" for word in name.split(", "))
            lines.append(f"- {words}:{rest}" if colon else f"- {line.strip()}")
        elif inside and line.startswith("        "):
            lines.append(f"  {line.strip()}")
        else:
            inside = inside and not line
            lines.append(line)
    return "\n".join(lines).strip()


def is_property(node: ast.FunctionDef) -> bool:
    return any(ast.unparse(decorator) == "property" for decorator in node.decorator_list)


def function_entry(node: ast.FunctionDef) -> str:
    sign = laid_out(node.name, list(parameters(node)), kind(node.returns))
    return f"```python\n{sign}\n```\n\n{described(node)}"


def class_entry(node: ast.ClassDef) -> str:
    fields = fields_of(node)
    methods = [item for item in node.body if isinstance(item, ast.FunctionDef)]
    begin = next((method for method in methods if method.name == "__init__"), None)
    bases = [ast.unparse(base) for base in node.bases]
    if begin is not None:
        parts = list(parameters(begin))
    else:
        parts = [with_default(str(ast.unparse(f.target)), f.annotation, f.value) for f, _ in fields]
    text = [f"```python\n{laid_out(f'class {node.name}', parts, '')}\n```", described(node)]
    if not parts and bases:
        text[0] = f"```python\nclass {node.name}({', '.join(bases)})\n```"
    if begin is not None and ast.get_docstring(begin):
        text.append(described(begin))
    told = [f"- `{ast.unparse(field.target)}`: {said}" for field, said in fields if said]
    if told:
        text += ["*Fields*", "\n".join(told)]
    rows = []
    for method in methods:
        if method.name.startswith(("_", "do_")) or not ast.get_docstring(method):
            continue
        said = " ".join((ast.get_docstring(method) or "").split("\n\n")[0].split())
        if is_property(method):
            rows.append(f"- `.{method.name} -> {kind(method.returns)}`: {said}")
        else:
            sign = f"{method.name}({', '.join(parameters(method))})"
            returns = kind(method.returns)
            end = f" -> {returns}" if returns not in ("", "None") else ""
            rows.append(f"- `.{sign}{end}`: {said}")
    if rows:
        text += ["*Methods and properties*", "\n".join(rows)]
    return "\n\n".join(part for part in text if part)


def api_page() -> str:
    """The text of docs/api.md."""
    homes = {name: module for module, names in mobilegs.PUBLIC.items() for name in names}
    listed = [name for _, names in SECTIONS.values() for name in names]
    if sorted(listed) != sorted(homes):
        raise LookupError(f"in one list alone: {sorted(set(listed) ^ set(homes))}")
    text = [API_HEAD]
    for title, (intro, names) in SECTIONS.items():
        row = " · ".join(f"[`{name}`](#{name.lower()})" for name in names)
        text += [f"## {title}\n", f"{intro}\n", f"{row}\n"]
        for name in names:
            node = definition(homes[name], name)
            entry = class_entry(node) if isinstance(node, ast.ClassDef) else function_entry(node)
            text += [f"### {name}\n", f"{entry}\n"]
    return "\n".join(text)


# --- settings -------------------------------------------------------------------------------------


def settings_page() -> str:
    """The text of docs/settings.md."""
    recipes = {
        "cpu": mobilegs.cpu_recipe(),
        "gpu": mobilegs.gpu_recipe(),
        "demo": mobilegs.demo_recipe(),
    }
    text = [SETTINGS_HEAD]
    for stage in ("teacher", "student"):
        text += [f"## {stage}\n", "| setting | value | what it does |", "|---|---|---|"]
        text += list(rows_of(stage, {name: getattr(r, stage) for name, r in recipes.items()}))
        text.append("")
    return "\n".join(text)


def rows_of(path: str, configs: dict[str, Any]) -> Iterator[str]:
    """A row for each field, those of dataclasses within it included."""
    first = next(iter(configs.values()))
    module = type(first).__module__.removeprefix("mobilegs.")
    node = definition(module, type(first).__name__)
    assert isinstance(node, ast.ClassDef)
    said = {ast.unparse(field.target): text for field, text in fields_of(node)}
    for field in dataclasses.fields(first):
        values = {name: getattr(config, field.name) for name, config in configs.items()}
        if dataclasses.is_dataclass(values["cpu"]):
            yield from rows_of(f"{path}.{field.name}", values)
            continue
        shown = {name: f"`{short(value)}`" for name, value in values.items()}
        if len(set(shown.values())) == 1:
            value = shown["cpu"]
        else:
            value = ", ".join(f"{name} {text}" for name, text in shown.items())
        yield f"| `{path}.{field.name}` | {value} | {said[field.name].replace('|', '/')} |"


def short(value: Any) -> str:
    """A default as people would write it."""
    text = str(value)
    return f"{value:.4g}" if isinstance(value, float) and len(text) > 8 else text


def main() -> int:
    """Write both pages."""
    for file, page in ((API, api_page()), (SETTINGS, settings_page())):
        (ROOT / file).write_text(page)
        print(f"{file}: {len(page.splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
