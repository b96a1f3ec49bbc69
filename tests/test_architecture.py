"""The levels of docs/explanation/architecture.md: a module imports from its own or from above."""

import ast
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "mobilegs"
# in the order of docs/explanation/architecture.md
LEVELS: list[set[str]] = [
    {"errors", "atomic", "validation", "progress_display", "child_process", "extras"},
    {"reproducible", "device"},
    {"camera", "gaussians", "spherical_harmonics", "up", "kmeans"},
    {"csrc"},
    {"render"},
    {"viewpoints"},
    {"data"},
    {"capture"},
    {"packed_gaussians"},
    {"formats"},
    {"representation"},
    {"mgs"},
    {"evaluate"},
    {"scene_file"},
    {"synthetic_capture"},
    {"edit"},
    {"train"},
    {"nerfbaselines"},
    {"view"},
    {"live"},
    {"pipeline"},
    {"batch"},
    {"cli"},
    {"__main__"},
]
# each reads another tool's format; nothing of ours is between them
SIBLINGS_APART = {"formats"}
LINES_MAX = 600
MODULES = sorted(PACKAGE.rglob("*.py"))


def part(name: str) -> str:
    """The level's name for a dotted module: `mobilegs.data.colmap` -> `data`."""
    return [*name.split("."), ""][1]


def dotted(path: Path) -> str:
    relative = path.relative_to(PACKAGE.parent).with_suffix("")
    return ".".join(relative.parts).removesuffix(".__init__")


def imported(path: Path) -> Iterator[str]:
    """Dotted names of our own modules that a file imports, those inside functions included."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the direction"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        yield from (name for name in names if name.split(".")[0] == "mobilegs")


def level(name: str) -> int:
    return next(index for index, names in enumerate(LEVELS) if name in names)


def test_modules_import_only_from_above() -> None:
    wrong = []
    for path in MODULES:
        module = dotted(path)
        own = part(module)
        if not own:  # the package itself holds the version and imports nothing
            wrong += [f"{module} imports {name}" for name in imported(path)]
            continue
        for name in imported(path):
            if part(name) == "__version__":
                continue
            sibling = own in SIBLINGS_APART and part(name) == own and not name.startswith(module)
            if sibling or level(part(name)) > level(own):
                wrong.append(f"{module} imports {name}")
    assert not wrong


def test_no_module_grows_beyond_the_alarm() -> None:
    lines = {dotted(path): len(path.read_text().splitlines()) for path in MODULES}
    assert not {module: count for module, count in lines.items() if count > LINES_MAX}


def test_no_module_is_a_drawer() -> None:
    names = {path.stem for path in MODULES} | {path.parent.name for path in MODULES}
    assert not names & {"utils", "util", "helpers", "misc", "common"}


def test_the_docs_list_the_levels_in_their_order() -> None:
    text = (PACKAGE.parent / "docs/explanation/architecture.md").read_text()
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    places = [
        next((i for i, row in enumerate(rows) if f"{name}/" in row or f"{name}.py" in row), -1)
        for names in LEVELS
        for name in sorted(names)
    ]
    assert -1 not in places
    assert places == sorted(places)
