"""The examples do what they say: each runs as its first lines show, on something tiny."""

import http.server
import json
import re
import runpy
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import encode_mgs, read_mgs
from mobilegs.representation.lobes import LobeShape
from tests.support.browser import Chromium
from tests.support.scene_cases import Case, make_scene
from tests.support.tiny import blobs
from tests.support.viewer_page import SETTLED

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "examples"
CONFORMANCE = ROOT / "tests" / "mgs" / "conformance"


class Printed:
    """Runs an example in this process and keeps what it printed."""

    def __init__(self, capsys: pytest.CaptureFixture[str], patch: pytest.MonkeyPatch) -> None:
        self._capsys, self._patch = capsys, patch

    def __call__(self, example: str, *words: object) -> str:
        self._patch.setattr(sys, "argv", [example, *map(str, words)])
        self._capsys.readouterr()
        runpy.run_path(str(EXAMPLES / example), run_name="__main__")
        return self._capsys.readouterr().out


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Printed:
    return Printed(capsys, monkeypatch)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain 3DGS scene of fifty blobs."""
    path = tmp_path_factory.mktemp("plain") / "blobs.ply"
    write_ply(path, blobs())
    return path


@pytest.fixture(scope="module")
def garden(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "scene.mgs"
    path.write_bytes(encode_mgs(make_scene(Case(300, LobeShape(2, 6, (8,)), size=60))))
    return path


def number(pattern: str, text: str) -> float:
    match = re.search(pattern, text)
    assert match, f"{pattern} is not in {text!r}"
    return float(match[1].replace(",", ""))


def test_a_scene_is_drawn_from_a_place_of_ones_own(
    run: Printed, plain: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "a.png"
    words = ("--eye", 0, 0, -4, "--at", 0, 0, 0, "--size", 60, 40)
    text = run("draw.py", plain, picture, *words)
    assert "60x40, 50 Gaussians" in text
    assert 2 < number(r"depth ([\d.]+) to [\d.]+ world units", text) < 4
    with Image.open(picture) as image:
        assert image.size == (60, 40)
        assert np.asarray(image)[20, 30].max() > 40  # a blob is in the middle
        assert np.asarray(image)[0, 0].max() == 0  # and nothing in a corner
    assert "50 Gaussians in view" in run("draw.py", plain, picture)


def test_a_file_with_cameras_is_drawn_from_the_first(
    run: Printed, garden: Path, tmp_path: Path
) -> None:
    camera = read_mgs(garden).views[0]
    text = run("draw.py", garden, tmp_path / "b.png")
    assert f"{camera.width}x{camera.height}, 300 Gaussians" in text


@pytest.mark.thorough
def test_two_recipes_are_trained_by_one_teacher_and_measured(
    run: Printed, capture: Path, tmp_path: Path
) -> None:
    runs = tmp_path / "runs"
    text = run("train.py", capture, runs, "--steps", 80)
    first, second = (
        (number(rf"{name} +([\d.]+) dB", text), number(rf"{name} .*dB +([\d,]+) bytes", text))
        for name in ("default", "codebooks")
    )
    teachers = [(runs / name / "teacher.ply").read_bytes() for name in ("default", "codebooks")]
    assert teachers[0] == teachers[1]
    assert first[1] == (runs / "default" / "scene.mgs").stat().st_size
    assert first[1] != second[1] == (runs / "codebooks" / "scene.mgs").stat().st_size
    assert min(first[0], second[0]) > 5

    scenes = (runs / "default" / "scene.mgs", runs / "default" / "teacher.ply")
    text = run("measure.py", capture, *scenes)
    assert "2 held-back photos of blobs" in text
    figures = json.loads((runs / "default" / "metrics.json").read_text())
    for scene, name in zip(scenes, ("student", "teacher"), strict=True):
        assert number(rf"{scene}: ([\d.]+) dB", text) == pytest.approx(
            figures[name]["psnr"], abs=0.02
        )
    assert text.count("  worst view: view_") == 2


@pytest.mark.thorough
def test_a_scene_of_another_tool_becomes_small(run: Printed, plain: Path, tmp_path: Path) -> None:
    words = ("--views", 16, "--size", 64, "--steps", 30)
    text = run("compress.py", plain, tmp_path / "small", *words)
    before, after = plain.stat().st_size, (tmp_path / "small" / "scene.mgs").stat().st_size
    assert f"{before:,} bytes became {after:,}" in text
    assert number(r"([\d.]+) dB to the original scene", text) > 5
    assert "<mobile-gs" in (tmp_path / "small" / "scene.html").read_text()


def test_the_middle_of_a_scene_is_written_for_every_tool(
    run: Printed, plain: Path, tmp_path: Path
) -> None:
    text = run("convert.py", plain, tmp_path / "cut", "--keep", 0.5)
    assert "25 of 50 Gaussians, degree 1" in text
    for kind in ("ply", "spz", "sog", "glb"):
        size = (tmp_path / "cut" / f"blobs.{kind}").stat().st_size
        assert re.search(rf"blobs\.{kind} +{size:,} bytes  25 Gaussians", text)
    whole, kept = read_ply(plain).means, read_ply(tmp_path / "cut" / "blobs.ply").means
    distance = (whole - whole.median(0).values).norm(dim=1)
    assert torch.equal(kept, whole[distance.argsort()[:25].sort().values])


def test_a_student_is_not_converted(run: Printed, garden: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"give its teacher\.ply"):
        run("convert.py", garden, tmp_path / "cut")


def test_a_loop_of_ones_own_trains_and_writes_a_scene(
    run: Printed, capture: Path, tmp_path: Path
) -> None:
    output = tmp_path / "scene.mgs"
    text = run("loop.py", capture, output, "--steps", 20)
    assert text.count("teacher, step ") == 5
    assert number(r"student: ([\d.]+) dB on held-back photos", text) > 8
    assert number(r"scene\.mgs: ([\d,]+) bytes", text) == output.stat().st_size
    assert len(read_mgs(output).views) == 4


def test_gaussians_are_fitted_to_a_photo(run: Printed, capture: Path, tmp_path: Path) -> None:
    photo = next((capture / "images").iterdir())
    text = run("fit.py", photo, tmp_path / "fitted.png", "--count", 60, "--steps", 40)
    figures = [float(found) for found in re.findall(r": ([\d.]+) dB", text)]
    assert figures[-1] > figures[0] + 3
    with Image.open(tmp_path / "fitted.png") as image:
        assert image.size == (24, 20)


# --- a decoder of its own -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def decoder() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLES / "read_mgs.py"))


def test_the_decoder_needs_neither_torch_nor_the_package(tmp_path: Path) -> None:
    file = CONFORMANCE / "sq_layers.mgs"
    code = (
        "import runpy, sys; sys.modules['torch'] = sys.modules['mobilegs'] = None;"
        f"sys.argv = ['x', {str(file)!r}, '--npz', {str(tmp_path / 'a.npz')!r}];"
        f"runpy.run_path({str(EXAMPLES / 'read_mgs.py')!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"500 Gaussians in {file.stat().st_size:,} bytes, blended sortfree" in done.stdout
    assert re.search(r"positions@1 +morton-class +[\d,]+ bytes", done.stdout)
    with np.load(tmp_path / "a.npz") as arrays:
        assert arrays["means"].shape == (500, 3)


def test_the_decoder_refuses_a_file_with_another_bit(decoder: dict[str, Any]) -> None:
    data = bytearray((CONFORMANCE / "nvq_ends.mgs").read_bytes())
    data[-9] ^= 1
    with pytest.raises(ValueError, match=r"not a valid \.mgs"):
        decoder["decode"](bytes(data))


# --- a page, a notebook ---------------------------------------------------------------------------


def test_the_page_shows_the_scene_and_hears_of_it(
    chromium: Chromium, garden: Path, tmp_path: Path
) -> None:
    site = tmp_path / "site"
    assert main(["export", str(garden), "--to", "site", "-o", str(site)]) == 0
    page = (EXAMPLES / "page.html").read_text()
    one_way = page.replace("<mobile-gs ", '<mobile-gs scale="1" variant="floats" ')
    (site / "page.html").write_text(one_way)

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    tab = chromium.tab()
    tab.page.goto(f"http://127.0.0.1:{server.server_port}/page.html")
    assert tab.page.wait_for_function(SETTLED, timeout=60_000).json_value() == "loaded"
    assert re.fullmatch(r"loaded in \d+ ms", tab.page.inner_text("#state"))
    title = "document.querySelector('mobile-gs').title.startsWith('300 Gaussians by ')"
    tab.page.wait_for_function(title, timeout=30_000)
    tab.page.click("#still")
    assert tab.page.evaluate("!document.querySelector('mobile-gs').viewer.turning")
    tab.page.evaluate("document.querySelector('mobile-gs').setAttribute('src', 'none.mgs')")
    tab.page.wait_for_function("document.querySelector('#state').textContent.includes('none.mgs')")
    tab.page.close()
    server.shutdown()
    server.server_close()


@pytest.mark.thorough
def test_the_notebook_runs_from_its_first_cell_to_the_last(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    notebook = json.loads((EXAMPLES / "tour.ipynb").read_text())
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    ids = {cell["id"] for cell in notebook["cells"]}
    assert len(ids) == len(notebook["cells"])
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells)
    shared: dict[str, Any] = {}
    for cell in cells:
        exec("".join(cell["source"]), shared)
        if "parameters" in cell["metadata"].get("tags", ()):
            tiny = {"VIEWS": 9, "WIDTH": 30, "HEIGHT": 20, "POINTS": 200, "STEPS": 60}
            shared |= tiny | {"FOLDER": str(tmp_path)}
    text = capsys.readouterr().out
    assert "7 training photos, 2 held-back photos" in text
    assert shared["picture"](shared["rendered"].image).size == (30, 20)
    assert f"student: {shared['metrics']['student']['psnr']:.2f} dB" in text
    assert number(r"uniform: [\d.]+ dB in ([\d,]+) bytes", text) < number(
        r"codebooks: [\d.]+ dB in ([\d,]+) bytes", text
    )
    assert "<mobile-gs" in (tmp_path / "tour.html").read_text()


def test_every_example_is_listed_and_tested() -> None:
    files = {path.name for path in EXAMPLES.iterdir() if path.suffix in (".py", ".html", ".ipynb")}
    listed = (EXAMPLES / "README.md").read_text()
    tested = Path(__file__).read_text()
    assert [name for name in sorted(files) if f"`{name}`" not in listed] == []
    assert [name for name in sorted(files) if name not in tested] == []
