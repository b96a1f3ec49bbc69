"""Fisheye photos, panoramas and rigs: the views that stand for them, and the held-back ones."""

import json
import logging
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image
from scipy.spatial.transform import Rotation

from mobilegs.data import load_capture, load_view
from mobilegs.data.colmap_files import read_cameras, read_images, read_moments
from mobilegs.data.distortion import LensPhoto
from mobilegs.data.pinhole_views import FACES, fields_of_view
from mobilegs.errors import InputError
from tests.support.colmap_capture import (
    cameras_bin,
    frames_bin,
    frames_txt,
    images_bin,
    write_capture_of_noise,
)

FISHEYE = (100.0, 104.0, 102.0, 78.0, 0.02, -0.01, 0.003, -0.0005)  # 200 x 150 pixels
MODELS = {  # name: (id, parameters)
    "SIMPLE_RADIAL": (2, (500.0, 320.0, 240.0, -0.1)),
    "RADIAL": (3, (500.0, 320.0, 240.0, -0.1, 0.02)),
    "OPENCV": (4, (500.0, 510.0, 320.0, 240.0, -0.1, 0.02, 0.003, -0.002)),
    "FULL_OPENCV": (
        6,
        (500.0, 510.0, 320.0, 240.0, -0.1, 0.02, 0.003, -0.002, 0.001, 0.02, 0.01, 0.002),
    ),
    "OPENCV_FISHEYE": (5, (300.0, 310.0, 320.0, 240.0, 0.02, -0.01, 0.003, -0.0005)),
    "SIMPLE_RADIAL_FISHEYE": (8, (300.0, 320.0, 240.0, 0.02)),
    "RADIAL_FISHEYE": (9, (300.0, 320.0, 240.0, 0.02, -0.003)),
    "THIN_PRISM_FISHEYE": (
        10,
        (300.0, 310.0, 320.0, 240.0, 0.02, -0.01, 0.003, -0.002, 0.001, -0.0005, 0.004, -0.003),
    ),
    "FOV": (7, (400.0, 410.0, 320.0, 240.0, 0.9)),
    "SIMPLE_FISHEYE": (14, (300.0, 320.0, 240.0)),
    "FISHEYE": (15, (300.0, 310.0, 320.0, 240.0)),
    "EQUIRECTANGULAR": (17, (640.0, 480.0)),
}


def color_of(directions: np.ndarray) -> np.ndarray:
    """Return a colour in 0..255 for each world direction; no two directions share it."""
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    return 127.5 + 100 * np.sin(unit @ Rotation.from_euler("xyz", [0.4, 1.0, -0.7]).as_matrix().T)


def directions_of(camera) -> np.ndarray:
    """Return the world direction of each pixel of a pinhole camera."""
    K, rotation = camera.K.double().numpy(), camera.viewmat[:3, :3].double().numpy()
    column, row = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    ideal = [(column - K[0, 2]) / K[0, 0], (row - K[1, 2]) / K[1, 1], np.ones_like(row)]
    return np.stack(ideal, axis=-1) @ rotation


def write_panorama(path: Path, to_world: np.ndarray, width: int, height: int) -> None:
    """Paint a panorama by world directions, as nerfstudio defines it (axes of OpenGL)."""
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    theta = -2 * math.pi * (column / width - 0.5)
    phi = math.pi * row / height
    local = [-np.sin(theta) * np.sin(phi), np.cos(phi), -np.cos(theta) * np.sin(phi)]
    colors = color_of(np.stack(local, axis=-1) @ to_world.T)
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(colors.round().astype(np.uint8)).save(path)


def panoramas(root: Path, count: int, *, size=(512, 256), **meta) -> Path:
    frames = []
    for index in range(count):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_euler("xyz", [index, 2 * index + 1, 0.5]).as_matrix()
        pose[:3, 3] = (index, 0.2 * index, 0)
        write_panorama(root / f"images/p{index:02d}.png", pose[:3, :3], *size)
        frames.append({"file_path": f"images/p{index:02d}.png", "transform_matrix": pose.tolist()})
    text = json.dumps({"camera_model": "EQUIRECTANGULAR", "frames": frames, **meta})
    (root / "transforms.json").write_text(text)
    return root


@pytest.mark.parametrize("name", MODELS)
def test_lenses_project_as_those_of_colmap(tmp_path: Path, name: str) -> None:
    pycolmap = pytest.importorskip("pycolmap", reason="needs the extra capture")
    number, parameters = MODELS[name]
    height = 320 if name == "EQUIRECTANGULAR" else 480
    parameters = (640.0, 320.0) if name == "EQUIRECTANGULAR" else parameters
    (tmp_path / "cameras.bin").write_bytes(cameras_bin((1, number, 640, height, parameters)))
    lens = read_cameras(tmp_path / "cameras.bin")[1]
    random = np.random.default_rng(0)
    angle, around = random.uniform(0, 1.2, 500), random.uniform(0, 2 * np.pi, 500)
    rays = np.stack(
        [np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)], axis=1
    )
    if name == "EQUIRECTANGULAR":
        rays = random.normal(size=(500, 3))
    rays[0] = (0, 0, 1)
    theirs = pycolmap.Camera(
        camera_id=1, model=name, width=640, height=height, params=list(parameters)
    ).img_from_cam(rays)
    photo = LensPhoto(640, height, lens.intrinsics, lens.distortion)
    ours = torch.stack(photo.pixels_of(*torch.from_numpy(rays).unbind(-1))[:2], dim=1)
    np.testing.assert_allclose(ours.numpy(), theirs, atol=1e-8)


# --- fisheye --------------------------------------------------------------------------------------


def write_fisheye(root: Path, size=(200, 150)) -> Path:
    """Write a COLMAP capture of fisheye photos that are painted by world directions."""
    write_capture_of_noise(root, camera=(1, 5, *size, FISHEYE), size=size)
    lens = read_cameras(root / "sparse/0/cameras.bin")[1]
    fx, fy, cx, cy = lens.intrinsics
    column, row = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    x, y = (column - cx) / fx, (row - cy) / fy
    angle = seen = np.hypot(x, y)
    for _ in range(50):  # the angle that the lens moves to the radius `seen`
        angle = seen / lens.distortion.radial(torch.from_numpy(angle * angle)).numpy()
    rays = np.stack([x / seen * np.sin(angle), y / seen * np.sin(angle), np.cos(angle)], axis=-1)
    for image in read_images(root / "sparse/0/images.bin"):
        w, *xyz = image.quat
        rotation = Rotation.from_quat([*xyz, w]).as_matrix()
        colors = color_of(rays @ rotation).round().astype(np.uint8)
        Image.fromarray(colors).save(root / "images" / image.name)
    return root


def test_a_fisheye_photo_becomes_a_pinhole_view_of_100_degrees(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_fisheye(tmp_path)
    with caplog.at_level(logging.WARNING):
        frames = load_capture(root).train
    assert "9 fisheye photos become pinhole views of up to 100 x 82 degrees" in caplog.text
    camera = frames[0].camera
    assert camera.K[0, 0] == 100 and camera.K[1, 1] == 104
    across, down = fields_of_view(camera)
    assert across == pytest.approx(100, abs=0.3) and down == pytest.approx(82.0, abs=0.6)
    for frame in frames:
        view = load_view(frame)
        error = np.abs(255 * view.image.numpy() - color_of(directions_of(frame.camera)))
        seen = np.ones(error.shape[:2]) if view.mask is None else view.mask.numpy()
        assert seen.mean() > 0.9 and seen[50, 100] == 1
        inner = seen.astype(bool)
        inner[:2] = inner[-2:] = inner[:, :2] = inner[:, -2:] = False
        assert error[inner].max() < 2.5


def test_masks_and_downscale_of_fisheye_photos(tmp_path: Path) -> None:
    root = write_fisheye(tmp_path)
    (root / "masks").mkdir()
    white = np.full((150, 200), 255, np.uint8)
    white[:, :90] = 0
    Image.fromarray(white).save(root / "masks/p01.png")
    full = load_view(load_capture(root).train[0])
    assert full.mask is not None
    left = int(full.camera.K[0, 2])
    assert not full.mask[60, : left - 20].any() and full.mask[60, left:].all()
    half = load_view(load_capture(root, downscale=2).train[0])
    assert half.camera.K[0, 0] == 50
    assert abs(half.camera.width - full.camera.width / 2) <= 1
    error = np.abs(255 * half.image.numpy() - color_of(directions_of(half.camera)))
    assert half.mask is not None and error[half.mask.numpy() > 0].max() < 4


def test_a_fisheye_of_nerfstudio_is_that_of_colmap(tmp_path: Path) -> None:
    fx, fy, cx, cy, k1, k2, k3, k4 = FISHEYE
    theirs = load_capture(write_fisheye(tmp_path / "colmap")).train[0]
    shared = {"fl_x": fx, "fl_y": fy, "cx": cx, "cy": cy, "k1": k1, "k2": k2, "k3": k3, "k4": k4}
    pose = np.linalg.inv(theirs.camera.viewmat.double().numpy())
    pose[:3, 1:3] *= -1
    for word in ({"camera_model": "OPENCV_FISHEYE"}, {"is_fisheye": True}):
        frames = [
            {"file_path": f"colmap/images/p{i:02d}.png", "transform_matrix": pose.tolist()}
            for i in range(9)
        ]
        text = json.dumps({**shared, **word, "frames": frames})
        (tmp_path / "transforms.json").write_text(text)
        ours = load_capture(tmp_path).train[0]
        assert ours.photo == theirs.photo
        torch.testing.assert_close(ours.camera.viewmat, theirs.camera.viewmat, atol=1e-5, rtol=0)
        assert torch.equal(ours.camera.K, theirs.camera.K)


def test_lenses_that_show_nothing_are_refused(tmp_path: Path) -> None:
    def message(folder: str, model: int, parameters: tuple[float, ...]) -> str:
        camera = (1, model, 200, 150, parameters)
        root = write_capture_of_noise(tmp_path / folder, camera=camera, size=(200, 150))
        with pytest.raises(InputError) as caught:
            load_capture(root)
        return str(caught.value)

    beside = (100.0, 100.0, 500.0, 75.0, 0.0, 0.0, 0.0, 0.0)  # the axis is outside of the photo
    assert "leaves no view" in message("a", 5, beside)
    assert "leaves no view" in message("b", 5, (*FISHEYE[:4], -1e9, 0.0, 0.0, 0.0))
    assert "leaves no view" in message("c", 5, (1e12, 1e12, 100.0, 75.0, *[0.0] * 4))
    assert "field of view" in message("d", 7, (100.0, 100.0, 100.0, 75.0, 3.5))
    assert "EUCM" in message("e", 16, (1.0,) * 6)


# --- panoramas ------------------------------------------------------------------------------------


def test_a_panorama_becomes_the_faces_of_a_cube(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = panoramas(tmp_path, 3, fl_x=1.0)  # a focal length means nothing here
    with caplog.at_level(logging.WARNING):
        dataset = load_capture(root)
    assert "3 panoramas become six pinhole views each" in caplog.text
    assert [frame.name for frame in dataset.test] == sorted(f"p00_{face}.png" for face in FACES)
    assert len(dataset.train) == 12
    for frame in [*dataset.train, *dataset.test]:
        camera = frame.camera
        assert (camera.width, camera.height) == (128, 128)
        assert camera.K.tolist() == [[64, 0, 64], [0, 64, 64], [0, 0, 1]]
        assert camera.position.tolist() == pytest.approx(
            [int(frame.name[2]), 0.2 * int(frame.name[2]), 0], abs=1e-5
        )
        view = load_view(frame)
        assert view.mask is None
        error = np.abs(255 * view.image.numpy() - color_of(directions_of(camera)))
        assert error.max() < 3, frame.name
    looks = torch.stack([frame.camera.viewmat[2, :3] for frame in dataset.test])
    assert torch.allclose(looks.sum(0), torch.zeros(3), atol=1e-6)  # in six directions


def test_faces_of_a_panorama_are_held_back_together(tmp_path: Path) -> None:
    dataset = load_capture(panoramas(tmp_path, 17, size=(32, 16)))
    held = sorted({frame.name[:3] for frame in dataset.test})
    assert held == ["p00", "p08", "p16"] and len(dataset.test) == 18
    assert not {frame.name[:3] for frame in dataset.train} & set(held)


def test_lists_of_file_names_name_panoramas(tmp_path: Path) -> None:
    names = {"train_filenames": ["images/p00.png"], "test_filenames": ["images/p01.png"]}
    dataset = load_capture(panoramas(tmp_path, 2, size=(32, 16), **names))
    assert {frame.name[:3] for frame in dataset.train} == {"p00"}
    assert {frame.name[:3] for frame in dataset.test} == {"p01"} and len(dataset.test) == 6


def test_a_panorama_of_colmap_is_that_of_nerfstudio(tmp_path: Path) -> None:
    theirs = load_capture(panoramas(tmp_path / "a", 9, size=(64, 32)))
    root = write_capture_of_noise(tmp_path / "b", camera=(1, 17, 64, 32, (64.0, 32.0)))
    poses = []
    for index in range(9):
        frames = {frame.name: frame for frame in [*theirs.train, *theirs.test]}
        viewmat = frames[f"p{index:02d}_front.png"].camera.viewmat.double().numpy()
        x, y, z, w = Rotation.from_matrix(viewmat[:3, :3]).as_quat()
        poses.append((f"p{index:02d}.png", (w, x, y, z, *viewmat[:3, 3]), 1))
        (root / f"images/p{index:02d}.png").write_bytes(
            (tmp_path / f"a/images/p{index:02d}.png").read_bytes()
        )
    (root / "sparse/0/images.bin").write_bytes(images_bin(poses))
    ours = load_capture(root)
    assert [f.name for f in ours.train] == [f.name for f in theirs.train]
    for one, other in zip(ours.train, theirs.train, strict=True):
        torch.testing.assert_close(one.camera.viewmat, other.camera.viewmat, atol=1e-5, rtol=0)
        assert torch.equal(load_view(one).image, load_view(other).image)


def test_large_panoramas_are_downscaled(tmp_path: Path) -> None:
    root = panoramas(tmp_path, 2, size=(512, 256))
    third = load_capture(root, downscale=3).train[0]
    assert (third.camera.width, third.camera.K[0, 0]) == (43, 21.5)
    assert third.photo is not None and (third.photo.width, third.photo.height) == (170, 85)
    error = np.abs(255 * load_view(third).image.numpy() - color_of(directions_of(third.camera)))
    assert error.max() < 5


def test_masks_of_panoramas_are_those_of_their_faces(tmp_path: Path) -> None:
    root = panoramas(tmp_path, 2, size=(64, 32))
    white = np.full((32, 64), 255, np.uint8)
    white[22:] = 0  # the tripod
    Image.fromarray(white).save(root / "mask.png")
    meta = json.loads((root / "transforms.json").read_text())
    for frame in meta["frames"]:
        frame["mask_path"] = "mask.png"
    (root / "transforms.json").write_text(json.dumps(meta))
    masks = {frame.name[4:-4]: load_view(frame).mask for frame in load_capture(root).train}
    assert masks["up"] is None
    assert masks["down"] is not None and masks["down"].sum() == 0
    assert masks["front"] is not None and masks["front"][:10].all()


def test_a_part_of_a_panorama_is_refused(tmp_path: Path) -> None:
    root = panoramas(tmp_path, 2, size=(90, 30))
    with pytest.raises(InputError, match=r"p00\.png is 90x30 pixels.*whole sphere"):
        load_capture(root)
    camera = (1, 17, 12, 8, (24.0, 12.0))
    with pytest.raises(InputError, match="of another size"):
        load_capture(write_capture_of_noise(tmp_path / "b", camera=camera))


# --- rigs -----------------------------------------------------------------------------------------


def test_photos_that_a_rig_took_at_one_moment_are_held_back_together(tmp_path: Path) -> None:
    root = write_capture_of_noise(tmp_path, views=20)
    alone = [[i] for i in range(20)]
    pairs = [[i, i + 10] for i in range(10)]
    for moments, held in ((alone, [0, 8, 16]), (pairs, [0, 8, 10, 18]), (None, [0, 8, 16])):
        for suffix, content in ((".bin", frames_bin), (".txt", frames_txt)):
            file = root / f"sparse/0/frames{suffix}"
            if moments is not None:
                file.write_bytes(content(moments))
            dataset = load_capture(root)
            assert [frame.name for frame in dataset.test] == [f"p{i:02d}.png" for i in held]
            assert len(dataset.train) + len(dataset.test) == 20
            file.unlink(missing_ok=True)


def test_frames_of_other_sensors_are_no_photos_and_damaged_lines_raise_an_error(
    tmp_path: Path,
) -> None:
    text = frames_txt([[1, 2], [3, 4]]).replace(b"CAMERA 1 2", b"IMU 1 2")
    (tmp_path / "frames.txt").write_bytes(text)
    assert read_moments(tmp_path / "frames.txt") == [[1], [3, 4]]
    for text in (b"1 1 1 0 0 0 0 0 0 2 CAMERA 1 5", b"1 1", b"1 1 1 0 0 0 0 0 0 1 CAMERA 1 x"):
        (tmp_path / "frames.txt").write_bytes(text)
        with pytest.raises(InputError, match=r"frames\.txt, line 1"):
            read_moments(tmp_path / "frames.txt")


def test_models_with_rigs_of_colmap_are_read_right(tmp_path: Path) -> None:
    pycolmap = pytest.importorskip("pycolmap", reason="needs the extra capture")
    model = pycolmap.synthesize_dataset(
        pycolmap.SyntheticDatasetOptions(
            num_rigs=2, num_cameras_per_rig=3, num_frames_per_rig=4, num_points3D=20
        )
    )
    (tmp_path / "images").mkdir()
    for image in model.images.values():
        Image.new("RGB", (1024, 768)).save(tmp_path / "images" / image.name)
    poses = {image.name: image.cam_from_world().matrix() for image in model.images.values()}
    for write in (model.write_binary, model.write_text):
        folder = tmp_path / "sparse/0"
        folder.mkdir(parents=True, exist_ok=True)
        for file in folder.iterdir():
            file.unlink()
        write(folder)
        assert {file.stem for file in folder.iterdir()} >= {"rigs", "frames", "images", "cameras"}
        dataset = load_capture(tmp_path)
        frames = [*dataset.train, *dataset.test]
        assert sorted(frame.name for frame in frames) == sorted(poses)
        for frame in frames:
            np.testing.assert_allclose(
                frame.camera.viewmat[:3].numpy(), poses[frame.name], atol=1e-5
            )
        numbers = {image.name: image.frame_id for image in model.images.values()}
        held = {numbers[frame.name] for frame in dataset.test}
        assert len(held) == 1 and len(dataset.test) == 3
