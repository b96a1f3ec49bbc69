"""Captures from photos: stages, resuming, errors, and the commands that use them."""

import contextlib
import io
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.linalg import orthogonal_procrustes

from mobilegs.capture import CaptureRun, capture_photos, mapping, matches
from mobilegs.capture.matches import similar_pairs, vlad_vectors
from mobilegs.capture.misplaced_photos import drop_misplaced
from mobilegs.capture.pycolmap_runtime import PycolmapProcess, load_pycolmap
from mobilegs.capture.workspace import Workspace
from mobilegs.cli import doctor
from mobilegs.cli import train as cli_train
from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.pipeline import train, unposed
from tests.support.layered_photos import CENTERS, layered_photo, write_photos

pytest.importorskip("pycolmap", reason="needs the extra capture")


def relative_error(found: np.ndarray, truth: np.ndarray) -> float:
    """Return the largest distance of camera positions after a similarity, over their extent."""
    found, truth = found - found.mean(0), truth - truth.mean(0)
    rotation, _ = orthogonal_procrustes(found, truth)
    turned = found @ rotation
    scale = (turned * truth).sum() / (turned * turned).sum()
    errors = np.linalg.norm(scale * turned - truth, axis=1)
    return float(errors.max() / np.linalg.norm(truth, axis=1).max())


def centers(capture: Path) -> dict[str, np.ndarray]:
    dataset = load_capture(capture)
    return {
        frame.name: frame.camera.position.numpy().astype(np.float64)
        for frame in [*dataset.train, *dataset.test]
    }


def assert_centers_are_right(capture: Path) -> None:
    found = centers(capture)
    assert sorted(found) == [f"photo_{index}.jpg" for index in range(9)]
    assert relative_error(np.array([found[name] for name in sorted(found)]), CENTERS) < 0.02


def change_times(folder: Path) -> dict[str, int]:
    """Return the time of the last change of each file in a folder."""
    return {str(p.relative_to(folder)): p.stat().st_mtime_ns for p in sorted(folder.rglob("*"))}


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run stages in this process, where a test may replace their parts."""

    def call(self: PycolmapProcess, doing: str, function: Any, *given: Any, **options: Any) -> Any:
        return function(*given, **options)

    monkeypatch.setattr(PycolmapProcess, "call", call)


@pytest.fixture(scope="module")
def printed() -> io.StringIO:
    """The output of the command that made `finished`."""
    return io.StringIO()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory, printed: io.StringIO) -> tuple[Path, Path]:
    """Nine photos of layers and one of noise, and the capture made from them."""
    folder = tmp_path_factory.mktemp("layers")
    photos, capture = write_photos(folder / "photos"), folder / "capture"
    noise = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    Image.fromarray(noise).resize((240, 180)).save(photos / "zebra.jpg")
    with contextlib.redirect_stdout(printed):
        assert main(["capture", str(photos), "-o", str(capture)]) == 0
    return photos, capture


@pytest.fixture
def made(finished: tuple[Path, Path], tmp_path: Path) -> tuple[Path, Path]:
    """A copy of `finished` that a test may change."""
    photos, capture = finished
    shutil.copytree(photos, tmp_path / "photos")
    shutil.copytree(capture, tmp_path / "capture")
    return tmp_path / "photos", tmp_path / "capture"


def test_poses_of_all_photos_are_right(finished: tuple[Path, Path]) -> None:
    _, capture = finished
    report = json.loads((capture / "capture.json").read_text())
    assert (report["registered"], report["photos"], report["left_out"]) == (9, 10, ["zebra.jpg"])
    assert (report["pairs"], report["compared"], report["mapper"]) == ("all", 45, "incremental")
    assert 0 < report["reprojection_error"] < 1
    assert_centers_are_right(capture)
    with Image.open(capture / "coverage.png") as picture:
        assert picture.width > 1000
    assert {"images", "sparse", "work", "capture.json", "coverage.png"} == {
        path.name for path in capture.iterdir()
    }


def test_an_unrelated_photo_is_left_out_and_named(
    finished: tuple[Path, Path], printed: io.StringIO
) -> None:
    text = printed.getvalue()
    assert "9 of 10 photos" in text and "left out: zebra.jpg" in text
    stages = ["reading files", "preparing photos", "finding features", "matching photos"]
    stages += ["computing poses", "undistorting photos"]
    lines = text.splitlines()
    assert [line for line in lines if line.endswith(": started")] == [
        f"{stage}: started" for stage in stages
    ]
    assert "" not in lines
    assert len(load_capture(finished[1]).train) == 7
    message = error_of(*finished, min_placed=0.95)
    assert "only 9 of 10" in message and "zebra.jpg" in message and "coverage.png" in message


def test_a_second_run_changes_nothing_and_needs_no_work_folder(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = change_times(capture)
    report = capture_photos(CaptureRun(photos, capture))
    assert report == json.loads((capture / "capture.json").read_text())
    assert change_times(capture) == before
    shutil.rmtree(capture / "work")
    before = change_times(capture / "images")
    assert capture_photos(CaptureRun(photos, capture)) == report
    assert change_times(capture / "images") == before


@pytest.mark.thorough
def test_a_changed_photo_makes_stages_run_again(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = change_times(capture)
    layered_photo((0.01, 0.02)).save(photos / "photo_3.jpg", quality=95)
    capture_photos(CaptureRun(photos, capture))
    after = change_times(capture)
    changed = {name for name in before if after[name] != before[name]}
    assert {"capture.json", "work/photos/photo_3.jpg", "work/database.db"} <= changed


def test_the_same_photos_give_the_same_points(finished: tuple[Path, Path], tmp_path: Path) -> None:
    workspace = Workspace(finished[1])
    runs = [
        mapping.map_photos(
            workspace.database,
            workspace.photos,
            tmp_path / str(attempt),
            mapper=mapper,
            total=9,
            progress=lambda done, total: None,
        )
        for mapper in ("incremental", "global")
        for attempt in range(2)
    ]
    for one in runs:
        del one["cameras"]  # frontal planes do not determine the focal length exactly
    assert runs[0] == runs[1] and runs[2] == runs[3]


def test_the_other_mapper_is_tried_before_photos_are_given_up(
    finished: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    workspace = Workspace(finished[1])

    def mapped(mapper: mapping.Mapper, enough: int) -> dict:
        return mapping.map_photos(
            workspace.database,
            workspace.photos,
            tmp_path / "models",
            mapper=mapper,
            total=9,
            enough=enough,
            progress=lambda done, total: None,
        )

    monkeypatch.setattr(mapping, "_incremental", lambda *given: {})
    found = mapped("auto", 5)
    assert (found["mapper"], found["tried"]) == ("global", ["incremental", "global"])
    assert len(found["registered"]) == 9
    assert load_pycolmap().Reconstruction(tmp_path / "models" / "best").num_reg_images() == 9
    assert (mapped("incremental", 5)["registered"], mapped("incremental", 5)["tried"]) == (
        [],
        ["incremental"],
    )


def test_a_misplaced_photo_is_dropped(finished: tuple[Path, Path]) -> None:
    workspace = Workspace(finished[1])
    model = load_pycolmap().Reconstruction(workspace.models / "best")
    assert drop_misplaced(model, workspace.database) == []
    moved = next(image for image in model.images.values() if image.name == "photo_3.jpg")
    pose = moved.cam_from_world()
    turn = load_pycolmap().Rotation3d(np.array([0.0, 0.3, 0.0]))
    shifted = load_pycolmap().Rigid3d(turn, np.array([3.0, 1.0, 2.0])) * pose
    moved.frame.set_cam_from_world(moved.camera_id, shifted)
    assert drop_misplaced(model, workspace.database) == ["photo_3.jpg"]
    assert model.num_reg_images() == 8


@pytest.mark.thorough
def test_many_photos_are_matched_by_similarity_and_mapped_globally(
    made: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, in_this_process: None
) -> None:
    """The matches are those of other options, which are forgotten; features are kept."""
    monkeypatch.setattr(matches, "ALL_UP_TO", 8)
    monkeypatch.setattr(mapping, "INCREMENTAL_UP_TO", 8)
    photos, capture = made
    record = json.loads((capture / "work/matches.json").read_text())
    (capture / "work/matches.json").write_text(json.dumps({**record, "key": "another"}))
    (capture / "capture.json").unlink()
    before = change_times(capture)
    report = capture_photos(CaptureRun(photos, capture))
    assert (report["pairs"], report["mapper"], report["registered"]) == ("alike", "global", 9)
    assert change_times(capture)["work/features.json"] == before["work/features.json"]
    assert_centers_are_right(capture)


def test_an_interrupted_capture_is_resumed(
    made: tuple[Path, Path], finished: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was interrupted while photos were matched, and is again while poses are computed."""
    photos, capture = made
    record = json.loads((capture / "work/matches.json").read_text())
    (capture / "work/matches.json").write_text(json.dumps({**record, "done": False}))
    (capture / "work/model.json").unlink()
    (capture / "capture.json").unlink()
    with load_pycolmap().Database.open(capture / "work/database.db") as database:
        kept = database.read_two_view_geometry(1, 2)
        database.delete_matches(3, 4)
        database.delete_two_view_geometry(3, 4)
    call = PycolmapProcess.call

    def interrupted(self: PycolmapProcess, doing: str, *given: Any, **options: Any) -> Any:
        if doing == "computing poses":
            raise KeyboardInterrupt
        return call(self, doing, *given, **options)

    with monkeypatch.context() as patch:
        patch.setattr(PycolmapProcess, "call", interrupted)
        with pytest.raises(KeyboardInterrupt):
            capture_photos(CaptureRun(photos, capture))
    with load_pycolmap().Database.open(capture / "work/database.db") as database:
        assert database.num_verified_image_pairs() == 45
        again = database.read_two_view_geometry(1, 2)
        np.testing.assert_array_equal(again.inlier_matches, kept.inlier_matches)
    before = change_times(capture)
    report = capture_photos(CaptureRun(photos, capture))
    after = change_times(capture)
    for name in ("photos", "features", "matches"):
        assert after[f"work/{name}.json"] == before[f"work/{name}.json"]
    assert dict(report)["key"] == json.loads((finished[1] / "capture.json").read_text())["key"]
    assert_centers_are_right(capture)


def test_photos_are_paired_with_neighbours_and_look_alikes() -> None:
    names = [f"{index:03d}.jpg" for index in range(100)]
    angle = np.arange(100) * (2 * np.pi / 50)  # two rounds of the same path
    looks = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    chosen = set(similar_pairs(names, looks))
    assert all((names[i], names[i + step]) in chosen for i in range(80) for step in (1, 10, 20))
    assert all((names[i], names[i + 50]) in chosen for i in range(50))
    assert all(one < other for one, other in chosen)
    assert len(chosen) < 100 * 99 / 2 * 0.7


def test_photos_with_the_same_features_have_similar_vectors() -> None:
    random = np.random.default_rng(0)
    places = [random.integers(0, 256, (300, 128), dtype=np.uint8) for _ in range(4)]
    none = np.zeros((0, 128), np.uint8)
    photos = [place[random.permutation(300)[:200]] for place in (*places, *places)]
    looks = vlad_vectors([*photos, none])
    similarity = looks @ looks.T
    np.fill_diagonal(similarity, -1)
    assert similarity[:8].argmax(1).tolist() == [4, 5, 6, 7, 0, 1, 2, 3]
    assert vlad_vectors([none, none]).shape == (2, 1)


# --- errors ---------------------------------------------------------------------------------------


def error_of(source: Path, output: Path, **options: object) -> str:
    with pytest.raises(InputError) as caught:
        capture_photos(CaptureRun(source, output, **options))  # type: ignore[arg-type]
    return str(caught.value)


def test_too_few_placed_photos_raise_an_error_with_advice(tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    random = np.random.default_rng(0)
    for index in range(4):  # noise: no two photos match
        noise = random.integers(0, 256, (60, 80, 3), dtype=np.uint8)
        Image.fromarray(noise).resize((160, 120)).save(photos / f"{index}.png")
    message = error_of(photos, tmp_path / "capture")
    assert "only 0 of 4 photos (not for 0.png, 1.png" in message
    assert "overlap" in message and "texture" in message and "\n" not in message
    assert {path.name for path in (tmp_path / "capture").iterdir()} == {"work"}
    assert error_of(photos, tmp_path / "capture") == message


def test_invalid_input_raises_an_error_before_files_are_written(tmp_path: Path) -> None:
    photos, output = write_photos(tmp_path / "photos"), tmp_path / "capture"
    assert "--max-size" in error_of(photos, output, max_size=10)
    assert "--frames must be" in error_of(photos, output, frames=2)
    assert not output.exists()
    foreign = tmp_path / "foreign"
    (foreign / "images").mkdir(parents=True)
    assert "would be overwritten" in error_of(photos, foreign)
    (foreign / "capture.json").write_text('{"app": "of somebody else"}')
    assert "would be overwritten" in error_of(photos, foreign)
    assert sorted(path.name for path in foreign.iterdir()) == ["capture.json", "images"]
    (tmp_path / "notes.txt").write_text("notes")
    assert "is a file" in error_of(photos, tmp_path / "notes.txt")
    assert "--frames needs a video" in error_of(photos, output, frames=9)
    assert json.loads((output / "work/photos.json").read_text())["done"] is False


def test_invalid_photos_are_named(tmp_path: Path) -> None:
    photos, output = write_photos(tmp_path / "photos"), tmp_path / "capture"
    shutil.copy(photos / "photo_1.jpg", photos / "photo_1.jpeg")
    message = error_of(photos, output)
    assert "photo_1.jpeg and photo_1.jpg" in message and "same name" in message
    (photos / "photo_1.jpeg").unlink()
    for index in (4, 5, 6, 7, 8):  # more than those that can be read
        (photos / f"photo_{index}.jpg").write_bytes(b"not a photo")
    assert "photo_4.jpg cannot be read as an image" in error_of(photos, output)
    for index in (0, 1, 2, 3, 4, 5, 6):
        (photos / f"photo_{index}.jpg").unlink()
    assert "holds 2 photos" in error_of(photos, output)


def test_without_pycolmap_the_error_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    photos = write_photos(tmp_path / "photos")
    monkeypatch.setitem(sys.modules, "pycolmap", None)
    for words in (["capture", str(photos)], ["train", str(photos)]):
        assert main([*words, "-o", str(tmp_path / "out")]) == 2
        printed = capsys.readouterr()
        assert "pip install 'mobilegs[capture]'" in printed.err
        assert printed.err.count("\n") == 1 and printed.out == ""
    assert not (tmp_path / "out").exists()
    load_pycolmap.cache_clear()
    with pytest.raises(InputError, match="which is not installed"):
        load_pycolmap()
    load_pycolmap.cache_clear()


def test_doctor_finds_missing_packages_of_a_capture(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor.capture().state == "yes"
    monkeypatch.setattr(doctor, "find_module", lambda name: name != "pi_heif")
    finding = doctor.capture()
    assert finding.state == "no" and "HEIC" in finding.found and "pip install" in finding.remedy
    monkeypatch.undo()

    def broken(name: str) -> None:
        raise ImportError(f"{name} wants libde265.so.0")

    monkeypatch.setattr(doctor.importlib, "import_module", broken)
    finding = doctor.capture()
    assert finding.state == "no" and "does not load: pycolmap wants" in finding.found


# --- mobilegs train -------------------------------------------------------------------------------


def test_train_makes_a_scene_from_photos_without_poses(
    made: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photos, capture = made
    output = tmp_path / "run"
    shutil.copytree(capture, output / "capture")  # as an earlier call left it
    words = ["train", str(photos), "-o", str(output), "--preset", "demo", "--steps", "40"]
    assert main([*words, "--downscale", "2"]) == 0
    assert "9 of 10 photos" in capsys.readouterr().out
    metrics = json.loads((output / "metrics.json").read_text())
    assert metrics["student"]["psnr"] > 10
    assert (output / "scene.mgs").stat().st_size == metrics["student"]["file_bytes"]


def test_train_validates_options_before_computing_poses(
    made: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def forbidden(run: CaptureRun) -> None:
        raise AssertionError(f"{run} was started")

    monkeypatch.setattr(cli_train, "make_capture", forbidden)
    photos, _ = made
    output = tmp_path / "run"
    command = ["train", str(photos), "-o", str(output)]

    def error_of_train(*words: str) -> str:
        assert main([*command, *words]) == 2
        return capsys.readouterr().err

    assert "teacher.nothing" in error_of_train("--set", "teacher.nothing=1")
    output.mkdir()
    (output / "config.json").write_text("{}")
    assert "already holds a run" in error_of_train()
    assert "something else" in error_of_train("--resume")
    (output / "config.json").unlink()
    (output / "teacher.ply").touch()
    assert "would be overwritten" in error_of_train()
    monkeypatch.setenv("WORLD_SIZE", "2")
    assert "mobilegs capture" in error_of_train()
    (tmp_path / "none").mkdir()
    found = unposed.with_poses(train.TrainRun(tmp_path / "none", output), forbidden)
    assert found.capture == tmp_path / "none"


# --- a real capture -------------------------------------------------------------------------------


def test_poses_of_the_fern_are_those_of_its_authors(data_dir: Path, tmp_path: Path) -> None:
    fern, photos = data_dir / "tiny_fern", tmp_path / "photos"
    photos.mkdir()
    for path in sorted((fern / "images").iterdir())[::2]:
        shutil.copy(path, photos)
    report = capture_photos(CaptureRun(photos, tmp_path / "capture"))
    assert (report["registered"], report["photos"]) == (10, 10)
    assert report["reprojection_error"] < 0.9 and report["points"] > 600
    found, truth = centers(tmp_path / "capture"), centers(fern)
    names = sorted(found)
    error = relative_error(
        np.array([found[name] for name in names]), np.array([truth[name] for name in names])
    )
    print(f"camera centres differ by {error:.4f} of their extent, {report['points']} points")
    assert error < 0.02


@pytest.mark.parametrize(
    "name", ["../photo.png", "/photo.png", "a/../../photo.png", "C:\\photo.png"]
)
def test_a_model_names_no_photo_outside(tmp_path: Path, name: str) -> None:
    for folder in ("model", "photos"):
        (tmp_path / folder).mkdir()
    with pytest.raises(InputError, match="outside of its capture"):
        mapping.keep_photos(
            tmp_path / "model", tmp_path / "photos", tmp_path / "masks", tmp_path / "out", [name]
        )
    assert not (tmp_path / "out").exists()
