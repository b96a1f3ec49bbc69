"""Masks of photos: every name and encoding, masks of nothing, and what is said of the rest."""

import json
import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from mobilegs.data import load_capture, load_view, masks
from mobilegs.data.masks import is_mask_folder, photo_of, used_pixels, without_masks
from mobilegs.errors import InputError
from tests.data.test_nerfstudio import capture as write_transforms
from tests.support.colmap_capture import write_capture_of_noise

USED = np.zeros((8, 12), np.uint8)
USED[:, 5:] = 255


def save(root: Path, name: str, pixels: np.ndarray = USED, kind: str = "PNG") -> Path:
    """Write a mask; `kind` is its format, whatever its suffix says."""
    (root / name).parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(root / name, format=kind)
    return root / name


def mask_of(root: Path, photo: str = "p01.png") -> np.ndarray | None:
    dataset = load_capture(root)
    [frame] = [frame for frame in [*dataset.train, *dataset.test] if frame.name == photo]
    mask = load_view(frame).mask
    return None if mask is None else mask.numpy()


@pytest.mark.parametrize(
    "name",
    [
        "masks/p01.png",
        "masks/p01.png.png",
        "mask/P01.PNG",
        "Masks/p01_mask.png",  # Metashape: {filename}_mask.png
        "masks/p01.mask.png",
        "masks/p01.png.mask.png",  # RealityScan
        "masks/p01.png.mask",  # Brush
        "masks/p01.TIFF",
        "masks/images/p01.png",
        "masks_2/p01.png",
        "images/p01_mask.png",
        "images/p01.png.png",
        "images/p01.png.mask.png",
        "images/p01.Mask.tif",
        "images/masks/p01.png",
        "images/.mask/p01.png",  # layers of RealityCapture
        "images/_mask/p01.bmp",
    ],
)
def test_every_name_of_a_mask_is_found(tmp_path: Path, name: str) -> None:
    root = write_capture_of_noise(tmp_path)
    save(root, name)
    mask = mask_of(root)
    assert mask is not None and np.array_equal(mask, USED > 0)
    assert mask_of(root, "p02.png") is None


def test_a_dynamic_mask_leaves_out_what_is_white(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_transforms(tmp_path)  # as instant-ngp reads them
    save(root, "images/dynamic_mask_f01.png", 255 - USED)
    mask = mask_of(root, "f01.png")
    assert mask is not None and np.array_equal(mask, USED > 0)
    assert "1 named dynamic_mask_NAME leave out what is white" in caplog.text


def test_folders_of_photos_are_folders_of_masks(tmp_path: Path) -> None:
    """Also of a rig whose cameras have a folder each, and with names in another Unicode form."""
    photos = [tmp_path / name for name in ("images/left/1.jpg", "images/right/1.jpg", "é.jpg")]
    found = [tmp_path / name for name in ("masks/left/1.png", "images/right/mask/1.png")]
    for mask in (*found, tmp_path / "masks" / "e\u0301.png"):
        save(tmp_path, mask.relative_to(tmp_path).as_posix())
    assert masks.find_masks(photos, tmp_path) == {
        **dict(zip(photos, found, strict=False)),
        photos[2]: tmp_path / "masks" / "e\u0301.png",
    }


def test_masks_of_nothing_and_photos_without_one_are_counted(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_capture_of_noise(tmp_path)
    for name in ("p01.png", "p02.png", "gone1.png", "gone2.png"):
        save(root, f"masks/{name}")
    Image.new("RGB", (12, 8)).save(root / "images" / "unplaced.png")
    save(root, "masks/unplaced.png")  # its photo is there, without a pose
    load_capture(root)
    [record] = [each for each in caplog.records if each.levelno == logging.WARNING]
    assert "7 of 9 photos have none, such as p00.png" in record.message
    assert "2 belong to no photo, such as gone1.png" in record.message


def test_named_masks_and_found_ones_go_together(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_transforms(tmp_path)
    save(root, "elsewhere/a.png")
    save(root, "masks/f02.png")
    meta = json.loads((root / "transforms.json").read_text("utf-8"))
    meta["frames"][1]["mask_path"] = "elsewhere/a.png"
    (root / "transforms.json").write_text(json.dumps(meta), "utf-8")
    assert mask_of(root, "f01.png") is not None and mask_of(root, "f02.png") is not None
    assert "7 of 9 photos have none" in caplog.text and "belong" not in caplog.text


def palette(*colors: tuple[int, int, int]) -> Callable[[], Image.Image]:
    def image() -> Image.Image:
        indexed = Image.fromarray(USED // 255).convert("P")
        indexed.putpalette([channel for color in colors for channel in color])
        return indexed

    return image


def with_alpha(mode: str, color: np.ndarray, alpha: np.ndarray) -> Callable[[], Image.Image]:
    def image() -> Image.Image:
        picture = Image.fromarray(color).convert(mode)
        picture.putalpha(Image.fromarray(alpha))
        return picture

    return image


FULL = np.full_like(USED, 255)
ENCODINGS: dict[str, Callable[[], Image.Image]] = {
    "0 and 255": lambda: Image.fromarray(USED),
    "0 and 1": lambda: Image.fromarray(USED // 255),
    "1 bit": lambda: Image.fromarray(USED > 0),
    "grey edges": lambda: Image.fromarray(np.minimum(USED, np.arange(12, dtype=np.uint8))),
    "16 bits": lambda: Image.fromarray((USED // 255).astype(np.uint16)),
    "float": lambda: Image.fromarray((USED / 255).astype(np.float32)),
    "blue": lambda: Image.fromarray(USED[..., None] // 255 * np.array([0, 0, 1], np.uint8)),
    "palette": palette((0, 0, 0), (255, 255, 255)),
    "palette, almost black": palette((0, 0, 0), (0, 0, 1)),
    "palette, white first": palette((255, 255, 255), (0, 0, 0)),
    "palette of classes": palette((120, 120, 120), (6, 230, 230)),
    "alpha of black": with_alpha("LA", 0 * USED, USED),
    "alpha of white": with_alpha("RGBA", FULL, USED),
    "alpha that is full": with_alpha("RGBA", USED, FULL),
}


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_every_encoding_says_the_same(tmp_path: Path, encoding: str) -> None:
    image = ENCODINGS[encoding]()
    path = tmp_path / "m.tif"
    image.save(path, format="TIFF" if image.mode == "F" else "PNG")
    expected = USED == 0 if encoding == "palette, white first" else USED > 0
    assert np.array_equal(used_pixels(path), expected)


@pytest.mark.parametrize("kind", ["JPEG", "WEBP"])
def test_noise_of_a_lossy_mask_is_no_mask(tmp_path: Path, kind: str) -> None:
    path = save(tmp_path, "m.png", np.kron(USED, np.ones((8, 8), np.uint8)), kind)
    with Image.open(path) as image:
        assert len(np.unique(np.asarray(image))) >= 2
    assert np.array_equal(used_pixels(path), np.kron(USED, np.ones((8, 8))) > 0)


@pytest.mark.parametrize("factor", [2, 3])
def test_a_mask_of_another_size_is_resized(tmp_path: Path, factor: int) -> None:
    root = write_capture_of_noise(tmp_path, size=(24, 16), camera=(1, 1, 24, 16, (20, 22, 12, 8)))
    large = np.kron(USED, np.ones((2 * factor, 2 * factor), np.uint8))
    for pixels in (USED, large):
        save(root, "masks/p01.png", pixels)
        mask = mask_of(root)
        assert mask is not None and np.array_equal(mask, np.kron(USED, np.ones((2, 2))) > 0)
    save(root, "masks/p01.png", USED[:, :8])
    with pytest.raises(InputError, match=r"mask .*p01\.png has another aspect ratio"):
        load_capture(root)


def test_a_photo_that_is_masked_nearly_whole_is_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    root = write_capture_of_noise(tmp_path)
    save(root, "masks/p01.png", 0 * USED)
    Image.fromarray(np.zeros((8, 12, 4), np.uint8)).save(root / "images" / "p02.png")
    save(root, "masks/p03.png", np.arange(96, dtype=np.uint8).reshape(8, 12) // 88)
    save(root, "sky_masks/p04.png")
    dataset = load_capture(root)
    assert "sky_masks is not read" in caplog.text
    assert "masks leave 8 % of their photos: what is black (0)" in caplog.text
    assert len(dataset.train) == 5 and len(dataset.test) == 2
    assert "2 photos are left out, masked nearly whole: p01.png, p02.png" in caplog.text
    for index in range(3, 6):
        save(root, f"masks/p{index:02d}.png", 0 * USED)
    with pytest.raises(InputError, match=r"less than 1 % of 5 of 9 photos, such as .*black \(0\)"):
        load_capture(root)


@pytest.mark.parametrize(
    ("name", "photo"),
    [
        ("a_mask.png", "a"),
        ("a.MASK.png", "a"),
        ("a.jpg.mask.png", "a.jpg"),
        ("Dynamic_mask_a.png", "a"),
        ("a.jpg.png", "a.jpg"),
        ("a.jpg", None),
        ("mask.png", None),
        ("unmasked.png", None),
    ],
)
def test_a_mask_beside_photos_names_its_photo(name: str, photo: str | None) -> None:
    assert photo_of(name) == photo


def test_masks_are_no_photos_where_their_photo_is() -> None:
    names = ["1.JPG", "1_mask.png", "1.jpg.mask.png", "dynamic_mask_1.png", "2_mask.png", "3.jpg"]
    left = without_masks([Path("a") / name for name in names])
    assert [path.name for path in left] == ["1.JPG", "2_mask.png", "3.jpg"]
    folders = ["masks", "Mask", ".mask", "_mask", "masks_4", "unmasked", "mask_of_zorro"]
    assert [is_mask_folder(name) for name in folders] == [True] * 5 + [False] * 2


def test_a_palette_of_one_index_keeps_its_colour(tmp_path: Path) -> None:
    white = Image.new("P", (4, 4), 0)
    white.putpalette([255, 255, 255])
    white.save(tmp_path / "m.png")
    assert used_pixels(tmp_path / "m.png").all()
