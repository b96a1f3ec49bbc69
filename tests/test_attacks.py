"""Folders and files from strangers: links, pipes, devices, hostile JSON and checkpoints.

Each line of a table is one attack. Each ends with a sentence and exit code 2, or does no harm; none
waits, changes a file elsewhere, or prints a traceback.
"""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.formats.ply import write_ply
from mobilegs.train.state_file import read_state, write_state
from tests.cli.test_hostile import at_once
from tests.support.random_scenes import random_scene

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs POSIX")
Capsys = pytest.CaptureFixture[str]
SECRET = "what must stay as it is"


@pytest.fixture(autouse=True)
def none_waits() -> Iterator[None]:
    with at_once():
        yield


def ends(capsys: Capsys, *words: str | Path, codes: tuple[int, ...] = (2,)) -> str:
    """Run a command, check that it ends with one of `codes`, and return what it printed."""
    code = main([str(word) for word in words])
    printed = capsys.readouterr()
    assert code in codes, (code, printed)
    assert "Traceback" not in printed.err
    if code == 2:
        assert printed.err.rpartition("mobilegs: ")[2].count("\n") == 1, printed.err
    return printed.out + printed.err


@pytest.fixture
def run(stopped: dict[str, Path], tmp_path: Path) -> Path:
    """A run that was interrupted, to spoil."""
    return shutil.copytree(stopped["student"], tmp_path / "run")


# --- links


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    """A folder with a file that nobody named."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "secret").write_text(SECRET)
    (folder / "previews_000010.png").write_text(SECRET)
    return folder


def assert_untouched(secret: Path) -> None:
    assert {path.name: path.read_text() for path in secret.iterdir()} == dict.fromkeys(
        ("secret", "previews_000010.png"), SECRET
    )


def linked(link: Path, to: Path) -> None:
    """Put a link in the place of a file or folder."""
    link.parent.mkdir(parents=True, exist_ok=True)
    if link.is_dir():
        shutil.rmtree(link)
    link.unlink(missing_ok=True)
    link.symlink_to(to)


WRITTEN = ("scene.mgs", "metrics.json", "contact_sheet.png", "report.html")
ONE_BY_ONE = (
    "config.json",
    "checkpoint.safetensors",
    "teacher.ply",
    "poses.json",
    ".lock",
    *WRITTEN,
)


@pytest.mark.parametrize(
    ("names", "target", "codes"),
    [
        ((*WRITTEN, "metrics.jsonl"), "new", (0,)),
        (("metrics.jsonl", "contact_sheet.png", "report.html"), "secret", (0,)),
        *(((name,), "secret", (0, 2)) for name in ONE_BY_ONE),
        (("previews",), ".", (2,)),
    ],
    ids=str,
)
def test_a_resumed_run_writes_through_no_link(
    names: tuple[str, ...], target: str, codes: tuple[int, ...], run: Path, capture: Path,
    secret: Path, capsys: Capsys
) -> None:  # fmt: skip
    for name in names:
        linked(run / name, secret / target)
    top = run.with_name("link to it")  # the folder that is named may be a link
    linked(top, run)
    ends(capsys, "train", capture, "-o", top, "--resume", codes=codes)
    assert_untouched(secret)


@pytest.mark.parametrize("name", ["images", "sparse", "work", "work/photos", "work/database.db"])
def test_a_capture_goes_through_no_link(
    name: str, capture: Path, secret: Path, tmp_path: Path, capsys: Capsys
) -> None:
    pytest.importorskip("pycolmap", reason="needs the extra capture")
    output = tmp_path / "made"
    linked(output / name, secret / "secret" if "." in name else secret)
    record = json.dumps({"key": "", "done": False, "seconds": 0})
    (output / "capture.json").write_text(record)  # the folder seems to be a capture
    said = ends(capsys, "capture", capture / "images", "-o", output)
    assert f"{output / name} is a link" in said
    assert_untouched(secret)


@pytest.mark.parametrize("name", ["a", "a/batch", "a/batch/events.jsonl", "a/site", "cache"])
def test_a_batch_goes_through_no_link(
    name: str, capture: Path, secret: Path, tmp_path: Path, capsys: Capsys
) -> None:
    listed, output = tmp_path / "list.jsonl", tmp_path / "out"
    listed.write_text(json.dumps({"name": "a", "source": str(capture)}))
    linked(output / name, secret)
    assert f"{output / name} is a link" in ends(capsys, "batch", listed, "-o", output)
    assert_untouched(secret)


def test_exports_replace_links(
    finished: Path, secret: Path, tmp_path: Path, capsys: Capsys
) -> None:
    site, page = tmp_path / "site", tmp_path / "page.html"
    ends(capsys, "export", finished, "--to", "site", "-o", site, codes=(0,))
    files = sorted(site.iterdir())
    for file in files:
        if file.name != "manifest.webmanifest":  # by which the folder is known
            linked(file, secret / "secret")
    ends(capsys, "export", finished, "--to", "site", "-o", site, codes=(0,))
    assert len(files) > 5 and not any(file.is_symlink() for file in files)
    page.symlink_to(secret / "new")
    ends(capsys, "export", finished, "--to", "html", "-o", page, codes=(0,))
    assert not page.is_symlink()
    assert_untouched(secret)


# --- pipes, devices, and files without an end


def pipe(path: Path) -> None:
    os.mkfifo(path)


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


def huge(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 42)  # which takes no room


INPUTS = {  # a file of `where`: the command that reads it
    "scene.mgs": "info {file}",
    "scene.spz": "info {file}",
    "page.ply": "export {file} --to html -o {new}",
    "list.csv": "batch {file} -o {new}",
    "cameras.json": "compress {ply} -o {new} --cameras {file}",
    "notes.json": "export {finished} --to html -o {new} --annotations {file}",
    "path.json": "export {finished} --to html -o {new} --camera-path {file}",
    "recipe.json": "train {capture} -o {new} --recipe {file}",
    "film.mp4": "capture {file} -o {new}",
    "blobs/images/view_3.png": "train {where}/blobs -o {new} --steps 9",
    "blobs/sparse/0/images.txt": "train {where}/blobs -o {new} --steps 9",
    "run/config.json": "train {capture} -o {where}/run --resume",
    "run/checkpoint.safetensors": "train {capture} -o {where}/run --resume",
    "run/metrics.json": "train {capture} -o {where}/run --resume",
}


@pytest.mark.parametrize(
    ("name", "put"),  # a video may have any size
    [*product(INPUTS, (pipe, zeros)), *((name, huge) for name in INPUTS if name != "film.mp4")],
)
def test_no_input_waits_or_fills_memory(
    name: str,
    put: Callable[[Path], None],
    run: Path,
    capture: Path,
    finished: Path,
    tmp_path: Path,
    capsys: Capsys,
) -> None:
    if "film" in name:
        pytest.importorskip("av", reason="needs the extra capture")
    file, ply = tmp_path / name, tmp_path / "given.ply"
    shutil.copytree(capture, tmp_path / "blobs")
    write_ply(ply, random_scene(5, degree=0))
    file.unlink(missing_ok=True)
    put(file)
    places = {"file": file, "new": tmp_path / "new", "where": tmp_path, "ply": ply}
    places |= {"capture": capture, "finished": finished}
    said = ends(capsys, *(word.format(**places) for word in INPUTS[name].split()))
    assert not (tmp_path / "new").exists() and "not enough memory" not in said


# --- what seems well-formed

NAN, INFINITE = float("nan"), float("inf")
CONFIGS: dict[str, tuple[tuple[str, ...], Any]] = {
    "a list": ((), []),
    "deep": ((), "[" * 100_000),
    "no options": (("options",), None),
    "options in a list": (("options",), []),
    "a seed in words": (("options", "seed"), "1"),
    "a negative seed": (("options", "seed"), -1),
    "downscale 0": (("options", "downscale"), 0),
    "a huge downscale": (("options", "downscale"), 10**400),
    "a teacher of 5": (("options", "teacher"), 5),
    "two channels": (("options", "background"), [0, 1]),
    "words as channels": (("options", "background"), ["0", "0", "0"]),
    "steps as text": (("recipe", "teacher", "steps"), "12"),
    "half a step": (("recipe", "teacher", "steps"), 12.5),
    "no steps": (("recipe", "student", "steps"), None),
    "endless steps": (("recipe", "student", "steps"), 10**30),
    "a yes as a number": (("recipe", "teacher", "max_splats"), True),
    "a rate that is none": (("recipe", "teacher", "lr", "means"), NAN),
    "a rate of 1e400": (("recipe", "student", "lr", "opacities"), INFINITE),
    "a part as a list": (("recipe", "student", "loss"), []),
    "a field too many": (("recipe", "new"), 1),
    "photos of nothing": (("photos",), {}),
    "poses of text": (("photos", "poses"), ["a"] * 12),
    "endless poses": (("photos", "poses"), [10**400] * 12),
    "a plan of 5": (("plan",), 5),
}


def with_change(content: Any, place: tuple[str, ...], value: Any) -> Any:
    if not place:
        return value
    return {**content, place[0]: with_change(content.get(place[0]), place[1:], value)}


@pytest.mark.parametrize("name", CONFIGS)
def test_hostile_configs_are_refused(
    name: str, capture: Path, finished: Path, tmp_path: Path, capsys: Capsys
) -> None:
    shutil.copytree(finished, tmp_path / "run")
    config = tmp_path / "run" / "config.json"
    changed = with_change(json.loads(config.read_text("utf-8")), *CONFIGS[name])
    config.write_text(changed if isinstance(changed, str) else json.dumps(changed), "utf-8")
    said = ends(capsys, "train", capture, "-o", tmp_path / "run", "--resume")
    assert "config.json" in said or "options" in said


LEAVES: dict[str, Any] = {"value": torch.zeros(3), "exp_avg": torch.ones(2, 2), "lr": NAN}
LEAVES |= {"step": torch.zeros(3)}
PARTS: dict[tuple[str, ...], list[Any]] = {  # of a checkpoint: what is put there
    ("seconds",): [[], {"teacher": "x"}],
    ("log",): [5, [5]],
    ("new",): [1],
    ("state",): [None, {}],
    ("state", "done"): ["x", -1, 10**30, 1.5],
    ("state", "generator"): [7, torch.zeros(3)],
    ("state", "exposures"): [5, {"changes": 5}],
    ("state", "strategy"): [None],
    ("state", "adam"): [[], {"means": {}}],
    **{("state", "adam", "means", leaf): [wrong, None] for leaf, wrong in LEAVES.items()},
    **{("state", "model", "rows", "quats", leaf): [wrong] for leaf, wrong in LEAVES.items()},
    ("state", "model", "phase"): [{}, "later"],
    ("state", "model", "grid"): [{"radius": 0}, 5],
    ("state", "model", "shared"): [None, {"new": {"value": torch.zeros(3)}}],
    ("state", "votes"): [{}, {"against": torch.zeros(3), "held": 0}],
}
LACKS = {"teacher": {"model", "votes"}, "student": {"adam", "strategy"}}


@pytest.mark.parametrize(
    ("stage", "place"),
    [(stage, place) for stage, lacks in LACKS.items() for place in PARTS if not lacks & {*place}],
    ids=str,
)
def test_hostile_checkpoints_are_refused(
    place: tuple[str, ...], stage: str, stopped: dict[str, Path], capture: Path, tmp_path: Path,
    capsys: Capsys
) -> None:  # fmt: skip
    state = read_state(stopped[stage] / "checkpoint.safetensors")
    for number, wrong in enumerate(PARTS[place]):
        copy = shutil.copytree(stopped[stage], tmp_path / str(number))
        write_state(copy / "checkpoint.safetensors", with_change(state, place, wrong))
        assert "checkpoint" in ends(capsys, "train", capture, "-o", copy, "--resume")
