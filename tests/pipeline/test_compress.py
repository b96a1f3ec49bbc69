"""`mobilegs compress`: scenes of other tools, with and without photos."""

import json
from pathlib import Path

import pytest
import torch

from mobilegs.cli.main import main
from mobilegs.data import load_capture, load_view
from mobilegs.formats.ply import write_ply
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.scene import Scene
from mobilegs.synthetic_capture.render import CaptureOptions, render_synthetic_capture
from mobilegs.viewpoints.cameras_json import read_cameras_json
from tests.support.garden import cameras_json, garden


@pytest.mark.thorough
def test_compress_leaves_a_small_scene_and_can_resume(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, run = tmp_path / "garden.ply", tmp_path / "run"
    write_ply(source, garden())
    words = ["compress", str(source), "-o", str(run), "--preset", "demo", "--steps", "120"]
    words += ["--views", "16", "--size", "64"]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "scene.mgs" in said
    metrics = json.loads((run / "metrics.json").read_text())
    assert metrics["student"]["psnr"] > 22
    own = metrics["teacher"]["psnr"]  # against its own renders in 8 bits
    assert own is None or own > 45  # None: without any error
    assert (run / "scene.mgs").stat().st_size < source.stat().st_size / 4
    page = (run / "report.html").read_text()
    for kind, figures in metrics["formats"].items():
        assert 1000 < figures["file_bytes"] < source.stat().st_size and figures["psnr"] > 22
        assert f"the same scene as .{kind}: {figures['file_bytes']:,} bytes" in said
        assert f"the teacher as .{kind}" in page
    assert [*metrics["formats"]] == ["sog", "spz"] and "bytes a Gaussian" in page
    assert main([*words, "--resume"]) == 0
    assert main(words) == 2
    assert "--resume" in capsys.readouterr().err


def test_compress_takes_cameras_background_and_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, run = tmp_path / "garden.ply", tmp_path / "run"
    write_ply(source, garden(600))
    given = cameras_json(tmp_path / "cameras.json")
    words = ["compress", str(source), "-o", str(run), "--preset", "demo", "--target-mb", "0.01"]
    words += ["--cameras", str(given), "--steps", "30", "--views", "16", "--size", "64"]
    assert main([*words, "--background", "1", "1", "2"]) == 2
    assert "background" in capsys.readouterr().err and not run.exists()
    assert main([*words, "--background", "1", "1", "0"]) == 0
    frames = load_capture(run / "capture").train
    eyes = torch.stack([frame.camera.position for frame in frames])
    first = torch.stack([camera.position for camera in read_cameras_json(given)])
    assert (torch.cdist(first, eyes).min(1).values < 1e-3).sum() >= 4  # of six, but those held back
    assert (run / "scene.mgs").stat().st_size < 15_000
    assert read_mgs(run / "scene.mgs").decode().background.tolist() == [1, 1, 0]
    own = json.loads((run / "metrics.json").read_text())["teacher"]["psnr"]
    assert own is None or own > 45  # renders and training have the same background
    corners = [load_view(frame).image[0, 0] for frame in frames]
    assert any(torch.equal(corner, torch.tensor([1.0, 1, 0])) for corner in corners)


@pytest.mark.thorough
def test_compress_can_train_on_the_photos_of_the_scene(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, capture = tmp_path / "garden.ply", tmp_path / "capture"
    write_ply(source, garden())
    render_synthetic_capture(Scene(garden()), source, capture, CaptureOptions(views=16, size=64))
    words = ["compress", str(source), "--capture", str(capture), "--preset", "demo"]
    assert main([*words, "--steps", "30", "-o", str(tmp_path / "run")]) == 0
    assert json.loads((tmp_path / "run" / "metrics.json").read_text())["student"]["psnr"] > 18
    assert not (tmp_path / "run" / "capture").exists()
    elsewhere = garden()
    elsewhere.means[:] += 1000
    write_ply(source, elsewhere)
    assert main([*words, "-o", str(tmp_path / "other")]) == 2
    assert "14 of 14 photos of" in capsys.readouterr().err
    assert not (tmp_path / "other").exists()


def test_compress_with_photos_is_training_with_a_given_teacher(tmp_path: Path) -> None:
    source, capture, runs = tmp_path / "garden.ply", tmp_path / "capture", {}
    write_ply(source, garden(300))
    scene = Scene(garden(300))
    render_synthetic_capture(scene, source, capture, CaptureOptions(views=16, size=64))
    more = ["--preset", "demo", "--steps", "10", "--target-mb", "0.02"]
    for verb, words in (
        ("compress", [str(source), "--capture", str(capture)]),
        ("train", [str(capture), "--teacher", str(source)]),
    ):
        runs[verb] = tmp_path / verb
        assert main([verb, *words, "-o", str(runs[verb]), *more]) == 0
    for name in ("scene.mgs", "teacher.ply"):
        assert (runs["compress"] / name).read_bytes() == (runs["train"] / name).read_bytes()
    recipe = json.loads((runs["train"] / "config.json").read_text())["recipe"]
    assert recipe["student"]["steps"] == 10  # all of them: the teacher is given
    assert recipe["student"]["quantization"]["target_mb"] == 0.02
    assert read_mgs(runs["train"] / "scene.mgs").footprint.blur == scene.footprint.blur == 0.3


def test_compress_refuses_cameras_of_another_scene(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source, given = tmp_path / "garden.ply", cameras_json(tmp_path / "cameras.json")
    rows = json.loads(given.read_text())
    for row in rows:
        row["position"][0] += 1000
    given.write_text(json.dumps(rows))
    write_ply(source, garden())
    words = ["compress", str(source), "-o", str(tmp_path / "run"), "--cameras", str(given)]
    assert main([*words, "--views", "16", "--size", "64"]) == 2
    assert "show nothing of this scene" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["missing.ply"], "missing.ply"),
        (["run/teacher.ply"], "would be overwritten"),
        (["garden.ply", "--target-mb", "-1"], "target_mb"),
        (["garden.ply", "--views", "0"], "views must lie"),
        (["garden.ply", "--cameras", "missing.json"], "cannot read missing.json: No such file"),
        (["garden.ply", "--cameras", "a.json", "--up", "z"], "leave out --up"),
    ],
)
def test_invalid_options_are_refused(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    sentence: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    write_ply(tmp_path / "garden.ply", garden(100))
    if words[0].startswith("run"):
        (tmp_path / "run").mkdir()
        write_ply(tmp_path / words[0], garden(100))
    assert main(["compress", *words, "-o", "run"]) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run" / "config.json").exists()
    assert not (tmp_path / "run" / "capture").exists()


def test_compress_refuses_a_file_in_the_place_of_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "garden.ply"
    write_ply(source, garden(100))
    for output in (source, source / "run"):
        assert main(["compress", str(source), "-o", str(output)]) == 2
        assert "is a file: give a folder" in capsys.readouterr().err
