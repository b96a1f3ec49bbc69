"""Reading COLMAP captures, and the errors for invalid and damaged ones."""

import struct

import numpy as np
import pytest
from PIL import Image

from mobilegs.data import load_capture, load_view
from mobilegs.data.colmap_files import read_cameras, read_images, read_moments, read_points
from mobilegs.data.images import reduced_size
from mobilegs.errors import InputError
from tests.support.colmap_capture import (
    PINHOLE,
    POINTS,
    cameras_bin,
    cameras_txt,
    frames_bin,
    images_bin,
    images_txt,
    points_bin,
    points_txt,
    random_poses,
    write_capture_of_noise,
)


def error_of(path, **options):
    """Return the message with which a capture is rejected."""
    with pytest.raises(InputError) as caught:
        load_capture(path, **options)
    return str(caught.value)


@pytest.mark.parametrize("model", ["sparse/0", "sparse", "colmap/sparse/0"])
def test_the_model_is_found_in_each_usual_folder(tmp_path, model):
    dataset = load_capture(write_capture_of_noise(tmp_path, model=model))
    assert [frame.name for frame in dataset.test] == ["p00.png", "p08.png"]
    assert [frame.name for frame in dataset.train] == [f"p{i:02d}.png" for i in range(1, 8)]


def test_text_and_binary_models_are_read_alike(tmp_path):
    cameras = (PINHOLE, (7, 6, 640, 480, tuple(float(i + 1) for i in range(12))))
    contents = {
        "cameras": (cameras_bin(*cameras), cameras_txt(*cameras)),
        "images": (images_bin(random_poses(5), 3), images_txt(random_poses(5), "1.0 2.0 -1 4 5 6")),
        "points3D": (points_bin(POINTS), points_txt(POINTS)),
    }
    for noun, pair in contents.items():
        for suffix, content in zip(("bin", "txt"), pair, strict=True):
            (tmp_path / f"{noun}.{suffix}").write_bytes(content)
    assert read_cameras(tmp_path / "cameras.bin") == read_cameras(tmp_path / "cameras.txt")
    assert read_images(tmp_path / "images.bin") == read_images(tmp_path / "images.txt")
    binary, text = (read_points(tmp_path / f"points3D.{kind}") for kind in ("bin", "txt"))
    assert len(binary.xyz) == 9
    np.testing.assert_array_equal(binary.xyz, text.xyz)
    np.testing.assert_array_equal(binary.rgb, text.rgb)


def test_pose_and_intrinsics_are_read(tmp_path):
    from scipy.spatial.transform import Rotation

    frame = load_capture(write_capture_of_noise(tmp_path)).train[0]
    _, (w, x, y, z, *translation), _ = random_poses(2)[1]
    rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
    np.testing.assert_allclose(frame.camera.viewmat[:3, :3], rotation, atol=1e-6)
    np.testing.assert_allclose(frame.camera.viewmat[:3, 3], translation, rtol=1e-6)
    assert frame.camera.K.tolist() == [[10, 0, 6], [0, 11, 4], [0, 0, 1]]


def test_extent_and_near_depend_on_training_cameras_only(tmp_path):
    root = write_capture_of_noise(tmp_path)
    eyes = {0: 100.0, 8: 100.0}  # the two test views are far away and must not count
    images = [
        (name, (1.0, 0.0, 0.0, 0.0, -eyes.get(i, 0.1 * i), 0.0, 0.0), 1)
        for i, (name, *_) in enumerate(random_poses(9))
    ]
    (root / "sparse/0/images.bin").write_bytes(images_bin(images))
    dataset = load_capture(root)
    assert dataset.extent == pytest.approx(1.1 * 0.3)
    assert dataset.near == pytest.approx(0.2 * 0.33)
    assert all(f.camera.near == dataset.near for f in [*dataset.train, *dataset.test])


def test_near_plane_txt_sets_the_near_plane(tmp_path):
    path = write_capture_of_noise(tmp_path)
    (path / "near_plane.txt").write_text("0.0125\n")
    dataset = load_capture(path)
    assert dataset.near == 0.0125
    assert all(f.camera.near == 0.0125 for f in [*dataset.train, *dataset.test])
    for text in ("", "near", "0", "nan", "1e30"):
        (path / "near_plane.txt").write_text(text)
        assert "no valid near plane" in error_of(path)


def test_cameras_in_one_place_still_have_a_positive_extent(tmp_path):
    root = write_capture_of_noise(tmp_path)
    images = [(name, (*pose[:4], 0.0, 0.0, 0.0), 1) for name, pose, _ in random_poses(9)]
    (root / "sparse/0/images.bin").write_bytes(images_bin(images))
    assert load_capture(root).extent > 0.5


def test_points_and_colours_are_read(tmp_path):
    dataset = load_capture(write_capture_of_noise(tmp_path))
    assert dataset.points[4].tolist() == [1.0, -1.5, 3.0]
    np.testing.assert_allclose(dataset.colors[4] * 255, [4, 8, 255], atol=1e-4)
    assert load_capture(write_capture_of_noise(tmp_path / "b", points=[])).points.shape == (0, 3)


def test_downscale_averages_boxes_of_pixels(tmp_path):
    root = write_capture_of_noise(tmp_path)
    full = load_view(load_capture(root).train[0])
    half = load_view(load_capture(root, downscale=2).train[0])
    boxes = full.image.reshape(4, 2, 6, 2, 3).mean((1, 3))
    assert half.image.shape == (4, 6, 3)
    assert (half.image - boxes).abs().max() <= 0.51 / 255
    assert half.camera.K.tolist() == [[5, 0, 3], [0, 5.5, 2], [0, 0, 1]]


def test_a_downscale_that_does_not_divide_the_size_averages_fractions_of_pixels(tmp_path):
    root = write_capture_of_noise(tmp_path)
    full = load_view(load_capture(root).train[0])
    third = load_view(load_capture(root, downscale=3).train[0])
    assert third.image.shape == (3, 4, 3)  # 8 / 3 rounds to 3: each pixel covers 8 / 3 rows
    columns = full.image.reshape(8, 4, 3, 3).mean(2)
    middle = (columns[3] + columns[4] + (columns[2] + columns[5]) / 3) / (8 / 3)
    assert (third.image[1] - middle).abs().max() <= 0.51 / 255


def test_grey_photos_of_16_bits_keep_their_brightness(tmp_path):
    root = write_capture_of_noise(tmp_path)
    grey = np.full((8, 12), 100 * 256 + 7, np.uint16)
    Image.fromarray(grey).save(root / "images/p01.png")
    image = load_view(load_capture(root).train[0]).image
    assert (image * 255).round().unique().tolist() == [100]


def test_a_folder_of_downscaled_photos_is_used(tmp_path):
    root = write_capture_of_noise(tmp_path)
    (root / "images_3").mkdir()
    for name, *_ in random_poses(9):
        Image.new("RGB", (4, 3), (10, 20, 30)).save(root / "images_3" / name)
    view = load_view(load_capture(root, downscale=3).train[0])
    assert (view.image[0, 0] * 255).round().tolist() == [10, 20, 30]
    assert (view.camera.width, view.camera.height) == (4, 3)
    assert view.camera.K[1, 1] == pytest.approx(11 * 3 / 8)


@pytest.mark.parametrize(
    ("size", "downscale", "reduced"),
    [
        ((5025, 3312), None, (1600, 1054)),  # flowers as 3DGS shows it
        ((2000, 1), None, (1600, 1)),
        ((5025, 3312), 4, (1256, 828)),
        ((7, 5), 2, (4, 3)),
    ],
)
def test_heights_are_rounded_down_only_without_a_downscale(size, downscale, reduced):
    width, height = size
    assert reduced_size(width, height, downscale) == reduced


def test_wide_photos_are_downscaled_to_1600_pixels_by_default(tmp_path):
    camera = (1, 1, 2000, 10, (900.0, 900.0, 1000.0, 5.0))
    frame = load_capture(write_capture_of_noise(tmp_path, camera=camera, size=(2000, 10))).train[0]
    assert (frame.camera.width, frame.camera.height) == (1600, 8)
    assert frame.camera.K[0, 0] == pytest.approx(720)


def test_intrinsics_of_another_resolution_are_rescaled(tmp_path):
    camera = (1, 1, 36, 24, (30.0, 33.0, 18.0, 12.0))
    frame = load_capture(write_capture_of_noise(tmp_path, camera=camera)).train[0]
    assert frame.camera.K.tolist() == [[10, 0, 6], [0, 11, 4], [0, 0, 1]]


def test_a_photo_of_another_aspect_ratio_raises_an_error(tmp_path):
    camera = (1, 1, 8, 12, (30.0, 33.0, 18.0, 12.0))
    assert "12x8" in error_of(write_capture_of_noise(tmp_path, camera=camera))


def test_masks_in_the_capture_are_used(tmp_path):
    root = write_capture_of_noise(tmp_path)
    (root / "masks").mkdir()
    white = np.full((8, 12), 255, np.uint8)
    white[:, :5] = 0
    Image.fromarray(white).save(root / "masks" / "p01.png")
    view = load_view(load_capture(root).train[0])
    assert view.mask is not None and view.mask.sum(1).tolist() == [7.0] * 8
    # column 2 at half size covers a masked and a used column: it is masked
    half = load_view(load_capture(root, downscale=2).train[0])
    assert half.mask is not None and half.mask[0].tolist() == [0, 0, 0, 1, 1, 1]
    assert load_view(load_capture(root).train[1]).mask is None
    assert load_view(load_capture(root, masks=False).train[0]).mask is None


def test_the_alpha_of_a_photo_is_a_mask(tmp_path):
    root = write_capture_of_noise(tmp_path)
    rgba = np.full((8, 12, 4), 200, np.uint8)
    rgba[:3, :, 3] = 0
    Image.fromarray(rgba).save(root / "images" / "p01.png")
    view = load_view(load_capture(root).train[0])
    assert view.mask is not None and view.mask[:, 0].tolist() == [0, 0, 0, 1, 1, 1, 1, 1]
    assert (view.image * 255).round().unique().tolist() == [200]


def test_exif_rotation_is_ignored(tmp_path):
    root = write_capture_of_noise(tmp_path)
    exif = Image.Exif()
    exif[274] = 6
    Image.open(root / "images" / "p01.png").save(root / "images" / "p01.png", exif=exif)
    assert load_view(load_capture(root).train[0]).image.shape == (8, 12, 3)


def test_errors_name_the_cause(tmp_path):
    root = write_capture_of_noise(tmp_path / "c")
    (root / "sparse/0/images.bin").write_bytes(images_bin([]))
    assert "no registered photo" in error_of(root)
    assert "fewer than two views" in error_of(write_capture_of_noise(tmp_path / "d", views=1))
    root = write_capture_of_noise(tmp_path / "e", camera=(1, 42, 12, 8, (1.0,)))
    assert "unknown lens model '42'" in error_of(root)
    root = write_capture_of_noise(tmp_path / "f", camera=(1, 11, 12, 8, (1.0,) * 16))
    assert "RAD_TAN_THIN" in error_of(root) and "image_undistorter" in error_of(root)
    root = write_capture_of_noise(tmp_path / "g", camera=(2, *PINHOLE[1:]))
    assert "camera 1" in error_of(root)
    root = write_capture_of_noise(tmp_path / "h")
    (root / "images" / "p02.png").write_bytes(b"not a picture")
    assert "p02.png" in error_of(root)
    root = write_capture_of_noise(tmp_path / "i")
    (root / "sparse/0/images.bin").write_bytes(images_bin([*random_poses(3), *random_poses(1)]))
    assert "p00.png" in error_of(root) and "more than once" in error_of(root)
    root = write_capture_of_noise(tmp_path / "j")
    (tmp_path / "secret.png").write_bytes(b"")
    escape = ("../../secret.png", random_poses(1)[0][1], 1)
    (root / "sparse/0/images.bin").write_bytes(images_bin([*random_poses(3), escape]))
    assert "outside" in error_of(root)
    (root / "sparse/0/images.bin").unlink()
    assert "neither images.bin nor images.txt" in error_of(root)


BINARY = {
    "cameras.bin": (read_cameras, cameras_bin(PINHOLE, (2, 4, 9, 9, (5.0,) * 8))),
    "images.bin": (read_images, images_bin(random_poses(3), 2)),
    "frames.bin": (read_moments, frames_bin([[1, 2], [3], [4, 5, 6]])),
    "points3D.bin": (read_points, points_bin(POINTS)),
}


@pytest.mark.parametrize("name", BINARY)
def test_a_binary_file_that_is_cut_off_or_counts_too_much_raises_an_error(tmp_path, name):
    read, content = BINARY[name]
    path = tmp_path / name
    for length in (0, 7, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:length])
        with pytest.raises(InputError, match=name):
            read(path)
    path.write_bytes(struct.pack("<Q", 1 << 60) + content[8:])
    with pytest.raises(InputError, match="byte 0"):
        read(path)
