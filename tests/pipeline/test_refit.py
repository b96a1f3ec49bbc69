"""A sort-free scene becomes a file for tools that sort: refitted, and its loss is measured."""

import json
import re
import shutil
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.data.dataset import Dataset
from mobilegs.data.demo.capture import write_capture
from mobilegs.errors import InputError
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.mgs.codec import encode_mgs, read_mgs, write_mgs
from mobilegs.pipeline import refit as refitting
from mobilegs.pipeline.export_sorted import SortedExport, export_sorted
from mobilegs.pipeline.refit import measure_fit, refit, views_around, views_from
from mobilegs.render.scene import Scene
from mobilegs.scene_file import PLAIN, Kind
from mobilegs.train.student.trainer import Student
from tests.support.scene_cases import Case, make_scene
from tests.support.tiny import CPU, train


@pytest.fixture(scope="module", autouse=True)
def short() -> Iterator[None]:
    """Few steps."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(refitting, "STEPS", 60)
        yield


@pytest.fixture(scope="module")
def capture(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The photos that the student below has learned from, as COLMAP would leave them."""
    folder = tmp_path_factory.mktemp("capture") / "blobs"
    write_capture(folder, dataset)
    return folder


@pytest.fixture(scope="module")
def trained(
    make_student: Callable[..., Student],
    dataset: Dataset,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """The file of a student of the tiny capture."""
    path = tmp_path_factory.mktemp("trained") / "scene.mgs"
    stage = make_student()
    train(stage, dataset, stage.steps)
    write_mgs(path, stage.quantized_scene())
    return path


@pytest.fixture
def student(trained: Path, tmp_path: Path) -> Path:
    """A copy of that file, which lies in no run."""
    (tmp_path / "alone").mkdir()
    return Path(shutil.copy(trained, tmp_path / "alone" / "scene.mgs"))


@pytest.fixture(scope="module")
def files(
    trained: Path, capture: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[Kind, tuple[Path, str]]:
    """The student refitted to the capture in every format, each with its message."""
    folder = tmp_path_factory.mktemp("files")
    kinds: tuple[Kind, ...] = ("ply", "sog", "glb", "spz")
    found: dict[Kind, tuple[Path, str]] = {}
    for kind in kinds:
        path = folder / f"there.{kind}"
        found[kind] = path, exported(trained, path, kind, capture=capture)
    return found


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few and small renders from placed cameras."""
    monkeypatch.setattr(refitting, "SIDE_MAX", 32)
    monkeypatch.setattr(refitting, "VIEWS", 17)


def exported(student: Path, output: Path, kind: Kind = "ply", **how: Any) -> str:
    return export_sorted(SortedExport(student, output, kind, **how))[1]


def refusal(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    assert main([str(word) for word in words]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    return said


def test_a_refit_brings_the_sorted_scene_nearer_to_the_student(
    student: Path, capture: Path
) -> None:
    scene = read_mgs(student).decode(CPU)
    views = views_from(scene, load_capture(capture))
    found = refit(scene, views, seed=0)
    fit = measure_fit(scene, found, views)
    assert fit.after > fit.before + 1
    assert len(found) == len(scene.gaussians)
    assert found.sh_degree == scene.gaussians.sh_degree
    assert not torch.equal(found.sh[:, 1:], scene.gaussians.sh[:, 1:])
    assert fit.photos is not None and fit.photos[1] > 20
    assert f"refitted to sorted blending: {fit.after:.1f} dB" in str(fit)
    assert f"{fit.views} held-back" in str(fit)


def test_test_images_are_not_trained_on(student: Path, capture: Path) -> None:
    data = load_capture(capture)
    views = views_from(read_mgs(student).decode(CPU), data)
    names = [
        [frame.name for frame in frames] for frames in (views.renders.train, views.renders.test)
    ]
    assert names == [[frame.name for frame in frames] for frames in (data.train, data.test)]


def test_the_reported_psnr_is_that_of_the_file(
    student: Path, capture: Path, files: dict[Kind, tuple[Path, str]]
) -> None:
    """A .spz stores less than was fitted, so it is measured after reading it back."""
    scene = read_mgs(student).decode(CPU)
    views = views_from(scene, load_capture(capture))
    before, told_before = Scene(scene.gaussians, background=scene.background), set()
    for path, said in files.values():
        told = re.search(r"blending: ([\d.]+) dB \(before: ([\d.]+) dB\)", said)
        assert told is not None
        found = Scene(PLAIN[path.suffix](path), background=scene.background)
        assert len(found.gaussians) == len(scene.gaussians)
        assert evaluate(found, views.renders)["psnr"] == pytest.approx(float(told[1]), abs=0.06)
        told_before.add(float(told[2]))
    [told] = told_before
    assert evaluate(before, views.renders)["psnr"] == pytest.approx(told, abs=0.06)


@pytest.mark.thorough
def test_the_same_seed_gives_the_same_file(
    student: Path, capture: Path, tmp_path: Path, files: dict[Kind, tuple[Path, str]]
) -> None:
    for name, seed in (("again", 0), ("other", 4)):
        exported(student, tmp_path / f"{name}.ply", capture=capture, seed=seed)
    again, other = (tmp_path / f"{name}.ply" for name in ("again", "other"))
    assert files["ply"][0].read_bytes() == again.read_bytes() != other.read_bytes()


def test_without_a_capture_cameras_are_placed(
    small: None, student: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = read_mgs(student).decode(CPU)
    views = views_around(scene, [], seed=0)
    assert (len(views.renders.train), len(views.renders.test)) == (14, 3)
    assert views.photos is None
    monkeypatch.setattr(refitting, "VIEWS", 80)
    said = exported(student, tmp_path / "there.ply")
    assert "10 held-back" in said and "photos" not in said
    told = [float(figure) for figure in re.findall(r"([\d.]+) dB", said)]
    assert told[0] > told[1]


def test_cameras_are_placed_between_those_of_the_file(small: None, student: Path) -> None:
    """All of them if the scene was seen from one side, otherwise half of them."""
    scene = read_mgs(student).decode(CPU)
    K = torch.tensor([[28.0, 0, 12], [0, 28, 12], [0, 0, 1]])
    up = torch.tensor([0.0, 0, 1])

    def looking(*places: tuple[float, float]) -> list[Camera]:
        eyes = torch.tensor([[x, y, 0.5] for x, y in places])
        return [Camera(look_at(eye, torch.zeros(3), up), K, 24, 24) for eye in eyes]

    def away(given: list[Camera]) -> torch.Tensor:
        own = views_around(scene, given, seed=0).renders
        eyes = torch.stack([frame.camera.position for frame in [*own.train, *own.test]])
        return torch.cdist(eyes, torch.stack([camera.position for camera in given])).amin(1)

    one_side = looking((3, 0), (3, 0.4), (3, 0.8))
    assert away(one_side).max() < 0.3
    around = looking((3, 0), (0, 3), (-3, 0))
    assert int((away(around) < 1e-6).sum()) >= 3
    assert away(one_side[:1]).max() > 1


def test_a_scene_in_its_run_uses_the_capture_of_the_run(
    small: None, student: Path, capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refitting, "STEPS", 1)
    config = student.with_name("config.json")
    config.write_text(json.dumps({"options": {"capture": str(capture), "downscale": None}}))
    assert "against photos" in exported(student, tmp_path / "there.ply")
    for content in (
        "no JSON",
        json.dumps({"options": {"capture": "gone", "downscale": None}}),
        json.dumps({"options": {"capture": 3}}),
    ):
        config.write_text(content)
        assert "against photos" not in exported(student, tmp_path / "there.ply")


def test_the_psnr_is_noted_in_the_header(
    tmp_path: Path, files: dict[Kind, tuple[Path, str]]
) -> None:
    notes = {kind: said.partition(": ")[2] for kind, (_, said) in files.items()}
    head = files["ply"][0].read_bytes()[:4000].decode("latin1")
    assert f"\ncomment mobilegs {notes['ply']}\n" in head
    assert "\ncomment SplatRenderMode: default\n" in head
    with zipfile.ZipFile(files["sog"][0]) as archive:
        extras = json.loads(archive.read("meta.json"))["asset"]["extras"]
    assert extras == {"blend": "sorted", "note": notes["sog"]}
    glb = files["glb"][0].read_bytes()
    content = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])
    assert content["asset"]["extras"] == {"blend": "sorted", "note": notes["glb"]}
    plain = tmp_path / "plain.ply"  # a scene that was not refitted has no such comment
    write_ply(plain, read_ply(files["ply"][0]))
    assert b"refitted" not in plain.read_bytes()[:4000]


def test_the_teacher_of_a_run_is_exported_instead(
    student: Path, capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    teacher, there = student.with_name("teacher.ply"), tmp_path / "there.ply"
    write_ply(teacher, read_mgs(student).decode(CPU).gaussians.select(slice(7)))
    student.with_name("metrics.json").write_text("{}")
    before = teacher.read_bytes()
    assert f"wrote {teacher} instead" in exported(student, there)
    assert len(read_ply(there)) == 7
    assert "refitted to sorted" in exported(student, there, refit=True, capture=capture)
    assert len(read_ply(there)) == len(read_mgs(student))
    words = ["export", student, "--to", "ply", "-o"]
    assert "you add --refit" in refusal(capsys, *words, there, "--capture", capture)
    said = refusal(capsys, *words, teacher, "--refit", "--capture", capture)
    assert "would be overwritten" in said
    assert teacher.read_bytes() == before


STAGES = ("placing cameras", "rendering views", "refitting", "writing a .spz", "measuring")


def test_the_command_line_refits(
    small: None,
    student: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    there = tmp_path / "there.spz"
    assert main(["export", str(student), "--to", "spz", "-o", str(there)]) == 0
    lines = capsys.readouterr().out.splitlines()
    said = [line for line in lines if not line.startswith(STAGES)]
    assert len(said) == 2
    assert said[0].startswith(f"{student}: refitted to sorted blending: ")
    assert said[1] == f"{there}: {there.stat().st_size:,} bytes"
    assert {line.split(":")[0] for line in lines} >= set(STAGES)


def test_a_sorted_scene_is_not_refitted(
    student: Path, capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain, coded = tmp_path / "plain.ply", tmp_path / "sorted.mgs"
    write_ply(plain, read_mgs(student).decode(CPU).gaussians)
    coded.write_bytes(encode_mgs(replace(make_scene(Case(20)), blend="sorted")))
    for scene in (plain, coded):
        words = ["export", scene, "--to", "glb", "-o", tmp_path / "there.glb"]
        for more in (["--refit"], ["--capture", capture], ["--seed", 1], ["--device", "cpu"]):
            said = refusal(capsys, *words, *more)
            assert "already made for sorted blending" in said and more[0] in said
        assert not (tmp_path / "there.glb").exists()
        assert main([str(word) for word in words]) == 0
        (tmp_path / "there.glb").unlink()
        assert "refitted" not in capsys.readouterr().out


def test_invalid_refits_give_one_sentence_and_write_nothing(
    student: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["export", student, "--to", "ply", "-o", tmp_path / "there.ply"]
    assert "no capture at" in refusal(capsys, *words, "--capture", tmp_path / "gone")
    assert "seed" in refusal(capsys, *words, "--seed", -1)
    if not torch.cuda.is_available():
        assert "CUDA" in refusal(capsys, *words, "--device", "cuda")
    student.write_bytes(student.read_bytes()[:-9])
    refusal(capsys, *words)
    assert [path.name for path in tmp_path.iterdir()] == ["alone"]


def test_a_capture_of_another_scene_is_refused(student: Path, capture: Path) -> None:
    scene, data = read_mgs(student).decode(CPU), load_capture(capture)
    scene.gaussians.means += 1000.0
    with pytest.raises(InputError, match="show nothing of this scene"):
        views_from(scene, data)
    with pytest.raises(InputError, match="holds no photo back"):
        views_from(scene, replace(data, test=[]))


def test_photos_are_reduced_in_size_and_number(
    student: Path, capture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refitting, "SIDE_MAX", 12)
    monkeypatch.setattr(refitting, "TRAIN_MAX", 2)
    data = load_capture(capture)
    views = views_from(read_mgs(student).decode(CPU), data)
    assert [frame.name for frame in views.renders.train] == [data.train[i].name for i in (0, -1)]
    assert {(frame.camera.width, frame.camera.height) for frame in views.renders.train} == {
        (12, 12)
    }


def test_an_interrupted_refit_keeps_the_old_file(
    student: Path,
    capture: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    there = tmp_path / "there.ply"
    there.write_text("before")

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(refitting.Teacher, "advance", interrupted)
    words = ["export", student, "--to", "ply", "-o", there, "--capture", capture]
    assert main([str(word) for word in words]) == 130
    assert "nothing was written" in capsys.readouterr().err
    assert there.read_text() == "before"
    assert {path.name for path in tmp_path.iterdir()} == {"alone", "there.ply"}
