"""Whole runs: their files, their errors, and bit-exact resume."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import get_type_hints

import pytest
import torch
from PIL import Image

from mobilegs.cli.options import call
from mobilegs.cli.render import open_scene_and_capture
from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.evaluate.report import FileMetrics, RunMetrics
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import inspect_mgs, read_mgs
from mobilegs.pipeline import train
from mobilegs.pipeline.options import TrainRun, options_as_json, resolve_recipe
from mobilegs.pipeline.train import train_capture
from mobilegs.render.project import CLASSIC, Footprint
from mobilegs.train.recipes import RECIPES, PresetName, Recipe, from_json, with_settings, with_steps
from tests.support.runs import RECIPE

OUTPUTS = {
    ".lock",
    "config.json",
    "contact_sheet.png",
    "metrics.json",
    "metrics.jsonl",
    "previews",
    "scene.mgs",
    "teacher.ply",
}


def stopped_after(
    steps: int, run: TrainRun, monkeypatch: pytest.MonkeyPatch, recipe: Recipe = RECIPE
) -> None:
    """Start `run` and interrupt it during step `steps`, counted over both stages."""
    taken = 0
    for kind in (train.Teacher, train.Student):

        def advance(stage, views, original=kind.advance):
            nonlocal taken
            taken += 1
            if taken == steps:
                os.kill(os.getpid(), signal.SIGINT)
            return original(stage, views)

        monkeypatch.setattr(kind, "advance", advance)
    with pytest.raises(KeyboardInterrupt):
        train_capture(run, recipe=recipe)
    monkeypatch.undo()


def test_a_run_leaves_its_files(finished: Path) -> None:
    assert {path.name for path in finished.iterdir()} == OUTPUTS
    with Image.open(finished / "contact_sheet.png") as sheet:
        assert sheet.width > 0
    previews = {path.name for path in (finished / "previews").iterdir()}
    assert {"teacher_000012.png", "student_000018.png"} <= previews


def test_the_metrics_describe_the_file(finished: Path) -> None:
    metrics = json.loads((finished / "metrics.json").read_text())
    assert metrics.keys() == {*RunMetrics.__annotations__}
    assert metrics["student"].keys() == {*get_type_hints(FileMetrics)}
    assert metrics["student"]["file_bytes"] == (finished / "scene.mgs").stat().st_size
    for name in ("teacher", "student"):
        assert metrics[name]["psnr"] > 5 and metrics[name]["ssim"] is not None
        assert "lpips_vgg" in metrics[name] and metrics[name]["gaussians"] > 0
    assert metrics["seconds"].keys() == {"teacher", "student", "evaluation"}
    assert metrics["peak_memory_mib"] > 0 and metrics["image_size"] == [24, 20]


def test_the_file_has_notes(finished: Path) -> None:
    found = inspect_mgs(finished / "scene.mgs")
    assert "layers" not in found
    assert (
        str(found["meta"]["photos"]).endswith("of 24x20") and found["meta"]["student_steps"] == 18
    )


@pytest.mark.thorough
def test_another_seed_gives_other_bytes_and_the_file_has_the_given_lod_levels(
    capture: Path, finished: Path, tmp_path: Path
) -> None:
    recipe = with_settings(RECIPE, ["student.quantization.lod_levels=2"])
    train_capture(TrainRun(capture, tmp_path / "run", seed=1), recipe=recipe)
    found = inspect_mgs(tmp_path / "run" / "scene.mgs")
    layers = found.get("layers", [])
    assert len(layers) == 2 and sum(layers) == found["gaussians"]
    teachers = [(run / "teacher.ply").read_bytes() for run in (finished, tmp_path / "run")]
    assert teachers[0] != teachers[1]


def test_the_log_has_both_stages_in_order(finished: Path) -> None:
    rows = [json.loads(line) for line in (finished / "metrics.jsonl").read_text().splitlines()]
    steps = [(row["stage"], row["step"]) for row in rows if "loss" in row]
    expected = [("teacher", i) for i in range(1, 13)] + [("student", i) for i in range(1, 19)]
    assert steps == expected
    assert {"phase", "loss", "psnr", "gaussians", "seconds"} <= rows[0].keys()
    assert any("preview_psnr" in row for row in rows)


def test_a_run_resumed_after_ctrl_c_ends_in_the_same_bytes(
    capture: Path, finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the teacher, its last step, and the student; another seed or teacher is refused."""
    run = TrainRun(capture, tmp_path / "run", resume=True)
    stopped_after(7, run, monkeypatch)
    with pytest.raises(InputError, match="started with seed 0, not 4"):
        train_capture(replace(run, seed=4))
    stopped_after(12 - 7, run, monkeypatch)
    stopped_after(29 - 12, run, monkeypatch)
    path = tmp_path / "run" / "teacher.ply"
    teacher = path.read_bytes()
    write_ply(path, read_ply(path).select(slice(0, 5)))
    with pytest.raises(InputError, match="is not the teacher"):
        train_capture(run)
    path.write_bytes(teacher)
    train_capture(run)
    for name in ("scene.mgs", "teacher.ply", "contact_sheet.png"):
        assert (tmp_path / "run" / name).read_bytes() == (finished / name).read_bytes()
    assert {path.name for path in (tmp_path / "run").iterdir()} == OUTPUTS
    rows = [len((p / "metrics.jsonl").read_text().splitlines()) for p in (run.output, finished)]
    assert rows[0] == rows[1]


@pytest.mark.thorough
def test_refined_poses_and_exposures_are_kept_measured_and_resumed(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = ["teacher.pose.learned=true"]
    settings += [f"{stage}.exposure.learned=always" for stage in ("teacher", "student")]
    recipe = with_settings(RECIPE, settings)
    whole = train_capture(TrainRun(capture, tmp_path / "whole"), recipe=recipe)
    assert whole["poses"] == "refined"
    assert all(whole["exposures"][name]["learned"] for name in ("teacher", "student"))
    poses = json.loads((tmp_path / "whole" / "poses.json").read_text())
    assert len(poses["train"]) == whole["views"]["train"] and len(poses["test"]) > 0
    first = read_mgs(tmp_path / "whole" / "scene.mgs").views[0].viewmat
    given = load_capture(capture).train[0]
    torch.testing.assert_close(first, torch.tensor(poses["train"][given.name]))
    assert not torch.allclose(first, given.camera.viewmat, atol=1e-5)
    for name in ("scene.mgs", "teacher.ply"):
        *_, seen = open_scene_and_capture(tmp_path / "whole" / name, capture, None, "cpu")
        assert seen.test[0].camera.viewmat.tolist() == poses["test"][seen.test[0].name]
    run = TrainRun(capture, tmp_path / "run", resume=True)
    for steps in (8, 20 - 8):  # in each stage
        stopped_after(steps, run, monkeypatch, recipe)
    train_capture(run)
    for name in ("teacher.ply", "poses.json", "scene.mgs"):
        assert (run.output / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


@pytest.mark.thorough
def test_a_run_that_is_killed_can_be_resumed(capture: Path, finished: Path, tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[3])\n"
        "from mobilegs.pipeline.options import TrainRun\n"
        "from mobilegs.pipeline.train import train_capture\n"
        "from tests.support.runs import RECIPE\n"
        "run = TrainRun(Path(sys.argv[1]), Path(sys.argv[2]), checkpoint_seconds=0.0)\n"
        "train_capture(run, recipe=RECIPE)\n"
    )
    run, root = tmp_path / "run", Path(__file__).parents[2]
    arguments = [sys.executable, "-c", program, str(capture), str(run), str(root)]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    deadline = time.monotonic() + 60
    while not (run / "checkpoint.safetensors").exists():
        assert process.poll() is None, process.stderr and process.stderr.read().decode()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.kill()
    process.communicate()
    assert not (run / "metrics.json").exists()
    train_capture(TrainRun(capture, run, resume=True))
    assert (run / "scene.mgs").read_bytes() == (finished / "scene.mgs").read_bytes()


def test_resuming_a_finished_run_changes_nothing(capture: Path, finished: Path) -> None:
    before = (finished / "scene.mgs").stat().st_mtime_ns
    metrics = train_capture(TrainRun(capture, finished, resume=True))
    assert metrics == json.loads((finished / "metrics.json").read_text())
    assert (finished / "scene.mgs").stat().st_mtime_ns == before


def test_a_given_scene_can_be_the_teacher(capture: Path, finished: Path, tmp_path: Path) -> None:
    given = finished / "teacher.ply"
    train_capture(TrainRun(capture, tmp_path / "run", teacher=given), recipe=RECIPE)
    assert (tmp_path / "run" / "teacher.ply").read_bytes() == given.read_bytes()
    assert (tmp_path / "run" / "scene.mgs").read_bytes() == (finished / "scene.mgs").read_bytes()


def test_a_damaged_configuration_is_refused(capture: Path, tmp_path: Path) -> None:
    (tmp_path / "config.json").write_text('{"options": {}')
    with pytest.raises(InputError, match=r"config\.json is damaged"):
        train_capture(TrainRun(capture, tmp_path, resume=True))


# --- recipes


@pytest.mark.parametrize("name", list(RECIPES))
def test_a_recipe_survives_json(name: PresetName) -> None:
    recipe = RECIPES[name]()
    assert from_json(Recipe, json.loads(json.dumps(asdict(recipe)))) == recipe


def test_steps_are_divided_in_the_proportion_of_the_recipe() -> None:
    longer = with_steps(RECIPE, 300)
    assert (longer.teacher.steps, longer.student.steps) == (120, 180)
    assert with_steps(RECIPE, 2).student.steps == 1


def test_options_change_the_recipe(capture: Path, tmp_path: Path) -> None:
    run = TrainRun(
        capture,
        tmp_path,
        preset="demo",
        max_splats=77,
        views_per_step=3,
        settings=(("teacher.densify.gradient=1e-3",), ("student.weighting.exponent_max=8",)),
    )
    recipe = resolve_recipe(run)
    assert recipe.teacher.max_splats == 77
    assert recipe.teacher.views_per_step == recipe.student.views_per_step == 3
    assert recipe.teacher.densify.gradient == 1e-3
    assert recipe.student.weighting.exponent_max == 8


def test_a_size_limits_the_teacher_and_steers_the_student(tmp_path: Path) -> None:
    run = TrainRun(tmp_path, tmp_path, preset="short", target_mb=0.24)
    recipe = resolve_recipe(run)
    assert recipe.teacher.max_splats == 20_000
    assert recipe.student.quantization.target_mb == 0.24
    assert resolve_recipe(replace(run, target_mb=9.0)).teacher.max_splats == 60_000
    assert resolve_recipe(replace(run, max_splats=70_000)).teacher.max_splats == 70_000
    fixed = resolve_recipe(replace(run, settings=(("teacher.max_splats=30000",),)))
    assert fixed.teacher.max_splats == 30_000
    with pytest.raises(InputError, match="needs method=sq"):
        resolve_recipe(replace(run, preset="paper", device="cpu"))


def test_all_steps_are_the_students_if_the_teacher_is_given(tmp_path: Path) -> None:
    run = TrainRun(tmp_path, tmp_path, preset="demo", steps=84)
    recipe = resolve_recipe(run)
    assert (recipe.teacher.steps, recipe.student.steps) == (40, 44)
    assert resolve_recipe(replace(run, teacher=tmp_path / "a.ply")).student.steps == 84


def test_a_student_covers_pixels_as_a_given_teacher_does(tmp_path: Path) -> None:
    run = TrainRun(tmp_path, tmp_path, preset="demo", teacher=tmp_path / "a.ply")
    usual = resolve_recipe(run)
    assert resolve_recipe(run, None, Footprint(0.1, antialiased=True)) == usual
    student = resolve_recipe(run, None, CLASSIC).student
    assert (student.footprint.blur, student.footprint.antialiased) == (0.3, False)
    assert student.footprint.soft_edge and student.least_variance == 0
    own = replace(run, settings=(("student.least_variance=0.1",),))
    assert resolve_recipe(own, None, CLASSIC).student.least_variance == 0.1


def test_settings_may_be_given_together_or_one_by_one(tmp_path: Path) -> None:
    text = "--set student.lr.quats=1 student.lr.scales=2 --set student.view_dependence.kind=network"
    words = text.split()
    run = call(TrainRun, ["capture", "-o", str(tmp_path), *words], verb="train")
    student = resolve_recipe(run).student
    assert (student.lr.quats, student.lr.scales, student.view_dependence.kind) == (1, 2, "network")
    written = options_as_json(run)
    assert json.loads(json.dumps(written)) == written
    assert written["settings"] == [words[1], words[2], words[4]]


@pytest.mark.parametrize("name", list(RECIPES))
def test_a_method_changes_the_teachers_strategy_but_no_lengths(name, tmp_path: Path) -> None:
    options = {"preset": name, "device": "cpu"}
    plain = resolve_recipe(TrainRun(tmp_path, tmp_path, **options))
    strategies = {}
    for method in ("3dgs", "mini-splatting", "mcmc"):
        recipe = resolve_recipe(TrainRun(tmp_path, tmp_path, method=method, **options))
        strategies[method] = recipe.teacher.densify.strategy
        assert recipe.student == plain.student and recipe.teacher.steps == plain.teacher.steps
        assert recipe.teacher.max_splats == plain.teacher.max_splats
    assert list(strategies.values()) == ["clone_split", "mini_splatting", "mcmc"]
