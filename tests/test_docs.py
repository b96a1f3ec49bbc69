"""Generated pages, the package's public names, and the links and commands in all pages."""

import ast
import inspect
import json
import re
import runpy
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from unittest.mock import patch

import pytest

import mobilegs
from bench.paper import report
from mobilegs.cli.main import main

ROOT = Path(__file__).parent.parent
# pages that `make docs` makes and the tree does not have
BUILT = {ROOT / "docs/reference/api.md", ROOT / "docs/explanation/paper_tables.md"}
# pages of the tree, as a forge shows them
TREE = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "examples/README.md"]
PAGES = [*TREE, *sorted(set((ROOT / "docs").rglob("*.md")) - BUILT)]
MAKER = runpy.run_path(str(ROOT / "docs" / "make_api.py"))
# `docs/page.md` from the root, or [words](page.md#part) from where the page is
LINK = re.compile(
    r"[`\"]((?:docs|examples|bench|tests|mobilegs|viewer)/[\w./-]+)[`\"](?!\s+at\s+commit)"
    r"|\]\(([^)#:\s]+)(?:#[^)]*)?\)"
)
SOURCES = {
    ".py",
    ".pyi",
    ".js",
    ".mjs",
    ".ts",
    ".html",
    ".h",
    ".cpp",
    ".cu",
    ".c",
    ".wgsl",
    ".glsl",
}
# names of other programs and of exported files
FOREIGN = {"SPZ_ADOBE_coordinate_system", "sw.js", "report.html", "alphaTest", "alphaHash"}
FOREIGN |= {"toneMapped", "chunkSize", "mesh.recolor"}
FOREIGN |= {"DefaultStrategy", "radius_clip", "rasterization_2dgs", "sparse_grad"}  # gsplat's
# entries of the npm package, which look like paths
EXPORTS = json.loads((ROOT / "npm" / "package.json").read_text())["exports"]
ENTRIES = {name.replace(".", "mobilegs", 1) for name in EXPORTS}


@pytest.mark.parametrize("page", ["settings", "cli"])
def test_a_committed_generated_page_is_current(page: str) -> None:
    written = (ROOT / "docs/reference" / f"{page}.md").read_text()
    assert MAKER[f"{page}_page"]() == written, "run: python docs/make_api.py"


def test_the_page_of_all_rows_is_made(tmp_path: Path) -> None:
    page = tmp_path / "paper_tables.md"
    with patch.object(sys, "argv", ["report", "--tables", str(page)]):
        report.main()
    text = page.read_text()
    assert text.startswith("# All rows") and text.count("| `teacher` |") > 3


def printed_signatures() -> Iterator[tuple[Callable, str]]:
    """Every public function, class and method with its signature as the API page has it."""
    for entry in MAKER["api_page"]().split("\n### ")[1:]:
        found = getattr(mobilegs, entry.split("\n", 1)[0])
        block = re.findall(r"```python\n(.*?)\n```", entry, re.DOTALL)[0]
        if not re.fullmatch(r"class \w+\([\w., ]*\)", block):  # a class with its bases only
            yield found, block.removeprefix("class ")
        for line in re.findall(r"^- `\.(\w+\(.*?)`: ", entry, re.MULTILINE):
            yield getattr(found, line.split("(")[0]), line


def test_printed_signatures_are_the_real_ones() -> None:
    """Names and kinds of all parameters, by `inspect.signature`."""
    compared = 0
    for found, text in printed_signatures():
        (function,) = ast.parse(f"def {text}: ...").body
        assert isinstance(function, ast.FunctionDef)
        given = function.args
        printed = [(a.arg, "positional or keyword") for a in given.args]
        printed += [(a.arg, "keyword-only") for a in given.kwonlyargs]
        real = [p for p in inspect.signature(found).parameters.values() if p.name != "self"]
        assert printed == [(p.name, p.kind.description) for p in real], text
        compared += 1
    assert compared > 30


def test_a_name_with_two_values_is_printed_with_that_of_its_module() -> None:
    assert MAKER["spelled_out"]("camera", "NEAR") == "0.2"
    assert MAKER["spelled_out"]("render.scene", "NEAR") == "0.2"
    assert MAKER["spelled_out"]("viewpoints.placement", "NEAR") == "0.02"


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, mobilegs; assert 'Camera' in dir(mobilegs);"
        "assert not {'torch', 'numpy', 'tyro', 'PIL'} & sys.modules.keys();"
        "from mobilegs import Camera, cli; assert Camera.__module__ == 'mobilegs.camera'"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_every_public_name_can_be_imported() -> None:
    for name, module in mobilegs._HOMES.items():
        found = getattr(mobilegs, name)
        assert found.__module__ == f"mobilegs.{module}", name
        assert found.__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'Splats'"):
        _ = mobilegs.Splats  # pyright: ignore


def test_the_stub_lists_the_same_names() -> None:
    stub = ast.parse((ROOT / "mobilegs" / "__init__.pyi").read_text())
    told = {
        (node.module, alias.name, alias.asname)
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    homes = mobilegs._HOMES.items()
    assert told == {(f"mobilegs.{module}", name, name) for name, module in homes}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_to_files(page: Path) -> None:
    missing = []
    for match in LINK.finditer(page.read_text()):
        inside, linked = match.groups()
        if inside in ENTRIES or "NAME" in (inside or ""):
            continue
        target = ROOT / inside if inside else page.parent / linked
        if target.resolve() in BUILT and page not in TREE:  # the site has it
            continue
        if not target.exists() and not list(ROOT.glob(inside or "-")):
            missing.append(inside or linked)
    assert not missing


@cache
def sources() -> dict[str, str]:
    """The text of every source file by its path from the root."""
    folders = ("mobilegs", "viewer/src", "viewer/shaders", "bench", "tests", "examples")
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*")]
    return {
        path.relative_to(ROOT).as_posix(): path.read_text("utf-8")
        for path in paths
        if path.suffix in SOURCES and "node_modules" not in path.parts
    }


@cache
def words() -> set[str]:
    return {word for text in sources().values() for word in re.findall(r"\w+", text)}


def names_in(page: Path) -> Iterator[str]:
    """The names of functions, classes, settings and files that a page's own text has in code."""
    text = re.sub(r"<!-- BEGIN.*?<!-- END", "", page.read_text(), flags=re.DOTALL)
    for code, past in re.findall(r"`([^`\n]+)`(\s+at\s+commit)?", text):
        if past:  # a file of the history
            continue
        yield from re.findall(r"(?:student|teacher)\.[\w.]+(?==)", code)
        if re.fullmatch(r"[A-Za-z][\w./]*", code) and re.search(r"_|[a-z][A-Z]|\.", code):
            yield code


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_names_in_pages_exist(page: Path) -> None:
    settings = (ROOT / "docs/reference/settings.md").read_text()
    wrong = set()
    for name in set(names_in(page)) - FOREIGN:
        if "NAME" in name or (ROOT / name).exists():
            continue
        if re.match(r"(student|teacher)\.(?!ply)", name):
            known = f"`{name}" in settings
        elif Path(name).suffix in SOURCES:
            known = any(f"/{path}".endswith(f"/{name}") for path in sources())
        else:
            known = "/" in name or set(re.findall(r"\w+", name)) <= words()
        if not known:
            wrong.add(name)
    assert not wrong


def test_commands_in_pages_use_existing_options(
    capsys: pytest.CaptureFixture[str],
) -> None:
    wrong, helps = [], {}
    for page in PAGES:
        for line in page.read_text().splitlines():
            match = re.match(r"    mobilegs (\S+)(.*)", line.split("#")[0])
            if not match or match[1].isupper():
                continue
            verb, rest = match.groups()
            if verb not in helps:
                with pytest.raises(SystemExit):
                    main([verb, "--help"])
                helps[verb] = capsys.readouterr().out
            for option in re.findall(r"(?<= )--?[a-z][a-z-]*", rest):
                if not re.search(rf"{option}\b", helps[verb]):
                    wrong.append(f"{page.name}: {line.strip()}: {option}")
    assert len(helps) > 6
    assert not wrong
