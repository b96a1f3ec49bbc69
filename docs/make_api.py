"""Write docs/reference/settings.md, cli.md and api.md from the sources.

    python docs/make_api.py

The first two are committed, and a test compares them with the output of this script. api.md is
not: `make docs` makes it. A test compares its signatures with `inspect.signature`; they are text of
the sources, so that they do not change with decorators and versions of Python. settings.md also
compares the presets of the paper with its statements, from docs/paper_statements.csv.
"""

import ast
import contextlib
import csv
import dataclasses
import io
import os
import re
import sys
from collections.abc import Iterator
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any
from unittest import mock

import mobilegs
from mobilegs.cli import main as command_line
from mobilegs.train.recipes import RECIPES

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "mobilegs"
WIDTH = 92
LITERAL = 60  # characters: longer choices are named
API, SETTINGS = "docs/reference/api.md", "docs/reference/settings.md"
COMMANDS, COLUMNS = "docs/reference/cli.md", 88
COMMANDS_HEAD = """\
# The command line

Made by `python docs/make_api.py` from the verbs' `--help`.
"""
API_HEAD = """\
# The Python interface

Made by `make docs` from the sources. The package exports everything here by name,
as in `from mobilegs import open_scene`, and imports a module at the first use of one of its
names. Other names may change without notice. [Examples](../tutorials/examples.md) use
most of it; [conventions](conventions.md) define axes, units and shapes. Types have shapes as
[jaxtyping](https://docs.kidger.site/jaxtyping/) writes them: `Float[Tensor, "n 3"]`.

Input that cannot be used (a damaged file, a capture without poses, an unknown setting) raises
`InputError`, whose text is one sentence.
"""
SETTINGS_HEAD = """\
# Settings of a training

Made by `python docs/make_api.py` from the sources. `mobilegs train --set PATH=VALUE ...` and
`mobilegs compress --set ...` change any of these, `with_settings` does so in Python, and a
run's `config.json` has the values that it used. If presets differ, each is named. `--steps`,
`--max-splats`, `--method` and `--views-per-step` are short for some of them. A run with a budget of
time, the default, chooses steps, numbers of Gaussians and the teacher's learning rates itself.
"""
STATEMENTS = ROOT / "docs/paper_statements.csv"
PRESETS_HEAD = """\
## The presets `paper` and `release`

`--preset paper` follows the paper's text, and the paper's release where the text is silent.
`--preset release` follows the release, with its errors as far as settings reach. Both are as long
as the preset `long`. [What each departure gains](../explanation/paper_settings.md) has the figures.

| statement of the paper | setting | `paper` | `release` | `long` |
|---|---|---|---|---|"""
SECTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "Scenes": (
        "A scene is `Gaussians` and how to blend them. `open_scene` reads all formats.",
        (
            "open_scene",
            "inspect_scene",
            "SceneContents",
            "MgsFileContents",
            "Scene",
            "Gaussians",
            "InputError",
        ),
    ),
    "Rendering": (
        "`scene.render(camera).image` renders a `Scene` from a `Camera`. `render_sorted` and "
        "`render_sortfree` take tensors, give gradients for all of them, and run the kernels of "
        "their device.",
        (
            "Camera",
            "look_at",
            "Rendered",
            "to_bytes",
            "render_sorted",
            "render_sortfree",
            "Weighting",
            "WgpuRenderer",
        ),
    ),
    "Captures": (
        "Photos with poses. `load_capture` does not decode the photos.",
        (
            "load_capture",
            "Dataset",
            "Frame",
            "View",
            "load_view",
            "ViewLoader",
            "CaptureRun",
            "capture_photos",
            "CaptureReport",
            "demo_capture",
            "write_capture",
        ),
    ),
    "Training": (
        "`train_capture` is `mobilegs train`, `compress_scene` is `mobilegs compress`. A `Recipe` "
        "and a seed determine the result for a capture; [settings](settings.md) lists its fields. "
        "`Teacher`, `Student` and the losses are for loops of your own (examples/loop.py).",
        (
            "TrainRun",
            "train_capture",
            "CompressRun",
            "compress_scene",
            "SortedExport",
            "export_sorted",
            "Teacher",
            "TeacherConfig",
            "Student",
            "StudentConfig",
            "StepResult",
            "photo_loss",
            "color_distillation_loss",
            "depth_distillation_loss",
            "raw_depth_loss",
            "Recipe",
            "demo_recipe",
            "short_recipe",
            "long_recipe",
            "with_steps",
            "with_method",
            "with_settings",
        ),
    ),
    "Metrics": (
        "Metrics that compare renders with photos.",
        (
            "evaluate_side_by_side",
            "Metrics",
            "ViewMetrics",
            "SceneMetrics",
            "RunMetrics",
            "FileMetrics",
            "psnr",
            "ssim",
            "displayed_colors",
            "lpips_from",
        ),
    ),
    "`.mgs` files": (
        "A `QuantizedScene` is what a file holds; its `decode` makes a scene of it "
        "([the format](format.md)).",
        (
            "read_mgs",
            "write_mgs",
            "decode_mgs",
            "encode_mgs",
            "QuantizedScene",
            "with_lod_levels",
            "MgsContents",
            "StreamContents",
        ),
    ),
    "Files of other tools": (
        "Plain 3DGS scenes ([formats](formats.md)). `write_gaussians` writes every kind, turns a "
        "scene upright for a file that cannot name its upward direction, and logs what a file does "
        "not hold. The writers of one kind do neither.",
        (
            "write_gaussians",
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
    "Viewer": (
        "The web viewer, exported or served ([on a phone](../guides/phone.md)).",
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
    """Return the definition of a name in a module."""
    for node in parsed(source_of(module)).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return node
    raise LookupError(f"mobilegs.{module} defines no {name}: PUBLIC must name the module that does")


# --- signatures -----------------------------------------------------------------------------------


def assigned(module: str, name: str) -> ast.expr | None:
    """Return the value that `name` has in `module`, assigned there or in the module it comes from.

    A name is looked up where it is used: two modules may give one name two values.
    """
    for node in parsed(source_of(module)).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name:
            return node.value
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("mobilegs."):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return assigned(str(node.module).removeprefix("mobilegs."), alias.name)
    return None


def spelled_out(module: str, name: str) -> str:
    """Return the number, text or short `Literal` that `name` stands for in `module`, or `name`."""
    value = assigned(module, name)
    text = "" if value is None else ast.unparse(value)
    literal = text.startswith("Literal[") and len(text) <= LITERAL
    return text if literal or re.fullmatch(r"[\d./ ]+|'[^']*'", text) else name


def kind(module: str, annotation: ast.expr | None) -> str:
    """Return a type of `module` as text, without the options that only the command line needs."""
    if annotation is None:
        return ""
    text = ast.unparse(annotation)
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) == "Annotated":
        inner = annotation.slice
        text = kind(module, inner.elts[0] if isinstance(inner, ast.Tuple) else inner)
    text = re.sub(r"Positional\[(\w+)\]", r"\1", text)
    for node in ast.walk(annotation):
        if isinstance(node, ast.Name):
            text = re.sub(rf"\b{node.id}\b", lambda _, n=node: spelled_out(module, n.id), text)
    return text.replace("'", '"') if "[" in text else text.strip("'\"")


def laid_out(name: str, parts: list[str], returns: str) -> str:
    """Lay out a signature in one line, or with one parameter per line if it is long."""
    end = f" -> {returns}" if returns else ""
    line = f"{name}({', '.join(parts)}){end}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{name}(", *(f"    {part}," for part in parts), f"){end}"])


def parameters(module: str, function: ast.FunctionDef) -> Iterator[str]:
    given = function.args
    ordinary = [*given.posonlyargs, *given.args]
    plain = [None] * (len(ordinary) - len(given.defaults))
    for argument, default in zip(ordinary, [*plain, *given.defaults], strict=True):
        if argument.arg not in ("self", "cls"):
            yield with_default(module, argument.arg, argument.annotation, default)
    if given.kwonlyargs:
        yield "*"
    for argument, default in zip(given.kwonlyargs, given.kw_defaults, strict=True):
        yield with_default(module, argument.arg, argument.annotation, default)


def with_default(
    module: str, name: str, annotation: ast.expr | None, default: ast.expr | None
) -> str:
    text = f"{name}: {kind(module, annotation)}"
    if default is None:
        return text
    value = ast.unparse(default)
    if isinstance(default, ast.Name):
        value = spelled_out(module, value)
    value = value.replace("'", '"')
    if match := re.search(r"field\(default_factory=(?:lambda: )?(.*)\)$", value):
        value = match[1] if match[1].endswith(")") else f"{match[1]}()"
    return f"{text} = {value}"


def fields_of(node: ast.ClassDef) -> list[tuple[ast.AnnAssign, str]]:
    """Return the own fields of a dataclass or named tuple, each with the docstring below it.

    Those that no argument sets are left out.
    """
    fields = []
    for item, below in zip(node.body, [*node.body[1:], None], strict=True):
        if isinstance(item, ast.AnnAssign) and "init=False" not in ast.unparse(item):
            text = below.value if isinstance(below, ast.Expr) else None
            said = text.value if isinstance(text, ast.Constant) else ""
            fields.append((item, " ".join(str(said).split())))
    return fields


def base_of(module: str, node: ast.ClassDef) -> tuple[str, ast.ClassDef] | None:
    """Return our class from which another one inherits, with its module."""
    name = ast.unparse(node.bases[0]) if node.bases else ""
    for item in parsed(source_of(module)).body:
        if isinstance(item, ast.ImportFrom) and name in (alias.name for alias in item.names):
            module = str(item.module).removeprefix("mobilegs.")
            if module == item.module:  # of another package
                return None
    try:
        base = definition(module, name)
    except LookupError:
        return None
    return (module, base) if isinstance(base, ast.ClassDef) else None


def is_typed_dict(module: str, node: ast.ClassDef) -> bool:
    base = base_of(module, node)
    return any(ast.unparse(each) == "TypedDict" for each in node.bases) or (
        base is not None and is_typed_dict(*base)
    )


# --- descriptions ---------------------------------------------------------------------------------

LISTED = re.compile(r"^(Attributes|Args|Raises|Returns):$")


def described(node: ast.FunctionDef | ast.ClassDef) -> str:
    """Return a docstring as Markdown, with `Attributes:`, `Args:` and the like as lists."""
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


def function_entry(module: str, node: ast.FunctionDef) -> str:
    sign = laid_out(node.name, list(parameters(module, node)), kind(module, node.returns))
    return f"```python\n{sign}\n```\n\n{described(node)}"


def class_entry(module: str, node: ast.ClassDef) -> str:
    fields, base = fields_of(node), base_of(module, node)
    methods = [item for item in node.body if isinstance(item, ast.FunctionDef)]
    begin = next((method for method in methods if method.name == "__init__"), None)
    bases = [ast.unparse(base) for base in node.bases]
    if begin is not None:
        parts = list(parameters(module, begin))
    else:
        parts = [
            with_default(module, ast.unparse(f.target), f.annotation, f.value) for f, _ in fields
        ]
        if base is not None and fields_of(base[1]):  # a dataclass of keyword-only fields
            more = fields_of(base[1])
            parts += [
                "*",
                *(
                    with_default(base[0], ast.unparse(f.target), f.annotation, f.value)
                    for f, _ in more
                ),
            ]
            fields += more
    text = [f"```python\n{laid_out(f'class {node.name}', parts, '')}\n```", described(node)]
    if is_typed_dict(module, node) or (not parts and bases):
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
            rows.append(f"- `.{method.name} -> {kind(module, method.returns)}`: {said}")
        else:
            sign = f"{method.name}({', '.join(parameters(module, method))})"
            returns = kind(module, method.returns)
            end = f" -> {returns}" if returns not in ("", "None") else ""
            rows.append(f"- `.{sign}{end}`: {said}")
    if rows:
        text += ["*Methods and properties*", "\n".join(rows)]
    return "\n\n".join(part for part in text if part)


def api_page() -> str:
    """The text of docs/reference/api.md."""
    homes = {name: module for module, names in mobilegs.PUBLIC.items() for name in names}
    listed = [name for _, names in SECTIONS.values() for name in names]
    if sorted(listed) != sorted(homes):
        raise LookupError(
            f"in SECTIONS or PUBLIC, but not in both: {sorted(set(listed) ^ set(homes))}"
        )
    text = [API_HEAD]
    for title, (intro, names) in SECTIONS.items():
        row = " · ".join(f"[`{name}`](#{name.lower()})" for name in names)
        text += [f"## {title}\n", f"{intro}\n", f"{row}\n"]
        for name in names:
            module, node = homes[name], definition(homes[name], name)
            is_class = isinstance(node, ast.ClassDef)
            entry = class_entry(module, node) if is_class else function_entry(module, node)
            text += [f"### {name}\n", f"{entry}\n"]
    return "\n".join(text)


# --- settings -------------------------------------------------------------------------------------


def settings_page() -> str:
    """The text of docs/reference/settings.md."""
    recipes = {
        "demo": mobilegs.demo_recipe(),
        "short": mobilegs.short_recipe(),
        "long": mobilegs.long_recipe(),
    }
    text = [SETTINGS_HEAD]
    for stage in ("teacher", "student"):
        text += [f"## {stage}\n", "| setting | value | what it does |", "|---|---|---|"]
        text += list(rows_of(stage, {name: getattr(r, stage) for name, r in recipes.items()}))
        text.append("")
    text += [PRESETS_HEAD, *preset_rows(), ""]
    return "\n".join(text)


def preset_rows() -> Iterator[str]:
    """Yield a table row per statement of the paper, with the value of each preset."""
    recipes = [RECIPES[name]() for name in ("paper", "release", "long")]
    with STATEMENTS.open(newline="") as file:
        for row in csv.DictReader(file):
            values = [short(attrgetter(row["setting"])(recipe)) for recipe in recipes]
            yield f"| {row['statement']} | `{row['setting']}` | {' | '.join(values)} |"


def rows_of(path: str, configs: dict[str, Any]) -> Iterator[str]:
    """Return a table row per field, nested dataclasses included."""
    first = next(iter(configs.values()))
    said = {}
    for kind in type(first).__mro__[:-1]:
        node = definition(kind.__module__.removeprefix("mobilegs."), kind.__name__)
        assert isinstance(node, ast.ClassDef)
        said |= {ast.unparse(field.target): text for field, text in fields_of(node)}
    for field in dataclasses.fields(first):
        values = {name: getattr(config, field.name) for name, config in configs.items()}
        if dataclasses.is_dataclass(values["demo"]):
            yield from rows_of(f"{path}.{field.name}", values)
            continue
        shown = {name: f"`{short(value)}`" for name, value in values.items()}
        if len(set(shown.values())) == 1:
            value = shown["demo"]
        else:
            value = ", ".join(f"{name} {text}" for name, text in shown.items())
        yield f"| `{path}.{field.name}` | {value} | {said[field.name].replace('|', '/')} |"


def short(value: Any) -> str:
    """Return a default, rounded if its digits are many."""
    text = str(value)
    return f"{value:.4g}" if isinstance(value, float) and len(text) > 8 else text


# --- the command line -----------------------------------------------------------------------------


def cli_page() -> str:
    """The text of docs/reference/cli.md: the help of `mobilegs` and of each verb."""
    text = [COMMANDS_HEAD, f"```text\n{help_of()}\n```\n"]
    for verb in command_line.VERBS:
        text += [f"## {verb}\n", f"```text\n{help_of(verb)}\n```\n"]
    return "\n".join(text)


def help_of(*words: str) -> str:
    """Return what `mobilegs WORDS --help` prints in a terminal of a fixed width."""
    printed = io.StringIO()
    terminal = {"COLUMNS": str(COLUMNS), "NO_COLOR": "1"}
    with (
        mock.patch.dict(os.environ, terminal),
        contextlib.redirect_stdout(printed),
        contextlib.suppress(SystemExit),
    ):
        command_line.main([*words, "--help"])
    lines = printed.getvalue().replace(mobilegs.__version__, "VERSION").splitlines()
    return "\n".join(line.rstrip() for line in lines).strip()


def main() -> int:
    """Write the pages."""
    pages = ((API, api_page()), (SETTINGS, settings_page()), (COMMANDS, cli_page()))
    for file, page in pages:
        (ROOT / file).write_text(page)
        print(f"{file}: {len(page.splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
