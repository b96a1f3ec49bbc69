"""The folder of a run: who may use it, what is checked before, and what commands find in it."""

import errno
import json
import os
import shutil
from collections import namedtuple
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from mobilegs.atomic import atomic_path
from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.device import choose_device
from mobilegs.errors import InputError
from mobilegs.pipeline import preflight
from mobilegs.pipeline.options import TrainRun, resolve_recipe
from mobilegs.pipeline.preflight import validate_run
from mobilegs.pipeline.train import train_capture
from mobilegs.scene_file import read_plain_scene, scene_at
from mobilegs.train.run_dir import RunDir
from tests.support.runs import RECIPE

Usage = namedtuple("Usage", "total used free")
NO_GPU = pytest.mark.skipif(
    torch.cuda.is_available(), reason="needs a machine without an NVIDIA GPU"
)


def said(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    assert main([str(word) for word in words]) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    assert main([str(word) for word in words]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1
    return printed.err


# --- one process


def test_a_second_process_cannot_train_the_same_run(capture: Path, tmp_path: Path) -> None:
    run = TrainRun(capture, tmp_path / "run", resume=True)
    run.output.mkdir()
    with (
        RunDir(run.output).lock(),
        pytest.raises(InputError, match="another process trains the run in"),
    ):
        train_capture(run, recipe=RECIPE)
    assert not (run.output / "config.json").exists()
    with RunDir(run.output).lock():  # which is free again
        pass


def test_what_a_killed_process_was_writing_is_removed(tmp_path: Path) -> None:
    folder = RunDir(tmp_path)
    folder.previews.mkdir()
    own = (folder.config, folder.checkpoint, folder.log, folder.previews / "teacher_000010.png")
    writing = [atomic_path(path) for path in own]
    left = [each.__enter__() for each in writing]  # and the process is killed
    others = [tmp_path / name for name in (".metrics-mine.jsonl", ".other-abcdefgh.txt", "a.png")]
    for path in others:
        path.touch()
    assert all(path.exists() for path in left)
    with folder.lock():
        assert not any(path.exists() for path in left)
    with folder.lock(), atomic_path(folder.log):
        with pytest.raises(InputError, match="another process"), RunDir(tmp_path).lock():
            pass
        assert len(list(tmp_path.glob(".metrics-*.jsonl"))) == 2  # mine, and the one in use
    assert all(path.exists() for path in others)


# --- a run's folder in place of a scene


def test_a_run_s_folder_stands_for_its_scene(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = finished / "scene.mgs"
    assert scene_at(finished) == scene and scene_at(scene) == scene
    assert said(capsys, "info", finished) == said(capsys, "info", scene)
    page = tmp_path / "page.html"
    assert f"{page}: " in said(capsys, "export", finished, "--to", "html", "-o", page)
    teacher = tmp_path / "teacher.ply"
    said(capsys, "export", finished, "--to", "ply", "-o", teacher)
    assert teacher.stat().st_size > 1000


def test_a_run_s_folder_stands_for_its_teacher_where_a_plain_scene_is_needed(
    finished: Path, tmp_path: Path
) -> None:
    assert read_plain_scene(finished).blend == "sorted"
    shutil.copytree(finished, tmp_path / "run")
    (tmp_path / "run" / "teacher.ply").unlink()
    with pytest.raises(InputError, match=r"teacher\.ply does not exist"):
        read_plain_scene(tmp_path / "run")


def test_a_run_without_a_scene_is_refused(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = tmp_path / "begun"
    begun.mkdir()
    shutil.copy(finished / "config.json", begun)
    assert "has no scene yet: continue it with --resume" in refused(capsys, "info", begun)


def test_eval_and_render_take_capture_and_photo_size_of_the_run(
    finished: Path, capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = json.loads(said(capsys, "eval", finished, "--json"))
    assert Path(own["capture"]) == capture
    moved = tmp_path / "run"
    shutil.copytree(finished, moved)
    config = json.loads((moved / "config.json").read_text())
    config["options"]["downscale"] = 2
    (moved / "config.json").write_text(json.dumps(config))
    assert json.loads(said(capsys, "eval", moved, "--json"))["downscale"] == 2
    given = said(capsys, "eval", moved, "--json", "--downscale", "1", "--capture", capture)
    assert json.loads(given)["psnr"] == pytest.approx(own["psnr"])
    said(capsys, "render", moved, "-o", tmp_path / "images")
    assert len(list((tmp_path / "images").iterdir())) == len(load_capture(capture).test)
    config["options"]["capture"] = str(tmp_path / "gone")
    (moved / "config.json").write_text(json.dumps(config))
    assert "give --capture CAPTURE" in refused(capsys, "eval", moved)


def test_a_run_ends_with_the_next_commands(
    finished: Path, capture: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    printed = said(capsys, "train", capture, "-o", finished, "--resume")
    for command in (f"mobilegs view {finished} --lan", f"mobilegs export {finished} --to html"):
        assert command in printed


# --- before the first long stage


@NO_GPU
def test_devices_are_checked_and_named(capture: Path, tmp_path: Path) -> None:
    for name in ("gpu", "cuda:", "cuda:x", "cpu:0", "cuda:-1"):
        with pytest.raises(InputError, match=f"there is no device '{name}'"):
            choose_device(name)
    for name in ("cuda", "cuda:1"):
        with pytest.raises(InputError, match="no CUDA device"):
            choose_device(name)
        with pytest.raises(InputError, match="no CUDA device"):
            validate_run(TrainRun(capture, tmp_path / "run", device=name))
    assert choose_device("auto") == choose_device("cpu") == torch.device("cpu")


def test_a_gpu_is_named_by_its_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "device_count", lambda: 2)
    assert choose_device("cuda:1") == torch.device("cuda", 1)
    assert choose_device("auto") == torch.device("cuda")
    with pytest.raises(InputError, match=r"this machine has 2 GPUs, from cuda:0 on"):
        choose_device("cuda:2")


def test_a_run_of_a_time_has_the_settings_for_short_runs_on_a_gpu_too(
    monkeypatch: pytest.MonkeyPatch, capture: Path, tmp_path: Path
) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    run = TrainRun(capture, tmp_path / "run")
    strategies = {
        "clone_split": (run, replace(run, minutes=5.0), replace(run, steps=9, device="cpu")),
        "mini_splatting": (replace(run, steps=9), replace(run, preset="long", minutes=5.0)),
    }
    for strategy, runs in strategies.items():
        for each in runs:
            assert resolve_recipe(each).teacher.densify.strategy == strategy


@NO_GPU
def test_long_presets_ask_before_they_train_on_a_cpu(capture: Path, tmp_path: Path) -> None:
    for preset in ("long", "paper", "release"):
        run = replace(TrainRun(capture, tmp_path / "run"), preset=preset)
        with pytest.raises(InputError, match=f"preset {preset} is for a GPU"):
            resolve_recipe(run)
        for answered in (
            replace(run, device="cpu"),
            replace(run, steps=9),
            replace(run, minutes=5.0),
        ):
            resolve_recipe(answered)


def test_a_full_disk_is_found_first(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(preflight.shutil, "disk_usage", lambda path: Usage(1 << 40, 1 << 40, 99))
    with pytest.raises(InputError, match="has 0 MiB left, and a run takes about"):
        validate_run(TrainRun(capture, tmp_path / "run"))


@pytest.mark.parametrize(
    "error",
    [OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), RuntimeError("No space left on device")],
    ids=["system", "library"],
)
def test_a_disk_that_becomes_full_gives_a_sentence_with_the_path(
    error: Exception, tmp_path: Path
) -> None:
    path = tmp_path / "scene.mgs"
    path.write_bytes(b"before")
    with pytest.raises(InputError, match=r"scene\.mgs: the disk is full"), atomic_path(path):
        raise error
    assert path.read_bytes() == b"before" and list(tmp_path.iterdir()) == [path]
