"""Typical mistakes on the command line: one sentence each, exit code 2, and nothing written."""

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import torch
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.formats.ply import write_ply
from tests.support.random_scenes import random_scene

NO_GPU = pytest.mark.skipif(
    torch.cuda.is_available(), reason="needs a machine without an NVIDIA GPU"
)
# what is typed, with names of `Place` in braces: what the sentence contains
MISTAKES = {
    "trian {capture} -o {new}": "there is no verb 'trian': use one of demo, train",
    # train
    "train {gone} -o {new}": "there is no capture at {gone}",
    "train {ply} -o {new}": "is a file; give the folder that holds the photos",
    "train {empty} -o {new}": "{empty}",
    "train {capture} -o {text}": "is a file: give a folder for the run",
    "train {capture} -o {run}": "already holds a run: add --resume",
    "train {capture} -o {new} --minutes 0.1": "--minutes takes 1 to 10,000, not 0.1",
    "train {capture} -o {new} --minutes 5 --steps 100": "decides the length of the run",
    "train {capture} -o {new} --steps 1": "1 steps are too few",
    "train {capture} -o {new} --steps 9 --seed -1": "the seed must be between 0 and",
    "train {capture} -o {new} --steps 9 --device tpu": "there is no device 'tpu': use auto, cpu",
    "train {capture} -o {new} --steps 9 --set opacities": "'opacities' sets nothing",
    "train {capture} -o {new} --steps 9 --set student.lr.opacity=1": "did you mean opacities",
    "train {capture} -o {new} --set student.lr.opacities=fast": "does not have the type",
    "train {capture} -o {new} --set teacher.steps=0": "steps must be at least 1",
    "train {capture} -o {new} --steps 9 --downscale 0": "downscale must be 1 or more, got 0",
    "train {capture} -o {new} --steps 9 --teacher {gone}.ply": "{gone}.ply does not exist",
    "train {capture} -o {new} --steps 9 --teacher {mgs}": "is a .mgs: a plain 3DGS scene is needed",
    "train {capture} -o {new} --steps 9 --teacher {ply} --method mcmc": "leave out --method",
    "train {capture} -o {new} --steps 9 --teacher {ply} --max-splats 9": "leave out --max-splats",
    "train {capture} -o {new} --recipe {gone}.json": "{gone}.json is damaged",
    "train {capture} -o {new} --recipe {text}": "give the config.json of a run",
    "train {capture} -o {new} --recipe {run}/config.json --preset short": "leave out --preset",
    "train {capture} -o {new} --steps 9 --lpips-weights {empty}": "no LPIPS weights",
    "train {capture} -o {run} --resume --seed 7": "was started with seed 0, not 7",
    "train {capture} -o {new} --steps 9 --live-at nowhere": "sets the address of --live: give both",
    "train {capture} -o {new} --steps 9 --background 2 0 0": "must lie in [0, 1]",
    "train {capture} -o {new} --steps 9 --views-per-step 0": "views_per_step must be at least 1",
    "train {two} -o {new} --steps 9": "holds 2 photos: a scene needs at least 3",
    # compress
    "compress {mgs} -o {new}": "is a .mgs: a plain 3DGS scene is needed",
    "compress {points} -o {new}": "it is a point cloud or a mesh, not a 3DGS scene",
    "compress {ply} -o {new} --capture {capture} --views 9": "leave out --views",
    "compress {ply} -o {new} --downscale 2": "use --size",
    "compress {ply} -o {new} --cameras {text}": "{text}",
    # capture
    "capture {gone} -o {new}": "{gone} does not exist: give a folder of photos, or a video",
    "capture {text} -o {new}": "is not a video",
    "capture {empty} -o {new}": "has no photos in it",
    "capture {photos} -o {photos}": "holds the photos: give another folder for the capture",
    "capture {two} -o {new} --min-placed 2": "--min-placed must lie between 0 and 1",
    # render, eval
    "render {mgs}": "there is nothing to render",
    "render {ply} -o {new}": "give --capture CAPTURE",
    "render {mgs} --orbit {new}.mp4 --capture {capture}": "--orbit needs no photos",
    "render {mgs} -o {photos} --capture {capture}": "give another folder for images",
    "eval {ply}": "give --capture CAPTURE",
    "eval {mgs} --capture {empty}": "is not a capture",
    "eval {text} --capture {capture}": "is not a scene",
    # view
    "view {gone}.mgs": "{gone}.mgs does not exist",
    "view {capture}": "cannot read {capture}: it is a folder",
    "view {mgs} --native --lan": "leave out --lan",
    # export
    "export {mgs} --to ply -o {new}.spz": "does not end in .ply",
    "export {ply} --to ply -o {ply}": "is the scene itself and would be overwritten",
    "export {mgs} --to html -o {new}.html --refit": "leave out --refit",
    "export {mgs} --to html -o {new}.html --url https://me.example": "leave out --url",
    "export {mgs} --to ply -o {new}.ply --title Garden": "leave out --title",
    "export {mgs} --to html -o {text}": "is not an exported page",
    "export {mgs} --to site -o {photos}": "{photos}",
    # info
    "info {cut}": "cut",
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory, capture: Path, finished: Path) -> Any:
    """Files and folders that commands name, and which stay as they are."""
    tmp_path = tmp_path_factory.mktemp("place")
    for name in ("empty", "two"):
        (tmp_path / name).mkdir()
    for name in ("a", "b"):
        Image.new("RGB", (40, 30)).save(tmp_path / "two" / f"{name}.png")
    shutil.copytree(finished, tmp_path / "run")
    shutil.copytree(capture, tmp_path / "capture")
    write_ply(tmp_path / "scene.ply", random_scene(20, 0))
    (tmp_path / "notes.txt").write_text("some notes\n")
    whole = (finished / "scene.mgs").read_bytes()
    (tmp_path / "cut.mgs").write_bytes(whole[: len(whole) // 2])
    header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
    (tmp_path / "points.ply").write_text(f"{header}property float z\nend_header\n0 0 0\n")
    return SimpleNamespace(
        root=tmp_path,
        gone=tmp_path / "gone",
        new=tmp_path / "new",
        empty=tmp_path / "empty",
        two=tmp_path / "two",
        run=tmp_path / "run",
        mgs=tmp_path / "run" / "scene.mgs",
        capture=tmp_path / "capture",
        photos=tmp_path / "capture" / "images",
        ply=tmp_path / "scene.ply",
        points=tmp_path / "points.ply",
        text=tmp_path / "notes.txt",
        cut=tmp_path / "cut.mgs",
    )


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("typed", MISTAKES)
def test_a_mistake_gets_one_sentence(
    typed: str, place: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    before = tree(place.root)
    assert main([word.format(**vars(place)) for word in typed.split()]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("mobilegs: ") and printed.err.count("\n") == 1
    assert MISTAKES[typed].replace("{", "{0.").format(place) in printed.err
    assert tree(place.root) == before, "something was written or lost"
    assert not place.new.exists()


@NO_GPU
@pytest.mark.parametrize("more", ["--device cuda:3", "--preset long"])
def test_a_missing_gpu_is_said_before_anything_else(
    more: str, place: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["train", str(place.capture), "-o", str(place.new), *more.split()]
    assert main(words) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not place.new.exists()
