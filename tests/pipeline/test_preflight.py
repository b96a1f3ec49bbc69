"""Invalid runs: their error messages, and that no file is lost."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.data.demo.capture import write_capture
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.progress_display import printed_log
from mobilegs.train.recipes import with_settings
from tests.support.runs import RECIPE

# --- settings


@pytest.mark.parametrize(
    "setting",
    [
        "student.lr.opacities",
        "student.opacity=1",
        "student=1",
        "teacher.steps=many",
        "teacher.steps.more=1",
        "student.steps=1.5",
    ],
)
def test_unknown_settings_are_refused(setting: str) -> None:
    with pytest.raises(InputError, match=setting.split("=")[0]):
        with_settings(RECIPE, [setting])


@pytest.mark.parametrize(
    ("setting", "known"),
    [
        ("student.blend=alpha", "sortfree, sorted"),
        ("teacher.densify.strategy=mini-splatting", "mini_splatting"),
        ("student.exposure.learned=maybe", "auto, always, never"),
    ],
)
def test_an_unknown_choice_is_refused_with_the_known_ones(setting: str, known: str) -> None:
    with pytest.raises(InputError, match=f"'{setting}' is none of .*{known}"):
        with_settings(RECIPE, [setting])


def test_a_misspelt_setting_gets_suggestions() -> None:
    with pytest.raises(InputError, match="did you mean opacities") as near:
        with_settings(RECIPE, ["student.lr.opacitie=1"])
    assert "quats" not in str(near.value)
    with pytest.raises(InputError, match=r"did you mean student\.quantization\.quality"):
        with_settings(RECIPE, ["student.quality=1"])
    with pytest.raises(InputError, match="quats"):
        with_settings(RECIPE, ["student.lr.zzz=1"])


@pytest.mark.parametrize(
    "setting",
    [
        "student.steps=0",
        "teacher.sh_degree=-1",
        "teacher.mini_splatting.sampled=0",
        "student.lr.opacities=NaN",
        "student.lr.opacities=Infinity",
        "student.loss.overdraw_weight=-1",
        "student.schedule.rate_from=1.1",
        "student.pruning.quantile=1.5",
        "student.view_dependence.start_opacity=1",
        "student.color.degree=4",
        "student.color.latents=5",
    ],
)
def test_values_out_of_range_are_refused(setting: str) -> None:
    path, _, value = setting.partition("=")
    *parents, name = path.split(".")
    sentence = f"in {'.'.join(parents)}, .*{name}.*must be .*not .*{value}".replace("NaN", "nan")
    with pytest.raises(InputError, match=sentence.replace("Infinity", "inf")):
        with_settings(RECIPE, [setting])


@pytest.mark.parametrize(
    ("setting", "hint"),
    [
        ("student.pruning.votes.quantile=0.4", "there is no 'votes'"),
        ("student.weighting.name=depth_pass", "there is no 'name'"),
        ("student.lr.codebooks=0", "did you mean codebook_factor"),
    ],
)
def test_a_setting_of_before_is_refused_in_a_sentence(setting: str, hint: str) -> None:
    with pytest.raises(InputError, match=f"'{setting}' names no setting.*{hint}"):
        with_settings(RECIPE, [setting])


def test_settings_are_validated_together() -> None:
    books = with_settings(RECIPE, ["student.quantization.method=nvq"])
    recipe = with_settings(
        books, ["student.quantization.target_mb=1", "student.quantization.method=sq"]
    )
    assert (recipe.student.quantization.target_mb, recipe.student.quantization.method) == (
        1.0,
        "sq",
    )
    with pytest.raises(
        InputError, match=r"in student.quantization, target_mb 1.0 .* needs method=sq"
    ):
        with_settings(books, ["student.quantization.target_mb=1"])
    twice = with_settings(RECIPE, ["student.pruning.quantile=0.1", "student.pruning.quantile=0.2"])
    assert twice.student.pruning.quantile == 0.2
    for coding, latents in (("sq", 12), ("nvq", 6)):  # 9 harmonics depend on the direction
        many = with_settings(
            RECIPE, [f"student.quantization.method={coding}", "student.color.latents=40"]
        )
        assert many.student.color_shape.latents == latents


def test_an_invalid_student_is_refused_before_the_teacher_trains(
    capture: Path, tmp_path: Path
) -> None:
    settings = ("student.quantization.lod_levels=8", "student.color.latents=12")
    run = TrainRun(capture, tmp_path / "run", settings=(settings,))
    with pytest.raises(InputError, match="need more streams than a file may have"):
        train_capture(run)
    assert not (tmp_path / "run").exists()


# --- existing runs


@pytest.fixture(scope="module")
def other(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The capture's photos with other poses."""
    dataset = load_capture(capture)

    def moved(frame):
        viewmat = frame.camera.viewmat.clone()
        viewmat[2, 3] += 0.5
        return replace(frame, camera=replace(frame.camera, viewmat=viewmat))

    frames = {"train": [*map(moved, dataset.train)], "test": [*map(moved, dataset.test)]}
    folder = tmp_path_factory.mktemp("other") / "blobs"
    write_capture(folder, replace(dataset, **frames))
    return folder


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> Path:
    """A copy of a finished run, which a test may damage."""
    shutil.copytree(finished, tmp_path / "run")
    return tmp_path / "run"


@pytest.mark.parametrize("measured", [True, False])
def test_another_capture_is_not_mixed_with_a_run(
    capture: Path, other: Path, run: Path, tmp_path: Path, measured: bool
) -> None:
    if not measured:
        (run / "metrics.json").unlink()
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    with pytest.raises(
        InputError, match=r"blobs is not the capture that the run in .*run trains on"
    ):
        train_capture(TrainRun(other, run, resume=True))
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    moved = tmp_path / "elsewhere"
    shutil.copytree(capture, moved)
    assert train_capture(TrainRun(moved, run, resume=True))["student"]["gaussians"] > 0


def test_options_that_contradict_a_finished_run_are_refused(capture: Path, run: Path) -> None:
    for asked in (TrainRun(capture, run, seed=4), TrainRun(capture, run, steps=9)):
        with pytest.raises(InputError, match="was started with"):
            train_capture(replace(asked, resume=True))
    (run / "metrics.json").write_text("{")
    with pytest.raises(InputError, match=r"metrics\.json is damaged .* delete it"):
        train_capture(TrainRun(capture, run, resume=True))


@pytest.mark.parametrize("poses", [None, [0.0] * 11, ["x"] * 12])
def test_a_config_with_damaged_photos_is_refused(capture: Path, run: Path, poses: object) -> None:
    config = run / "config.json"
    content = json.loads(config.read_text())
    content["photos"]["poses"] = poses
    config.write_text(json.dumps(content))
    with pytest.raises(InputError, match=r"config\.json is damaged"):
        train_capture(TrainRun(capture, run, resume=True))


def test_a_demo_does_not_touch_another_run(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "-o", str(run)]) == 2
    assert "holds a run of something else" in capsys.readouterr().err
    assert not (run / "capture").exists()


@pytest.mark.parametrize("name", ["contact_sheet.png", "metrics.jsonl", "previews", "teacher.ply"])
def test_other_files_are_not_overwritten(capture: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match=f"{name} would be overwritten"):
        train_capture(TrainRun(capture, tmp_path), recipe=RECIPE)
    assert [path.name for path in tmp_path.iterdir()] == [name]


# --- invalid inputs


def test_an_empty_teacher_is_refused(capture: Path, finished: Path, tmp_path: Path) -> None:
    gaussians = read_ply(finished / "teacher.ply")
    write_ply(tmp_path / "none.ply", gaussians.select(slice(0)))
    with pytest.raises(InputError, match=r"none\.ply has no Gaussians"):
        train_capture(TrainRun(capture, tmp_path / "run", teacher=tmp_path / "none.ply"))
    assert not (tmp_path / "run").exists()


def test_an_unreachable_size_is_reported(
    capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe = with_settings(RECIPE, ["student.quantization.target_mb=0.001"])
    with printed_log():
        train_capture(TrainRun(capture, tmp_path / "run"), recipe=recipe)
    said = capsys.readouterr().out
    assert "MB, not the 0.001 MB of target_mb" in said and "with fewer Gaussians" in said
    photos = json.loads((tmp_path / "run" / "config.json").read_text())["photos"]
    assert len(photos["poses"]) == 12 and "9 photos of 24x20, 12 steps for the teacher" in said


def test_rendered_images_never_overwrite_photos(
    capture: Path, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(capture, tmp_path / "capture")
    photos = tmp_path / "capture" / "images"
    before = {path.name: path.read_bytes() for path in photos.iterdir()}
    words = ["render", str(run / "scene.mgs"), "--capture", str(tmp_path / "capture"), "-o"]
    assert main([*words, str(photos)]) == 2
    assert "is a photo of the capture" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in photos.iterdir()} == before
    assert main([*words, str(tmp_path / "pictures")]) == 0
    with Image.open(tmp_path / "pictures" / "view_0.png") as picture:
        assert picture.size == (24, 20)


def test_unusable_output_paths_are_refused(
    capture: Path, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("mine")
    words = ["render", str(run / "scene.mgs"), "--capture", str(capture), "-o"]
    assert main([*words, str(tmp_path / "file")]) == 2
    assert "a file of that name" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"file is a file: give a folder"):
        train_capture(TrainRun(capture, tmp_path / "file" / "run"), recipe=RECIPE)
    assert (tmp_path / "file").read_text() == "mine"
