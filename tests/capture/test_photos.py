"""Preparing photos: orientation, HEIC, focal lengths, shared cameras."""

import math
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.capture.features import import_cameras
from mobilegs.capture.photos import (
    PreparedPhoto,
    fitted,
    list_photos,
    other_files,
    prepare_photo,
    prepare_photos,
    prepared_names,
)
from mobilegs.data.images import image_size
from mobilegs.errors import InputError
from tests.support.layered_photos import FOCAL, layered_photo, write_photos

ROTATED = Path(__file__).with_name("photos") / "turned.heic"
ORIENTATION, EXIF, FOCAL_MM, FOCAL_35MM = 0x112, 0x8769, 0x920A, 0xA405
# EXIF orientation -> the transform that gives the stored photo
STORED = {
    3: Image.Transpose.ROTATE_180,
    6: Image.Transpose.ROTATE_90,
    8: Image.Transpose.ROTATE_270,
}


def difference(path: Path, picture: Image.Image) -> float:
    """Return the root mean square difference, in 0..255, between a file and an image."""
    with Image.open(path) as stored:
        assert stored.size == picture.size
        assert stored.getexif().get(ORIENTATION, 1) == 1
        errors = np.asarray(stored.convert("RGB"), float) - np.asarray(picture, float)
    return float(np.sqrt((errors**2).mean()))


@pytest.mark.parametrize(("tag", "suffix"), [(3, "jpg"), (6, "png"), (8, "tif")])
def test_a_rotated_photo_becomes_upright(tag: int, suffix: str, tmp_path: Path) -> None:
    upright, exif = layered_photo((0, 0)), Image.Exif()
    exif[ORIENTATION] = tag
    source = tmp_path / f"photo.{suffix}"
    upright.transpose(STORED[tag]).save(source, quality=95, exif=exif.tobytes())
    target = tmp_path / "out" / prepared_names([source])[source]
    found = prepare_photo(source, target, max_size=1000)
    assert (found.width, found.height) == upright.size
    assert difference(target, upright) < 4
    assert target.suffix == {"jpg": ".jpg"}.get(suffix, ".png")


def test_a_heic_photo_becomes_upright(tmp_path: Path) -> None:
    """turned.heic is `layered_photo((0, 0))` as a phone on its side stores it."""
    pytest.importorskip("pi_heif", reason="needs the extra capture")
    upright = layered_photo((0, 0))
    target = tmp_path / prepared_names([ROTATED])[ROTATED]
    found = prepare_photo(ROTATED, target, max_size=1000)
    assert (found.width, found.height) == upright.size and target.suffix == ".jpg"
    assert difference(target, upright) < 8


def test_a_ready_jpeg_is_copied_and_a_large_one_reduced(tmp_path: Path) -> None:
    source, target = tmp_path / "photo.JPG", tmp_path / "photo.jpg.jpg"
    layered_photo((0, 0)).save(source, format="JPEG", quality=80)
    prepare_photo(source, target, max_size=240)
    assert target.read_bytes() == source.read_bytes()
    target.unlink()
    found = prepare_photo(source, target, max_size=120)
    assert (found.width, found.height) == (120, 90) == image_size(target)
    assert fitted(3000, 4000, 1600) == (1200, 1600) and fitted(30, 10, 1600) == (30, 10)


def test_photos_of_other_modes_become_rgb(tmp_path: Path) -> None:
    grey = np.full((20, 30), 100 * 256, np.uint16)
    Image.fromarray(grey).save(tmp_path / "grey.png")
    Image.new("RGBA", (30, 20), (100, 100, 100, 200)).save(tmp_path / "clear.png")
    Image.new("CMYK", (30, 20), (155, 155, 155, 0)).save(tmp_path / "print.jpg")
    for source in list_photos(tmp_path):
        target = tmp_path / "out" / prepared_names([source])[source]
        prepare_photo(source, target, max_size=100)
        with Image.open(target) as picture:
            assert picture.mode == "RGB"
            assert abs(np.asarray(picture, int) - 100).max() <= 2


def test_the_focal_length_is_scaled_from_exif(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    full = prepare_photo(photos / "photo_0.jpg", tmp_path / "full.jpg", max_size=1000)
    half = prepare_photo(photos / "photo_0.jpg", tmp_path / "half.jpg", max_size=120)
    assert full.focal == pytest.approx(FOCAL, rel=0.02)
    assert half.focal == pytest.approx((full.focal or 0) / 2)
    assert "Layer One" in full.lens


def test_an_invalid_focal_length_is_ignored(tmp_path: Path) -> None:
    for value in (0, 65535 * 3, "wide"):
        exif = Image.Exif()
        exif.get_ifd(EXIF)[FOCAL_35MM] = value
        layered_photo((0, 0)).save(tmp_path / "photo.jpg", exif=exif)
        found = prepare_photo(tmp_path / "photo.jpg", tmp_path / "out.jpg", max_size=99)
        assert found.focal is None, value


def test_the_exposure_is_that_of_exif(tmp_path: Path) -> None:
    for number, values in enumerate(({0x829A: 0.01, 0x8827: 200, 0x829D: 2.0}, {0x829A: 0.01})):
        exif = Image.Exif()
        exif.get_ifd(EXIF).update(values)
        layered_photo((0, 0)).save(tmp_path / f"{number}.jpg", exif=exif)
    known, unknown = (
        prepare_photo(tmp_path / f"{number}.jpg", tmp_path / f"out{number}.jpg", max_size=64)
        for number in range(2)
    )
    assert known.exposure == pytest.approx(math.log2(0.01 * 200 / 4))
    assert unknown.exposure is None


def test_photos_of_a_lens_and_size_share_a_camera(tmp_path: Path) -> None:
    pycolmap = pytest.importorskip("pycolmap", reason="needs the extra capture")
    photos = []
    for index in range(6):
        size = (60, 40) if index < 5 else (40, 60)
        Image.new("RGB", size).save(tmp_path / f"{index}.png")
        lens, focal = (("wide", 40.0), ("tele", 90.0), ("", None))[index % 3]
        photos.append(PreparedPhoto(f"{index}.png", "", *size, focal=focal, lens=lens))
    import_cameras(tmp_path / "database.db", tmp_path, photos, "opencv")
    with pycolmap.Database.open(tmp_path / "database.db") as database:
        cameras = {camera.camera_id: camera for camera in database.read_all_cameras()}
        images = {image.name: cameras[image.camera_id] for image in database.read_all_images()}
    assert len(cameras) == 4 and len(images) == 6
    assert images["0.png"].camera_id == images["3.png"].camera_id
    assert images["1.png"].params[:4].tolist() == [90, 90, 30, 20]
    assert images["1.png"].has_prior_focal_length
    assert (images["5.png"].width, images["5.png"].has_prior_focal_length) == (40, False)
    assert images["2.png"].params[0] == pytest.approx(1.2 * 60)


def test_names_are_readable_by_colmap_and_unique(tmp_path: Path) -> None:
    sources = [tmp_path / name for name in ("a b (1).HEIC", "#über.png", "c.d.jpeg")]
    assert list(prepared_names(sources).values()) == ["a_b_(1).jpg", "_über.png", "c.d.jpg"]
    with pytest.raises(InputError, match=r"a_b.jpg and a b.png"):
        prepared_names([tmp_path / "a_b.jpg", tmp_path / "a b.png"])


def test_photos_are_found_in_the_folder_or_in_images(tmp_path: Path) -> None:
    assert list_photos(tmp_path) == []
    Image.new("RGB", (4, 4)).save(tmp_path / "cover.png")
    (tmp_path / "notes.txt").touch()
    (tmp_path / "._cover.png").write_bytes(b"macOS")
    assert [path.name for path in list_photos(tmp_path)] == ["cover.png"]
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "1.HEIC").touch()
    assert [path.name for path in list_photos(tmp_path)] == ["1.HEIC"]


def test_heic_without_pi_heif_raises_an_error_that_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "photo.heic").write_bytes(b"\0\0\0\x18ftypheic")
    with pytest.raises(InputError, match=r"photo.heic cannot be read"):
        prepare_photo(tmp_path / "photo.heic", tmp_path / "out.jpg", max_size=100)
    monkeypatch.setitem(sys.modules, "pi_heif", None)
    advice = r"export the photos as JPEG, or .* pip install 'mobilegs\[capture\]'"
    with pytest.raises(InputError, match=advice):
        prepare_photo(tmp_path / "photo.heic", tmp_path / "out.jpg", max_size=100)


def test_photos_in_folders_are_found_and_named_after_them(tmp_path: Path) -> None:
    for name in ("a/1.jpg", "b/1.jpg", "2.PNG", "b/c/3.webp"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (4, 4)).save(tmp_path / name)
    for name in ("masks/1.png", ".cache/1.png", "run/previews/1.png", "cut/work/photos/1.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (4, 4)).save(tmp_path / name)
    (tmp_path / "run" / "config.json").touch()
    (tmp_path / "cut/work/photos.json").touch()  # of a capture that was not finished
    (tmp_path / "a" / "clip.MOV").touch()
    (tmp_path / "README").touch()
    found = list_photos(tmp_path)
    assert list(prepared_names(found).values()) == ["2.png", "a_1.jpg", "b_1.jpg", "b_c_3.jpg"]
    assert other_files(found) == {".mov": 1, "README": 1}


def test_damaged_photos_are_left_out_and_named(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    sources = list_photos(photos)
    half = sources[1].read_bytes()
    sources[1].write_bytes(half[: len(half) // 2])
    record = prepare_photos(sources, tmp_path / "out", max_size=1000, progress=lambda *_: None)
    assert len(record["photos"]) == len(sources) - 1
    [sentence] = record["unreadable"]
    assert sources[1].name in sentence and "truncated" in sentence
    for source in sources[2:]:
        source.write_bytes(b"not a photo")
    with pytest.raises(InputError, match=re.escape(sources[1].name)):
        prepare_photos(sources, tmp_path / "more", max_size=1000, progress=lambda *_: None)


def test_photos_are_decoded_by_content(tmp_path: Path) -> None:
    photo = layered_photo((0, 0))
    photo.save(tmp_path / "a.HEIC", format="JPEG", quality=95)
    photo.save(tmp_path / "b.jpg", format="PNG")
    photo.save(tmp_path / "c.avif", quality=90)
    shutil.copy(ROTATED, tmp_path / "d.jpg")
    for source in list_photos(tmp_path):
        target = tmp_path / "out" / prepared_names([source])[source]
        prepare_photo(source, target, max_size=1000)
        with Image.open(target) as picture:
            assert (picture.format, picture.size) == ("JPEG", photo.size)
            difference = np.asarray(picture, float) - np.asarray(photo, float)
        assert abs(difference).mean() < 6, source.name


def test_a_camera_raw_without_rawpy_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "photo.CR3").write_bytes(b"no raw")
    monkeypatch.setitem(sys.modules, "rawpy", None)
    with pytest.raises(InputError, match=r"pip install 'mobilegs\[raw\]'"):
        prepare_photo(tmp_path / "photo.CR3", tmp_path / "out.jpg", max_size=100)
    monkeypatch.undo()
    pytest.importorskip("rawpy", reason="needs the extra raw")
    with pytest.raises(InputError, match=r"photo\.CR3 cannot be read as a camera raw"):
        prepare_photo(tmp_path / "photo.CR3", tmp_path / "out.jpg", max_size=100)
