"""Pages that are made of the sources, what the package gives by name, links that lead somewhere."""

import ast
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import mobilegs
from mobilegs.cli.main import main

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "examples/README.md"]
MAKER = runpy.run_path(str(ROOT / "docs" / "make_api.py"))
# `docs/page.md` from the root, or [words](page.md#part) from where the page is
LINK = re.compile(
    r"`((?:docs|examples|bench|tests|mobilegs)/[\w./-]+)`|\]\(([^)#:\s]+)(?:#[^)]*)?\)"
)


@pytest.mark.parametrize("page", ["api", "settings"])
def test_the_page_is_what_the_sources_say(page: str) -> None:
    written = (ROOT / "docs" / f"{page}.md").read_text()
    assert MAKER[f"{page}_page"]() == written, "run: python docs/make_api.py"


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, mobilegs; assert 'Camera' in dir(mobilegs);"
        "assert not {'torch', 'numpy', 'tyro', 'PIL'} & sys.modules.keys();"
        "from mobilegs import Camera, cli; assert Camera.__module__ == 'mobilegs.camera'"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_every_public_name_is_there_and_no_other() -> None:
    for name, module in mobilegs._HOMES.items():
        found = getattr(mobilegs, name)
        assert found.__module__ == f"mobilegs.{module}", name
        assert found.__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'Splats'"):
        _ = mobilegs.Splats  # pyright: ignore


def test_type_checkers_are_told_the_same() -> None:
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
def test_what_a_page_points_to_is_there(page: Path) -> None:
    missing = []
    for match in LINK.finditer(page.read_text()):
        inside, linked = match.groups()
        target = ROOT / inside if inside else page.parent / linked
        if not target.exists() and not list(ROOT.glob(inside or "-")):
            missing.append(inside or linked)
    assert not missing


def test_commands_in_pages_have_the_options_that_there_are(
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


def test_pages_say_what_compress_was_measured_to_do() -> None:
    found = json.loads((ROOT / "bench/results/existing.json").read_text())
    page = (ROOT / "docs/existing.md").read_text()
    quick = (ROOT / "docs/quickstart.md").read_text()
    for name, row in found.items():
        minutes = f"{row['seconds_here'] / 60:.0f}"
        held, size = row["held_back"]["psnr"], f"{row['bytes'] / 1e6:.2f} MB"
        line = next(line for line in quick.splitlines() if line.startswith(f"| *{name}*"))
        assert line.endswith(f"| {size} | {held:.1f} dB | {minutes} |")
        column = [line.split(" | ")[1 + list(found)[::-1].index(name)] for line in table(page)]
        assert f"{row['gaussians']:,}, {size}" in column[1]
        told = [word.strip(" |") for word in column[2:]]
        others = [
            f"{row[which]['psnr']:.2f}, {row[which]['worst']:.2f} dB" for which in ("anew", "orbit")
        ]
        steps = f"{row['steps']:,}, {row['pictures']} of {'x'.join(map(str, row['image_size']))}"
        assert told == [f"{row['smaller']:.0f}", steps, minutes, f"{held:.2f} dB", *others]


def table(page: str) -> list[str]:
    """The rows of the last table of a page, without its head."""
    lines = [line for line in page.splitlines() if line.startswith("|")]
    begin = max(number for number, line in enumerate(lines) if line.startswith("|---"))
    return lines[begin + 1 :]
