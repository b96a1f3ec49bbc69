"""Masks and transparency of photos that get poses: turned, reduced, undistorted, for features."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.capture import CaptureRun, capture_photos
from mobilegs.capture.photos import list_photos, mask_file, prepare_photos, save_faces
from mobilegs.capture.run import masks_of_inputs
from mobilegs.data import load_capture, load_view
from mobilegs.errors import InputError
from tests.support.layered_photos import CENTERS, HEIGHT, WIDTH, layered_photo, write_photos
from tests.support.selection import few

ORIENTATION = 0x112
BAR = 40  # columns on the left that the masks black out
USED = np.zeros((HEIGHT, WIDTH), np.uint8)
USED[:, BAR:] = 255


def prepared_mask(folder: Path, *, max_size: int = 1000) -> np.ndarray:
    """Prepare the photos in `folder / photos` and return the mask of the first."""
    photos = list_photos(folder / "photos")
    masks = masks_of_inputs(folder / "photos", photos)
    out = folder / "work" / "photos"
    prepare_photos(photos, out, max_size=max_size, progress=lambda *_: None, masks_of=masks)
    with Image.open(mask_file(out, "photo_0.jpg")) as image:
        return np.asarray(image)


@pytest.mark.parametrize("stored", [True, False])
def test_a_mask_is_turned_and_reduced_as_its_photo(tmp_path: Path, stored: bool) -> None:
    """Masks made from the stored pixels are turned, those made from the upright photo are not."""
    photos, exif = write_photos(tmp_path / "photos"), Image.Exif()
    exif[ORIENTATION] = 6
    turned = layered_photo((0, 0)).transpose(Image.Transpose.ROTATE_90)
    turned.save(photos / "photo_0.jpg", exif=exif)
    mask = Image.fromarray(USED)
    mask = mask.transpose(Image.Transpose.ROTATE_90) if stored else mask
    (tmp_path / "masks").mkdir()
    mask.save(tmp_path / "masks" / "photo_0.png")
    assert np.array_equal(prepared_mask(tmp_path), USED)
    assert np.array_equal(prepared_mask(tmp_path / ".", max_size=1000), USED)


def test_a_reduced_mask_keeps_what_is_used_whole(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    Image.fromarray(USED[:, 1:]).resize((WIDTH, HEIGHT), 0).save(photos / "photo_0_mask.png")
    assert len(list_photos(photos)) == 9
    mask = prepared_mask(tmp_path, max_size=WIDTH // 2)
    assert mask.shape == (HEIGHT // 2, WIDTH // 2) and set(np.unique(mask)) == {0, 255}
    # column 39 at full size is masked in part of what column 19 or 20 averages
    assert not mask[:, : BAR // 2].any() and mask[:, BAR // 2 + 1 :].all()


def test_a_photo_that_is_masked_nearly_whole_is_left_out(tmp_path: Path) -> None:
    photos = write_photos(tmp_path / "photos")
    for index in range(5):
        picture = layered_photo((0, 0)).convert("RGBA")
        picture.putalpha(0)
        picture.save(photos / f"photo_{index}.png")
        (photos / f"photo_{index}.jpg").unlink()
        if index == 0:
            found = list_photos(photos)
            record = prepare_photos(found, tmp_path / "one", max_size=99, progress=lambda *_: None)
            assert len(record["photos"]) == 8
            assert "photo_0.png is masked nearly whole" in record["unreadable"][0]
    with pytest.raises(InputError, match=r"photo_0\.png is masked nearly whole: what is black"):
        prepare_photos(list_photos(photos), tmp_path / "two", max_size=99, progress=lambda *_: None)


def test_masks_of_panoramas_become_those_of_the_faces(tmp_path: Path) -> None:
    used = np.ones((64, 128), bool)
    used[44:] = False  # the tripod
    picture = Image.new("RGB", (128, 64), (200, 100, 50))
    save_faces(picture, tmp_path / "photos", "p.png", source=Path("p"), max_size=99, used=used)
    masks = {path.parent.name: path for path in (tmp_path / "masks").rglob("p.png.png")}
    assert sorted(masks) == ["back", "down", "front", "left", "right"]
    with Image.open(masks["down"]) as down, Image.open(masks["front"]) as front:
        assert np.asarray(down).mean() < 40
        assert np.asarray(front)[:16].all() and not np.asarray(front)[-3:, 8:-8].any()


def test_masks_outside_of_the_photos_folder_are_said(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    photos = list_photos(write_photos(tmp_path / "photos"))
    (tmp_path / "mask").mkdir()
    for name in ("photo_0.jpg.png", "photo_1.JPG.mask.png", "other.png"):
        Image.fromarray(USED).save(tmp_path / "mask" / name)
    found = masks_of_inputs(tmp_path / "photos", photos)
    assert [path.name for path in found] == ["photo_0.jpg", "photo_1.jpg"]
    assert "7 of 9 photos have none" in caplog.text and "1 belong to no photo" in caplog.text
    assert f"2 masks are used from {tmp_path / 'mask'}" in caplog.text


@pytest.mark.parametrize("lens", few(["simple", "fisheye"], "simple"))
def test_masks_and_transparency_come_along_into_the_capture(tmp_path: Path, lens: str) -> None:
    """Two photos have a mask, two are transparent; a bar stands before these four."""
    pycolmap = pytest.importorskip("pycolmap", reason="needs the extra capture")
    (tmp_path / "photos" / "masks").mkdir(parents=True)
    for index, (x, y, _) in enumerate(CENTERS[:5].tolist()):
        pixels = np.array(layered_photo((x, y)))
        if index < 4:
            pixels[:, : BAR - 4] = np.random.default_rng(0).integers(0, 256, (HEIGHT, BAR - 4, 3))
            pixels[:, : BAR - 4, 1] = 0
        picture = Image.fromarray(pixels)
        if index % 2:
            picture.putalpha(Image.fromarray(USED))
        elif index < 4:
            mask = tmp_path / "photos" / "masks" / f"photo_{index}.png.png"
            Image.fromarray(USED // 255).save(mask)
        picture.save(tmp_path / "photos" / f"photo_{index}.png")
    capture = tmp_path / "capture"
    report = capture_photos(CaptureRun(tmp_path / "photos", capture, lens=lens))  # pyright: ignore[reportArgumentType]
    placed = report["registered"]
    assert placed == 5 or (lens == "fisheye" and placed >= 3)
    with pycolmap.Database.open(capture / "work" / "database.db") as database:
        for image in database.read_all_images():
            columns = database.read_keypoints(image.image_id)[:, 0]
            assert len(columns) > 50
            assert (columns.min() >= BAR - 1) == (image.name != "photo_4.png"), image.name
    masks = {path.name for path in (capture / "masks").iterdir()}
    assert masks <= {f"photo_{index}.png.png" for index in range(4)}
    assert len(masks) >= placed - 1
    if lens == "fisheye":  # whose photos stay as they are
        with Image.open(capture / "masks" / min(masks)) as mask:
            assert np.array_equal(np.asarray(mask), USED)
        return
    dataset = load_capture(capture)
    for frame in [*dataset.train, *dataset.test]:
        view = load_view(frame)
        if frame.name == "photo_4.png":
            assert view.mask is None
            continue
        assert view.mask is not None and 0.5 < view.mask.mean() < 0.9
        assert (view.image[..., 1] == 0).float().mean() > 0.05  # the bar is there, and masked
        assert not view.mask[view.image[..., 1] == 0].any()
