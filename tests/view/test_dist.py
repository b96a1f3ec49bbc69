"""The committed build of the web viewer is what its sources give."""

import base64
import json
import re
import subprocess
import zlib
from pathlib import Path

import pytest

from mobilegs import __version__
from mobilegs.view.assets import DIST
from tests.support.node import node_program

VIEWER = Path(__file__).parents[2] / "viewer"
SHADERS = sorted((VIEWER / "shaders").glob("*.wgsl"))


def unpacked(text: str) -> str:
    """Return a file's text with packed texts as they were, and without the versions of its parts.

    Builds of zlib compress differently.
    """
    text = re.sub(r"\?[0-9a-f]{16}", "", text)
    return re.sub(
        '"(eN[A-Za-z0-9+/=]{200,})"',
        lambda packed: zlib.decompress(base64.b64decode(packed[1])).decode(),
        text,
    )


def test_the_committed_build_is_current(tmp_path: Path) -> None:
    if not (VIEWER / "node_modules" / "esbuild").is_dir():
        pytest.skip("needs the viewer's tools (npm ci in viewer/)")
    command = [node_program(), VIEWER / "build.mjs", "view", tmp_path]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    built, committed = (
        {path.name: unpacked(path.read_text(encoding="utf-8")) for path in folder.iterdir()}
        for folder in (tmp_path, DIST)
    )
    assert built.keys() == committed.keys()
    stale = [name for name, content in built.items() if content != committed[name]]
    assert not stale, "run make viewer"


def test_the_build_names_no_folder_of_the_machine() -> None:
    for path in DIST.iterdir():
        text = path.read_text(encoding="utf-8")
        assert str(VIEWER.parent) not in text and "sourceMappingURL" not in text


def test_the_viewer_has_the_version_of_the_package() -> None:
    assert json.loads((VIEWER / "package.json").read_text())["version"] == __version__


@pytest.mark.parametrize("source", SHADERS, ids=lambda path: path.name)
def test_shaders_lose_only_comments_indentation_and_blank_lines(source: Path) -> None:
    lines = [re.sub("//.*", "", line).strip() for line in source.read_text().splitlines()]
    expected = "\n".join(line for line in lines if line)
    assert (DIST / source.name).read_text() == f"{expected}\n"
