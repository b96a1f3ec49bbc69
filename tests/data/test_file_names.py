"""Names of photos, masks, points and lens models as other programs and systems write them."""

import json
import shutil
import unicodedata
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.data import file_names as names
from mobilegs.data.colmap_files import lens_model, read_cameras
from mobilegs.train.teacher.init import initial_gaussians
from tests.data.test_nerfstudio import SHARED, capture, edit, error_of, ply
from tests.support.colmap_capture import (
    PINHOLE,
    cameras_bin,
    images_bin,
    images_txt,
    random_poses,
    write_capture_of_noise,
)

VIEWS = 4
# the name that a file lists for photo N, and where photo N is
SPELLINGS = {
    "backslashes": ("cam{}\\p.png", "images/cam{}/p.png"),
    "absolute": ("/home/ann/garden/images/p{}.png", "images/p{}.png"),
    "drive": ("C:\\Users\\Ann\\garden\\images\\left\\p{}.png", "images/left/p{}.png"),
    "case of suffix": ("DJI_{}.JPG", "images/DJI_{}.jpg"),
    "case of name": ("img_{}.png", "images/IMG_{}.png"),
    "composed": (
        "K\u00fcche_{}.png",
        "images/" + unicodedata.normalize("NFD", "K\u00fcche_{}.png"),
    ),
    "folder again": ("images/p{}.png", "images/p{}.png"),
    "dots": ("././a/../p{}.png", "images/p{}.png"),
    "other suffix": ("p{}.jpg", "images/p{}.png"),
    "converted": ("IMG_{}.HEIC", "images/IMG_{}.jpeg"),
    "suffix twice": ("{}.png", "images/{}.png.png"),
    "percent": ("my%20photo%20{}.png", "images/my photo {}.png"),
    "folder dropped": ("walk/{}.png", "images/{}.png"),
    "folder added": ("p{}.png", "images/walk/p{}.png"),
    "up": ("../garden/images/p{}.png", "images/p{}.png"),
    "zip of Windows": ("images/p{}.png", "images\\p{}.png"),
}


def write_photo(path: Path, number: int, size: tuple[int, int] = (12, 8)) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", size, (10 * number, 20, 30)).save(path, "PNG")


def colmap(root: Path, listed: str, stored: str, views: int = VIEWS) -> Path:
    """Write a COLMAP capture that lists photos by other names than they are stored under."""
    write_capture_of_noise(root, views=views)
    shutil.rmtree(root / "images")
    poses = [(listed.format(n), pose, 1) for n, (_, pose, _) in enumerate(random_poses(views))]
    (root / "sparse/0/images.bin").unlink()
    (root / "sparse/0/images.txt").write_bytes(images_txt(poses, "1.0 2.0 -1"))
    for number in range(views):
        write_photo(root / stored.format(number), number)
    return root


def transforms(root: Path, listed: str, stored: str, file: str = "transforms.json") -> Path:
    capture(root, views=VIEWS, file=file, folder="gone")
    shutil.rmtree(root / "gone")

    def rename(meta: dict) -> None:
        for number, frame in enumerate(meta["frames"]):
            frame["file_path"] = listed.format(number)

    for number in range(VIEWS):
        write_photo(root / stored.format(number), number)
    return edit(root, rename, file)


def blender(root: Path, listed: str, stored: str) -> Path:
    return transforms(root, listed, stored, "transforms_train.json")


def numbers_of(dataset: Dataset) -> list[int]:
    """Return the number that each photo shows, in the order of poses 1, 2, ..., then 0."""
    frames = sorted([*dataset.train, *dataset.test], key=lambda frame: frame.name)
    return [round(float(load_view(frame).image[0, 0, 0]) * 25.5) for frame in frames]


@pytest.mark.parametrize("write", [colmap, transforms, blender])
@pytest.mark.parametrize("kind", SPELLINGS)
def test_photos_are_found_under_the_names_of_other_systems(tmp_path, write, kind):
    listed, stored = SPELLINGS[kind]
    root = write(tmp_path / "garden", listed, stored)
    dataset = load_capture(root)
    assert numbers_of(dataset) == list(range(VIEWS))
    for frame in [*dataset.train, *dataset.test]:
        assert frame.image_path is not None and frame.image_path.name.endswith(frame.name[-5:])
        assert not frame.name.startswith(("/", "C:", "."))


@pytest.mark.parametrize("folder", ["input", ".", "sparse/0", "sparse/0/images", "photos/day 1"])
def test_photos_of_a_model_may_be_elsewhere_than_in_images(tmp_path, folder):
    root = colmap(tmp_path, "{}.png", folder + "/{}.png")
    assert numbers_of(load_capture(root)) == list(range(VIEWS))


def test_masks_and_reduced_photos_never_stand_for_photos(tmp_path, caplog):
    for folder in ("masks", "images_2", "depth_maps", "thumbnails"):
        root = colmap(tmp_path / folder, "{}.png", folder + "/{}.png")
        assert "lacks 4 of the 4 photos" in error_of(root)
        assert f"nearest file found is '{folder}/0.png'" in error_of(root)


def test_no_photo_stands_for_two(tmp_path):
    root = colmap(tmp_path, "cam{}/p.png", "images/p.png")
    assert "lacks 4 of the 4" in error_of(root)


def test_a_few_photos_that_are_gone_are_left_out_and_named(tmp_path, caplog):
    for write in (colmap, transforms, blender):
        root = write(tmp_path / write.__name__, "images/p{}.png", "images/p{}.png")
        (root / "images/p2.png").unlink()
        caplog.clear()
        assert numbers_of(load_capture(root)) == [0, 1, 3]
        assert "1 of 4 photos" in caplog.text and "left out: 'images/p2.png'" in caplog.text
        (root / "images/p1.png").rename(root / "images/pp1.png")
        assert "2 of the 4" in error_of(root) and "'images/p1.png'" in error_of(root)
        assert "pp1.png'" in error_of(root)


def test_lists_of_a_split_may_name_photos_that_are_gone(tmp_path):
    root = transforms(tmp_path, "images/p{}.png", "images/p{}.png")
    lists = {"train_filenames": [0, 1, 2], "test_filenames": [3]}
    edit(root, lambda m: m.update({k: [f"images/p{n}.png" for n in v] for k, v in lists.items()}))
    (root / "images/p1.png").unlink()
    assert [frame.name for frame in load_capture(root).train] == ["p0.png", "p2.png"]


# --- outside


@pytest.mark.parametrize("write", [colmap, transforms, blender])
@pytest.mark.parametrize("spelled", ["{}/secret.png", "../../secret.png", "..\\..\\secret.png"])
def test_no_name_leads_out_of_the_capture(tmp_path, write, spelled):
    write_photo(tmp_path / "secret.png", 9)
    root = write(tmp_path / "a/garden", "p{}.png", "images/p{}.png")
    file = root / "sparse/0/images.txt" if write is colmap else next(root.glob("*.json"))
    up = "../" if write is colmap and spelled[0] == "." else ""  # its names begin in images/
    name = json.dumps(up + spelled.format(tmp_path))
    name = json.loads(name) if write is colmap else name[1:-1]
    file.write_text(file.read_text("utf-8").replace("p2.png", name), "utf-8")
    assert "outside" in error_of(root) and "secret.png" in error_of(root)


@pytest.mark.parametrize("key", ["mask_path", "ply_file_path"])
def test_no_mask_and_no_points_are_read_from_outside(tmp_path, key):
    (tmp_path / "secret").write_bytes(ply("ascii"))
    root = transforms(tmp_path / "garden", "images/p{}.png", "images/p{}.png")
    for name in ("../secret", str(tmp_path / "secret"), "images/../../secret"):
        new = {key: name}
        edit(root, lambda m, new=new: (m if key[0] == "p" else m["frames"][0]).update(new))
        assert "is not in" in error_of(root)


def test_links_in_a_capture_are_followed_and_said(tmp_path, caplog):
    for number in range(VIEWS):
        write_photo(tmp_path / f"disk/p{number}.png", number)
    root = transforms(tmp_path / "garden", "/disk/p{}.JPG", "spare/{}.png")
    (root / "images").symlink_to(tmp_path / "disk")
    (tmp_path / "disk/again").symlink_to(tmp_path / "disk")  # a loop
    assert numbers_of(load_capture(root)) == list(range(VIEWS))
    assert f"4 photos of {root} lie outside" in caplog.text and "disk/p0.png" in caplog.text


# --- reduced photos


@pytest.mark.parametrize(
    ("stored", "size", "used"),
    [
        ("images_2/p{}.png", (6, 4), True),
        ("images_2/P{}.JPG", (6, 4), True),
        ("images_2/p{}.png", (7, 5), True),
        ("images_2/p{}.png", (3, 2), False),
        ("images_2/p{}.png", (12, 8), False),
        ("images_2/frame_{}.png", (6, 4), False),
        ("images_2/left/p{}.png", (6, 4), False),
    ],
)
@pytest.mark.parametrize("write", [colmap, transforms])
def test_reduced_photos_are_those_of_the_same_name_and_size(
    tmp_path, caplog, write, stored, size, used
):
    root = write(tmp_path, "images/p{}.png", "images/p{}.png")
    for number in range(VIEWS):
        write_photo(root / stored.format(number), 9 - number, size)
    dataset = load_capture(root, downscale=2)
    assert numbers_of(dataset) == [9 - n if used else n for n in range(VIEWS)]
    assert ("images_2 is not used" in caplog.text) == (not used)


def test_photos_may_be_there_reduced_only(tmp_path):
    root = colmap(tmp_path, "C:\\a\\p{}.png", "images_2/p{}.png")
    for number in range(VIEWS):
        write_photo(root / f"images_2/p{number}.png", number, (6, 4))
    dataset = load_capture(root, downscale=2)
    assert numbers_of(dataset) == list(range(VIEWS))
    assert dataset.test[0].name == "p0.png"


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_exif_turns_a_photo_if_the_model_is_of_the_turned_one(tmp_path, orientation):
    root = colmap(tmp_path, "{}.jpg", "images/{}.jpg")
    exif = Image.Exif()
    exif[274] = orientation
    stored = Image.new("RGB", (8, 12))
    stored.putpixel((0, 0), (255, 255, 255))
    stored.save(root / "images/1.jpg", "PNG", exif=exif)
    image = load_view(load_capture(root).train[0]).image[:, :, 0]
    assert image.shape == (8, 12)
    corner = {5: (0, 0), 6: (0, -1), 7: (-1, -1), 8: (-1, 0)}[orientation]
    assert image[corner] == 1 and image.sum() == 1


# --- points


@pytest.mark.parametrize(
    "file", ["points3D.ply", "points3d.ply", "sparse_pc.ply", "PointCloud.ply"]
)
@pytest.mark.parametrize("write", [transforms, blender])
def test_points_under_a_usual_name_are_read_and_said(tmp_path, caplog, write, file):
    root = write(tmp_path, "p{}.png", "p{}.png")
    (root / file).write_bytes(ply("ascii"))
    assert load_capture(root).points.tolist() == [[1, 2, 3], [-1, 0.5, 0.25]]
    assert file in caplog.text


def test_a_model_may_have_its_points_as_ply_or_none(tmp_path, caplog):
    root = colmap(tmp_path, "{}.png", "images/{}.png")
    (root / "sparse/0/points3D.bin").unlink()
    (root / "sparse/0/points3D.ply").write_bytes(ply("ascii"))
    dataset = load_capture(root)
    assert dataset.points.tolist() == [[1, 2, 3], [-1, 0.5, 0.25]]
    np.testing.assert_allclose(dataset.colors[0] * 255, [255, 0, 51], atol=1e-4)
    (root / "sparse/0/points3D.ply").unlink()
    dataset = load_capture(root)
    random = torch.Generator().manual_seed(0)
    initial_gaussians(dataset, count=20, opacity=0.1, sh_degree=0, generator=random)
    assert len(dataset.points) == 0 and caplog.text.count("starts from random") == 1


# --- models


@pytest.mark.parametrize(
    ("spelled", "name"),
    [
        ("pinhole", "PINHOLE"),
        ("Simple Radial", "SIMPLE_RADIAL"),
        ("CameraModelId.OPENCV_FISHEYE", "OPENCV_FISHEYE"),
        ("opencv-fisheye", "OPENCV_FISHEYE"),
        ("fisheye_opencv", "OPENCV_FISHEYE"),
        ("OpenCVFisheye", "OPENCV_FISHEYE"),
        ("perspective", "PINHOLE"),
        ("frame", "PINHOLE"),
        ("brown", "OPENCV"),
        ("spherical", "EQUIRECTANGULAR"),
        ("1", "PINHOLE"),
        ("FISHEYE624", "FISHEYE624"),
    ],
)
def test_lens_models_are_known_in_any_dialect(tmp_path, spelled, name):
    assert lens_model(spelled) == name
    if name == "PINHOLE":
        (tmp_path / "cameras.txt").write_text(f"1 {spelled.replace(' ', '_')} 12 8 10 11 6 4\n")
        assert read_cameras(tmp_path / "cameras.txt")[1].intrinsics == (10, 11, 6, 4)


@pytest.mark.parametrize(
    ("lens", "refused"),
    [
        ({"camera_model": "PERSPECTIVE"}, None),
        ({"camera_model": "fisheye", "k1": 0.01}, None),
        ({"camera_model": "THIN_PRISM_FISHEYE", "sx1": 0.01}, None),
        ({"camera_model": "full_opencv", "k6": 0.01}, None),
        ({"camera_model": "FISHEYE624"}, "FISHEYE624"),
        ({"camera_model": "ORTHOPHOTO"}, "ORTHOPHOTO"),
        ({"camera_model": 7}, "camera model 7"),
        ({"ftheta_p0": 0.1}, "ftheta_p0"),
        ({"latlong": True}, "latlong"),
    ],
)
def test_lens_models_of_transforms_files_are_read_or_refused(tmp_path, lens, refused):
    root = capture(tmp_path, meta={**SHARED, **lens})
    if refused is None:
        frame = load_capture(root).train[0]
        assert (frame.photo is not None) == (len(lens) > 1 or "fish" in str(lens).lower())
    else:
        assert refused in error_of(root) and "not supported" in error_of(root)


@pytest.mark.parametrize(
    ("file", "content"),
    [
        ("cameras.txt", b"3 FISHEYE624 12 8 1 2 3\n1 PINHOLE 12 8 10 11 6 4\n2 PINHOLE 0 0 1\n"),
        ("cameras.bin", cameras_bin(PINHOLE, (2, 42, 12, 8, (1.0,)))),
        ("cameras.bin", cameras_bin((2, 11, 12, 8, (0.0,) * 16), PINHOLE)),
    ],
)
def test_a_camera_that_no_photo_uses_may_be_anything(tmp_path, file, content):
    root = colmap(tmp_path, "{}.png", "images/{}.png")
    (root / "sparse/0/cameras.bin").unlink()
    (root / "sparse/0" / file).write_bytes(content)
    assert numbers_of(load_capture(root)) == list(range(VIEWS))
    (root / "sparse/0/images.txt").unlink()
    poses = [(f"{n}.png", random_poses(VIEWS)[n][1], 1 + (n == 1)) for n in range(VIEWS)]
    (root / "sparse/0/images.bin").write_bytes(images_bin(poses))
    assert "camera 2" in error_of(root)


@pytest.mark.parametrize(
    "model",
    [
        ".",
        "images",
        "colmap",
        "sparse_text",
        "dense/sparse",
        "dense/0/sparse",
        "distorted/sparse/0",
    ],
)
def test_models_are_found_in_other_usual_places(tmp_path, model):
    root = colmap(tmp_path, "{}.png", "images/{}.png")
    for file in list((root / "sparse/0").iterdir()):
        (root / model).mkdir(parents=True, exist_ok=True)
        shutil.move(file, root / model / file.name)
    shutil.rmtree(root / "sparse")
    assert numbers_of(load_capture(root)) == list(range(VIEWS))


def test_undistorted_photos_belong_to_the_model_beside_them(tmp_path):
    root = colmap(tmp_path, "{}.png", "images/{}.png")
    shutil.move(root / "sparse/0", root / "dense/0/sparse")
    shutil.rmtree(root / "sparse")
    for number in range(VIEWS):
        write_photo(root / f"dense/0/images/{number}.png", 9 - number)
    assert numbers_of(load_capture(root)) == [9, 8, 7, 6]


def test_a_folder_that_is_no_capture_names_the_cause(tmp_path):
    root = colmap(tmp_path / "walks/garden", "{}.png", "images/{}.png")
    assert f"{root} is one" in error_of(tmp_path)
    (root / "sparse/0/cameras.bin").unlink()
    shutil.move(root / "sparse/0/images.txt", root / "images.txt")
    shutil.rmtree(root / "sparse")
    assert "'garden/images.txt'" in error_of(tmp_path / "walks")
    (root / "images.txt").rename(root / "cameras.xml")
    assert "'cameras.xml'" in error_of(root)


def test_a_folder_is_looked_through_once(tmp_path, monkeypatch):
    walks = []
    walk = names.walk_files
    monkeypatch.setattr(names, "walk_files", lambda root: walks.append(root) or walk(root))
    root = colmap(tmp_path, "p{}.jpg", "images/p{}.png", views=40)
    assert len(load_capture(root).train) == 35
    assert len(walks) == 1


@pytest.mark.parametrize(
    "name",
    [
        "\x1b[31mred.png",
        "\0",
        "\ud800",
        "/",
        "..",
        "C:",
        "%00",
        "a/" * 3000,
        "/dev/zero",
        "p\n.png",
    ],
)
def test_hostile_names_are_missing_photos(tmp_path, caplog, name):
    root = transforms(tmp_path, "p{}.png", "p{}.png")
    (root / "C:").touch()
    edit(root, lambda meta: meta["frames"][1].update(file_path=name))
    assert numbers_of(load_capture(root)) == [0, 2, 3]
    assert f"left out: {name!r}"[:100] in caplog.text and "\x1b" not in caplog.text
