"""From photos to a capture: stages, what is kept of them, what is refused."""

import json
import shutil
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.linalg import orthogonal_procrustes

from mobilegs.capture import CaptureRun, capture_photos, mapping, matches, run
from mobilegs.capture.matches import similar_pairs, vlad_vectors
from mobilegs.capture.misplaced_photos import drop_misplaced, epipolar_errors
from mobilegs.capture.pycolmap_runtime import in_background, load_pycolmap
from mobilegs.capture.workspace import Workspace
from mobilegs.cli import doctor
from mobilegs.cli import train as cli_train
from mobilegs.cli.main import main
from mobilegs.data import load_capture
from mobilegs.errors import InputError
from mobilegs.pipeline import train, unposed
from tests.support.layered_photos import CENTERS, layered_photo, write_photos

pytest.importorskip("pycolmap", reason="the extra `capture` is not installed")


def relative_error(found: np.ndarray, truth: np.ndarray) -> float:
    """Largest distance of camera centres after a similarity, relative to their extent."""
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


def written(folder: Path) -> dict[str, int]:
    """When each file in a folder was last written."""
    return {str(p.relative_to(folder)): p.stat().st_mtime_ns for p in sorted(folder.rglob("*"))}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Photos of layers, and the capture made of them."""
    folder = tmp_path_factory.mktemp("layers")
    photos = write_photos(folder / "photos")
    capture_photos(CaptureRun(photos, folder / "capture"))
    return photos, folder / "capture"


@pytest.fixture
def made(finished: tuple[Path, Path], tmp_path: Path) -> tuple[Path, Path]:
    """A copy of them that a test may change."""
    photos, capture = finished
    shutil.copytree(photos, tmp_path / "photos")
    shutil.copytree(capture, tmp_path / "capture")
    return tmp_path / "photos", tmp_path / "capture"


def test_all_photos_are_placed_where_they_were_taken(finished: tuple[Path, Path]) -> None:
    photos, capture = finished
    report = json.loads((capture / "capture.json").read_text())
    assert (report["registered"], report["photos"], report["left_out"]) == (9, 9, [])
    assert (report["pairs"], report["compared"], report["mapper"]) == ("all", 36, "incremental")
    assert 0 < report["reprojection_error"] < 1
    found = centers(capture)
    assert sorted(found) == sorted(path.name for path in photos.iterdir())
    assert relative_error(np.array([found[name] for name in sorted(found)]), CENTERS) < 0.02
    with Image.open(capture / "coverage.png") as picture:
        assert picture.width > 1000
    assert {"images", "sparse", "work", "capture.json", "coverage.png"} == {
        path.name for path in capture.iterdir()
    }


def test_a_second_run_does_nothing_anew(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = written(capture)
    report = capture_photos(CaptureRun(photos, capture))
    assert report == json.loads((capture / "capture.json").read_text())
    assert written(capture) == before


def test_work_may_be_deleted_once_all_is_done(made: tuple[Path, Path]) -> None:
    photos, capture = made
    shutil.rmtree(capture / "work")
    before = written(capture / "images")
    capture_photos(CaptureRun(photos, capture))
    assert written(capture / "images") == before


def test_a_changed_photo_is_noticed(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = written(capture)
    layered_photo((0.01, 0.02)).save(photos / "photo_3.jpg", quality=95)
    capture_photos(CaptureRun(photos, capture))
    after = written(capture)
    changed = {name for name in before if after[name] != before[name]}
    assert {"capture.json", "work/photos/photo_3.jpg", "work/database.db"} <= changed


def test_another_mapper_keeps_features_and_matches(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = written(capture)
    report = capture_photos(CaptureRun(photos, capture, mapper="global"))
    assert (report["mapper"], report["registered"]) == ("global", 9)
    after = written(capture)
    same = ("features", "matches")
    assert all(after[f"work/{name}.json"] == before[f"work/{name}.json"] for name in same)
    assert after["work/model.json"] != before["work/model.json"]
    found = centers(capture)
    assert relative_error(np.array([found[name] for name in sorted(found)]), CENTERS) < 0.02


def test_the_same_photos_give_the_same_points(finished: tuple[Path, Path], tmp_path: Path) -> None:
    space = Workspace(finished[1])
    runs = [
        mapping.map_photos(
            space.database,
            space.photos,
            tmp_path / str(attempt),
            mapper=mapper,
            total=9,
            progress=lambda done, total: None,
        )
        for mapper in ("incremental", "global")
        for attempt in range(2)
    ]
    for one in runs:
        del one["cameras"]  # layers seen straight on leave the focal length to the last digits
    assert runs[0] == runs[1] and runs[2] == runs[3]


def test_a_misplaced_photo_is_dropped(finished: tuple[Path, Path]) -> None:
    space = Workspace(finished[1])
    model = load_pycolmap().Reconstruction(space.models / "best")
    assert drop_misplaced(model, space.database) == []
    moved = next(image for image in model.images.values() if image.name == "photo_3.jpg")
    pose = moved.cam_from_world()
    turn = load_pycolmap().Rotation3d(np.array([0.0, 0.3, 0.0]))
    shifted = load_pycolmap().Rigid3d(turn, np.array([3.0, 1.0, 2.0])) * pose
    moved.frame.set_cam_from_world(moved.camera_id, shifted)
    assert drop_misplaced(model, space.database) == ["photo_3.jpg"]
    assert model.num_reg_images() == 8


def test_matches_lie_on_epipolar_lines() -> None:
    random = np.random.default_rng(0)
    points = random.normal(size=(50, 3)) + np.array([0, 0, 6])
    angle = 0.2
    rotation = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    motion = np.c_[np.array(rotation), [1.0, 0.2, -0.1]]
    seen = points @ motion[:, :3].T + motion[:, 3]
    one, other = points[:, :2] / points[:, 2:], seen[:, :2] / seen[:, 2:]
    assert epipolar_errors(one, other, motion).max() < 1e-12
    off = epipolar_errors(one, other + np.array([0, 0.01]), motion)
    assert 0.005 < np.median(off) <= 0.01  # half of it may be the other point's


def test_many_photos_are_matched_by_likeness_and_mapped_at_once(
    finished: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(matches, "ALL_UP_TO", 8)
    monkeypatch.setattr(mapping, "INCREMENTAL_UP_TO", 8)
    report = capture_photos(CaptureRun(finished[0], tmp_path / "capture"))
    assert (report["pairs"], report["mapper"], report["registered"]) == ("alike", "global", 9)


def test_other_pairs_keep_features(made: tuple[Path, Path]) -> None:
    photos, capture = made
    before = written(capture)
    report = capture_photos(CaptureRun(photos, capture, pairs="alike"))
    assert (report["pairs"], report["registered"]) == ("alike", 9)
    assert written(capture)["work/features.json"] == before["work/features.json"]


def test_an_interrupted_capture_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, finished: tuple[Path, Path]
) -> None:
    photos, whole = finished
    capture = tmp_path / "capture"

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(run, "map_photos", interrupted)
        with pytest.raises(KeyboardInterrupt):
            capture_photos(CaptureRun(photos, capture))
    assert {path.name for path in capture.iterdir()} == {"work"}
    before = written(capture)
    report = capture_photos(CaptureRun(photos, capture))
    after = written(capture)
    for name in ("photos", "features", "matches"):
        assert after[f"work/{name}.json"] == before[f"work/{name}.json"]
    complete = json.loads((whole / "capture.json").read_text())
    for name in ("key", "points", "reprojection_error"):
        assert report[name] == complete[name], name  # as if nothing had happened
    found, expected = centers(capture), centers(whole)
    assert sorted(found) == sorted(expected)
    pairs = [(found[name], expected[name]) for name in sorted(found)]
    assert relative_error(*map(np.array, zip(*pairs, strict=True))) < 1e-3


def test_matching_goes_on_where_it_was_interrupted(made: tuple[Path, Path]) -> None:
    photos, capture = made
    record = json.loads((capture / "work/matches.json").read_text())
    (capture / "work/matches.json").write_text(json.dumps({**record, "done": False}))
    (capture / "capture.json").unlink()
    with load_pycolmap().Database.open(capture / "work/database.db") as database:
        kept = database.read_two_view_geometry(1, 2)
        database.delete_matches(3, 4)
        database.delete_two_view_geometry(3, 4)
    capture_photos(CaptureRun(photos, capture))
    with load_pycolmap().Database.open(capture / "work/database.db") as database:
        assert database.num_verified_image_pairs() == 36
        again = database.read_two_view_geometry(1, 2)
        np.testing.assert_array_equal(again.inlier_matches, kept.inlier_matches)


def test_ctrl_c_cancels_what_runs_in_the_background() -> None:
    tokens = []

    def wait(token: object) -> None:
        tokens.append(token)
        while not token.is_cancelled:  # type: ignore[attr-defined]
            pass

    def interrupt() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        in_background(wait, interrupt)
    assert tokens[0].is_cancelled


def test_what_fails_in_the_background_fails_here() -> None:
    with pytest.raises(InputError, match="no such thing"):
        in_background(lambda token: (_ for _ in ()).throw(InputError("no such thing")))


def test_photos_are_compared_with_their_neighbours_and_with_look_alikes() -> None:
    names = [f"{index:03d}.jpg" for index in range(100)]
    angle = np.arange(100) * (2 * np.pi / 50)  # everything is passed twice
    looks = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    chosen = set(similar_pairs(names, looks))
    assert all((names[i], names[i + step]) in chosen for i in range(80) for step in (1, 10, 20))
    assert all((names[i], names[i + 50]) in chosen for i in range(50))
    assert all(one < other for one, other in chosen)
    assert len(chosen) < 100 * 99 / 2 * 0.7


def test_photos_of_the_same_features_look_alike() -> None:
    random = np.random.default_rng(0)
    places = [random.integers(0, 256, (300, 128), dtype=np.uint8) for _ in range(4)]
    none = np.zeros((0, 128), np.uint8)
    photos = [place[random.permutation(300)[:200]] for place in (*places, *places)]
    looks = vlad_vectors([*photos, none])
    likeness = looks @ looks.T
    np.fill_diagonal(likeness, -1)
    assert likeness[:8].argmax(1).tolist() == [4, 5, 6, 7, 0, 1, 2, 3]
    assert vlad_vectors([none, none]).shape == (2, 1)


# --- refusals -------------------------------------------------------------------------------------


def refusal(source: Path, output: Path, **options: object) -> str:
    with pytest.raises(InputError) as caught:
        capture_photos(CaptureRun(source, output, **options))  # type: ignore[arg-type]
    return str(caught.value)


def test_too_few_placed_photos_stop_with_advice(tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    random = np.random.default_rng(0)
    for index in range(4):  # of nothing that two have in common
        noise = random.integers(0, 256, (60, 80, 3), dtype=np.uint8)
        Image.fromarray(noise).resize((160, 120)).save(photos / f"{index}.png")
    said = refusal(photos, tmp_path / "capture")
    assert "only 0 of 4 photos could be placed (not 0.png, 1.png" in said
    assert "overlap" in said and "texture" in said and "\n" not in said
    assert {path.name for path in (tmp_path / "capture").iterdir()} == {"work"}
    assert refusal(photos, tmp_path / "capture") == said


def test_a_photo_of_something_else_is_left_out_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photos = write_photos(tmp_path / "photos")
    noise = np.random.default_rng(0).integers(0, 256, (60, 80, 3), dtype=np.uint8)
    Image.fromarray(noise).resize((240, 180)).save(photos / "dog.jpg")
    capture = tmp_path / "capture"
    assert main(["capture", str(photos), "-o", str(capture)]) == 0
    printed = capsys.readouterr().out
    assert "9 of 10 photos placed" in printed and "left out: dog.jpg" in printed
    assert len(load_capture(capture).train) == 7
    said = refusal(photos, capture, least=0.95)
    assert "only 9 of 10" in said and "dog.jpg" in said and "coverage.png" in said


def test_input_that_cannot_be_used_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    output = tmp_path / "capture"
    assert "there is nothing at" in refusal(tmp_path / "gone", output)
    (tmp_path / "empty").mkdir()
    assert "has no photos in it" in refusal(tmp_path / "empty", output)
    (tmp_path / "notes.txt").write_text("notes")
    assert "is no video" in refusal(tmp_path / "notes.txt", output)
    photos = write_photos(tmp_path / "photos")
    assert "holds the photos" in refusal(photos, photos)
    assert "pixels show too little" in refusal(photos, output, max_size=10)
    assert "frames make no scene" in refusal(photos, output, frames=2)
    assert "between 0 and 1" in refusal(photos, output, least=50.0)
    assert not output.exists()
    foreign = tmp_path / "foreign"
    (foreign / "images").mkdir(parents=True)
    assert "would be overwritten" in refusal(photos, foreign)
    (foreign / "capture.json").write_text('{"app": "of somebody else"}')
    assert "would be overwritten" in refusal(photos, foreign)
    assert sorted(path.name for path in foreign.iterdir()) == ["capture.json", "images"]
    (tmp_path / "notes.txt").write_text("notes")
    assert "is a file" in refusal(photos, tmp_path / "notes.txt")
    assert "leave out --frames" in refusal(photos, output, frames=9)
    assert json.loads((output / "work/photos.json").read_text())["done"] is False


def test_photos_that_cannot_be_used_are_named(tmp_path: Path) -> None:
    photos, output = write_photos(tmp_path / "photos"), tmp_path / "capture"
    shutil.copy(photos / "photo_1.jpg", photos / "photo_1.jpeg")
    said = refusal(photos, output)
    assert "photo_1.jpeg and photo_1.jpg" in said and "same name" in said
    (photos / "photo_1.jpeg").unlink()
    (photos / "photo_2.jpg").write_bytes((photos / "photo_2.jpg").read_bytes()[:3000])
    (photos / "photo_4.jpg").write_bytes(b"not a photo")
    assert "photo_4.jpg cannot be read as an image" in refusal(photos, output)
    for index in (0, 1, 2, 3, 4, 5, 6):
        (photos / f"photo_{index}.jpg").unlink()
    assert "holds 2 photos: a scene needs 3" in refusal(photos, output)


def test_without_pycolmap_one_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    photos = write_photos(tmp_path / "photos")
    load_pycolmap.cache_clear()
    monkeypatch.setitem(sys.modules, "pycolmap", None)
    for words in (["capture", str(photos)], ["train", str(photos)]):
        assert main([*words, "-o", str(tmp_path / "out")]) == 2
        printed = capsys.readouterr()
        assert "pip install 'mobilegs[capture]'" in printed.err
        assert printed.err.count("\n") == 1 and printed.out == ""
    assert not (tmp_path / "out").exists()
    load_pycolmap.cache_clear()


def test_doctor_says_what_a_capture_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
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


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch) -> list[train.TrainRun]:
    """The runs that would have been trained."""
    runs: list[train.TrainRun] = []

    def remember(run: train.TrainRun) -> dict:
        runs.append(run)
        figures = {"gaussians": 1, "file_bytes": 2, "psnr": 3.0}
        return {"student": figures, "teacher": figures}

    monkeypatch.setattr(train, "train_run", remember)
    return runs


def test_train_makes_a_capture_of_photos_without_poses(
    made: tuple[Path, Path],
    trained: list[train.TrainRun],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    photos, capture = made
    output = tmp_path / "run"
    shutil.copytree(capture, output / "capture")  # as an earlier call left it
    assert main(["train", str(photos), "-o", str(output), "--steps", "9"]) == 0
    assert "9 of 9 photos placed" in capsys.readouterr().out
    assert (trained[0].capture, trained[0].steps) == (output / "capture", 9)
    assert load_capture(trained[0].capture).train


def test_train_goes_the_whole_way_from_photos(
    finished: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    photos, output = finished[0], tmp_path / "run"
    words = ["train", str(photos), "-o", str(output), "--preset", "demo", "--steps", "40"]
    assert main([*words, "--downscale", "2"]) == 0
    assert "9 of 9 photos placed" in capsys.readouterr().out
    metrics = json.loads((output / "metrics.json").read_text())
    assert metrics["student"]["psnr"] > 10
    assert (output / "scene.mgs").stat().st_size == metrics["student"]["file_bytes"]


def test_train_leaves_captures_alone(
    finished: tuple[Path, Path], trained: list[train.TrainRun], tmp_path: Path
) -> None:
    _, capture = finished
    assert main(["train", str(capture), "-o", str(tmp_path / "run")]) == 0
    assert trained[0].capture == capture and not (tmp_path / "run").exists()


def test_train_refuses_before_it_places_photos(
    made: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def forbidden(run: CaptureRun) -> None:
        raise AssertionError(f"{run} was begun")

    monkeypatch.setattr(cli_train, "make_capture", forbidden)
    photos, _ = made
    output = tmp_path / "run"
    train = ["train", str(photos), "-o", str(output)]

    def said(*words: str) -> str:
        assert main([*train, *words]) == 2
        return capsys.readouterr().err

    assert "teacher.nothing" in said("--set", "teacher.nothing=1")
    output.mkdir()
    (output / "config.json").write_text("{}")
    assert "already holds a run" in said()
    assert "something else" in said("--resume")
    assert "--live-at" in said("--resume", "--live-at", "127.0.0.1:9")
    (output / "config.json").unlink()
    assert "no LPIPS weights" in said("--lpips-weights", str(output))
    (output / "teacher.ply").touch()
    assert "would be overwritten" in said()
    monkeypatch.setenv("WORLD_SIZE", "2")
    assert "mobilegs capture" in said()
    assert unposed.with_poses(train.TrainRun(tmp_path, output), forbidden).capture == tmp_path


def test_eval_names_the_verb_that_makes_poses(made: tuple[Path, Path]) -> None:
    with pytest.raises(InputError, match="mobilegs capture"):
        load_capture(made[0])


# --- a real capture -------------------------------------------------------------------------------


def test_the_fern_is_placed_as_its_authors_placed_it(data_dir: Path, tmp_path: Path) -> None:
    fern = data_dir / "tiny_fern"
    shutil.copytree(fern / "images", tmp_path / "photos")
    started = time.process_time()
    report = capture_photos(CaptureRun(tmp_path / "photos", tmp_path / "capture"))
    assert (report["registered"], report["photos"]) == (20, 20)
    assert report["reprojection_error"] < 0.9 and report["points"] > 1200
    found, truth = centers(tmp_path / "capture"), centers(fern)
    error = relative_error(
        np.array([found[name] for name in sorted(found)]),
        np.array([truth[name] for name in sorted(truth)]),
    )
    seconds = time.process_time() - started  # of all threads; others on the machine do not count
    print(f"camera centres differ by {error:.4f} of their extent, {seconds:.0f} s of processors")
    assert error < 0.02
    assert seconds < 120
