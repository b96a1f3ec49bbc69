"""Captures from panoramas, fisheye photos, and photos of several cameras on a rig."""

import json
import logging
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from mobilegs.capture import CaptureRun, capture_photos, mapping
from mobilegs.capture.matches import similar_pairs
from mobilegs.capture.misplaced_photos import drop_misplaced
from mobilegs.capture.photos import prepare_photos, prepared_names, save_faces
from mobilegs.capture.pycolmap_runtime import PycolmapProcess, load_pycolmap
from mobilegs.capture.rigs import set_rig_of_model
from mobilegs.capture.workspace import Workspace
from mobilegs.data import load_capture, load_view
from mobilegs.data.pinhole_views import FACES
from tests.capture.test_run import centers, error_of, relative_error
from tests.support.layered_photos import write_photos
from tests.support.textured_room import (
    fisheye_rays,
    panorama_rays,
    path_poses,
    photo,
    pinhole_rays,
)

pytest.importorskip("pycolmap", reason="needs the extra capture")
MOMENTS = 6
RIG = {  # folder: (place on the rig, rotation from camera to rig)
    "left": (np.array([-0.1, 0, 0]), Rotation.from_euler("y", 0.1).as_matrix()),
    "right": (np.array([0.15, 0.02, 0]), Rotation.from_euler("yx", [-0.2, 0.05]).as_matrix()),
}


@pytest.fixture(scope="module")
def stereo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Photos of two cameras on a rig, and the capture made from them."""
    folder = tmp_path_factory.mktemp("stereo")
    for index, (eye, rotation) in enumerate(path_poses(MOMENTS, turn=0.5)):
        for name, (place, turn) in RIG.items():
            (folder / "photos" / name).mkdir(parents=True, exist_ok=True)
            rays = pinhole_rays(240, 160, 180.0)
            picture = photo(eye + rotation @ place, rotation @ turn, rays)
            picture.save(folder / f"photos/{name}/m{index}.jpg", quality=95)
    capture_photos(CaptureRun(folder / "photos", folder / "capture", rig=True))
    return folder / "photos", folder / "capture"


# --- panoramas ------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_poses_of_panoramas_are_right_and_the_same_every_time(tmp_path: Path) -> None:
    photos, capture = tmp_path / "photos", tmp_path / "capture"
    photos.mkdir()
    for index, (eye, rotation) in enumerate(path_poses(4)):
        picture = photo(eye, rotation, panorama_rays(640))
        picture.save(photos / f"p{index}.jpg", quality=95)
    report = capture_photos(CaptureRun(photos, capture, lens="panorama"))
    assert (report["photos"], report["registered"], report["left_out"]) == (4, 4, [])
    assert report["rig"] is True and report["models"] == [4]
    assert report["compared"] == 4 * 3 // 2 * 36  # no pair of faces of one panorama
    assert {(c["model"], *c["params"]) for c in report["cameras"]} == {
        ("PINHOLE", 80.0, 80.0, 80.0, 80.0)
    }
    found = centers(capture)
    assert len(found) == 24
    truth = np.array([eye for eye, _ in path_poses(4)])
    front = np.array([found[f"front/p{index}.jpg"] for index in range(4)])
    assert relative_error(front, truth) < 0.01
    for face in FACES:
        same = np.array([found[f"{face}/p{index}.jpg"] for index in range(4)])
        np.testing.assert_allclose(same, front, atol=1e-4)
    held = sorted(frame.name for frame in load_capture(capture).test)
    assert held == sorted(f"{face}/p0.jpg" for face in FACES)
    workspace = Workspace(capture)
    again = mapping.map_photos(
        workspace.database,
        workspace.photos,
        tmp_path / "again",
        mapper="incremental",
        total=4,
        progress=lambda done, total: None,
        rig="faces",
    )
    assert again["points"] == report["points"] and len(again["registered"]) == 24


def test_faces_show_the_panorama(tmp_path: Path) -> None:
    eye, rotation = path_poses(2)[1]
    picture = photo(eye, rotation, panorama_rays(512))
    found = save_faces(picture, tmp_path, "p.png", source=Path("p.jpg"), max_size=1000)
    assert [(f.name, f.width, f.focal) for f in found] == [
        (f"{face}/p.png", 128, 64.0) for face in FACES
    ]
    for face, turn in FACES.items():
        expected = photo(eye, rotation @ np.array(turn), pinhole_rays(128, 128, 64.0))
        with Image.open(tmp_path / face / "p.png") as seen:
            errors = np.abs(np.asarray(seen, float) - np.asarray(expected, float))
        assert np.median(errors) < 8 and errors.mean() < 16, face


def test_only_panoramas_of_the_whole_sphere_are_taken(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    message = error_of(photos, tmp_path / "capture", lens="panorama")
    assert "photo_0.jpg is 240x180 pixels" in message and "whole sphere" in message
    assert "leave out --rig" in error_of(photos, tmp_path / "b", lens="panorama", rig=True)


def test_panoramas_that_say_so_need_the_option(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    words = b'<x:xmpmeta><rdf:Description GPano:ProjectionType="equirectangular"/></x:xmpmeta>'
    with Image.open(photos / "photo_2.jpg") as picture:
        picture.save(photos / "photo_2.jpg", xmp=words)
    message = error_of(photos, tmp_path / "capture")
    assert message.startswith("photo_2.jpg in")
    assert "is a panorama by its metadata: add --lens panorama" in message


# --- fisheye --------------------------------------------------------------------------------------


@pytest.mark.thorough
def test_poses_of_fisheye_photos_are_right(tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    poses = path_poses(6, turn=0.5)
    for index, (eye, rotation) in enumerate(poses):
        picture = photo(eye, rotation, fisheye_rays(300, 220, 100.0))
        picture.save(tmp_path / f"photos/f{index}.jpg", quality=95)
    capture = tmp_path / "capture"
    report = capture_photos(CaptureRun(tmp_path / "photos", capture, lens="fisheye"))
    assert (report["registered"], report["left_out"]) == (6, [])
    (camera,) = report["cameras"]
    assert camera["model"] == "OPENCV_FISHEYE"
    assert camera["params"][0] == pytest.approx(100, rel=0.02)  # guessed: 135
    found = centers(capture)
    truth = np.array([eye for eye, _ in poses])
    assert relative_error(np.array([found[f"f{i}.jpg"] for i in range(6)]), truth) < 0.01
    assert {"images", "sparse"} < {path.name for path in capture.iterdir()}
    kept = (capture / "images/f2.jpg").read_bytes()  # as it is; training undistorts it
    assert kept == (tmp_path / "photos/f2.jpg").read_bytes()
    frame = load_capture(capture).train[1]
    K = frame.camera.K.double().numpy()
    rays = pinhole_rays(frame.camera.width, frame.camera.height, K[0, 0])
    rays[..., :2] += (np.array([frame.camera.width, frame.camera.height]) / 2 - K[:2, 2]) / K[0, 0]
    expected = np.asarray(photo(*poses[2], rays), float)
    errors = np.abs(255 * load_view(frame).image.numpy() - expected)
    assert frame.name == "f2.jpg" and np.median(errors) < 10


# --- rigs -----------------------------------------------------------------------------------------


def test_poses_of_a_rig_are_right(stereo: tuple[Path, Path]) -> None:
    _, capture = stereo
    report = json.loads((capture / "capture.json").read_text())
    assert (report["photos"], report["registered"], report["rig"]) == (12, 12, True)
    assert [camera["photos"] for camera in report["cameras"]] == [6, 6]  # one for each folder
    truth = {
        f"{name}/m{index}.jpg": eye + rotation @ place
        for index, (eye, rotation) in enumerate(path_poses(MOMENTS, turn=0.5))
        for name, (place, _) in RIG.items()
    }
    found = centers(capture)
    assert sorted(found) == sorted(truth)
    error = relative_error(*(np.array([c[name] for name in sorted(truth)]) for c in (found, truth)))
    assert error < 0.03
    dataset = load_capture(capture)
    assert [frame.name for frame in dataset.test] == ["left/m0.jpg", "right/m0.jpg"]
    model = load_pycolmap().Reconstruction(capture / "sparse/0")
    assert (model.num_rigs(), model.num_frames()) == (1, MOMENTS)


def test_photos_of_one_moment_are_dropped_together(stereo: tuple[Path, Path]) -> None:
    workspace = Workspace(stereo[1])
    model = load_pycolmap().Reconstruction(workspace.models / "best")
    assert drop_misplaced(model, workspace.database) == []
    frame = next(image.frame for image in model.images.values() if image.name == "left/m3.jpg")
    turn = load_pycolmap().Rotation3d(np.array([0.0, 0.3, 0.0]))
    shift = load_pycolmap().Rigid3d(turn, np.array([3.0, 1.0, 2.0]))
    frame.rig_from_world = shift * frame.rig_from_world
    assert drop_misplaced(model, workspace.database) == ["left/m3.jpg", "right/m3.jpg"]


def test_a_rig_that_cannot_be_measured_is_said(
    stereo: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    photos, capture = stereo
    shutil.copytree(capture, tmp_path / "capture")
    monkeypatch.setattr(mapping, "set_rig_of_model", lambda database, model: False)
    monkeypatch.setattr(
        PycolmapProcess,
        "call",
        lambda self, doing, function, *given, **options: function(*given, **options),
    )
    with caplog.at_level(logging.WARNING):
        run = CaptureRun(photos, tmp_path / "capture", rig=True, mapper="incremental")
        report = capture_photos(run)
    assert report["rig"] is False and report["registered"] == 12
    assert "placed one by one" in caplog.text


def test_cameras_that_never_fired_together_are_no_rig(
    stereo: tuple[Path, Path], tmp_path: Path
) -> None:
    workspace = Workspace(stereo[1])
    shutil.copyfile(workspace.database, tmp_path / "database.db")
    model = load_pycolmap().Reconstruction(workspace.models / "incremental" / "0")
    for image in list(model.images.values()):
        if image.name.startswith("right") == (int(image.name[-5]) % 2 == 0):
            model.deregister_frame(image.frame_id)
    assert not set_rig_of_model(tmp_path / "database.db", model)


def test_a_rig_needs_folders_with_the_same_names(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    message = error_of(photos, tmp_path / "capture", rig=True)
    assert "--rig needs a folder of photos for each camera" in message and "has one" in message
    for name in ("left", "right"):
        shutil.copytree(photos, tmp_path / "rig" / name)
    for path in (tmp_path / "rig/right").iterdir():
        path.rename(path.with_name(f"other_{path.name}"))
    message = error_of(tmp_path / "rig", tmp_path / "capture", rig=True)
    assert "fewer than 3 names in the folder left of" in message


def test_photos_of_a_rig_keep_their_folders(tmp_path: Path) -> None:
    for place in ("a/left cam", "a/right"):
        write_photos(tmp_path / "photos" / place)
    sources = sorted((tmp_path / "photos").rglob("*.jpg"))
    names = prepared_names(sources, rig=True)
    assert list(names.values())[::9] == ["left_cam/photo_0.jpg", "right/photo_0.jpg"]
    found = prepare_photos(
        sources, tmp_path / "out", max_size=100, progress=lambda done, total: None, rig=True
    )
    assert [photo["name"] for photo in found["photos"]] == list(names.values())
    assert found["photos"][0]["source"] == "left cam/photo_0.jpg"
    assert all((tmp_path / "out" / name).is_file() for name in names.values())


def test_photos_of_a_rig_are_paired_by_camera_and_moment() -> None:
    names = [f"{camera}/{index:03d}.jpg" for camera in ("left", "right") for index in range(60)]
    looks = np.eye(120)  # no two photos look alike: ties are the first ones by name
    chosen = set(similar_pairs(names, looks))
    assert all((f"left/{i:03d}.jpg", f"right/{i:03d}.jpg") in chosen for i in range(60))
    for camera in ("left", "right"):
        pairs = [(f"{camera}/{i:03d}.jpg", f"{camera}/{i + 10:03d}.jpg") for i in range(50)]
        assert set(pairs) <= chosen
    assert ("left/055.jpg", "right/001.jpg") not in chosen  # no neighbours across cameras
