"""Photos of three textured planes at different depths, from cameras that only translate."""

from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter

WIDTH, HEIGHT = 240, 180
FOCAL = 220.0  # pixels
FOCAL_35MM = round(FOCAL * np.hypot(36, 24) / np.hypot(WIDTH, HEIGHT))
LAYERS = ((4.0, None), (3.0, (20, 100, 130, 150)), (2.4, (150, 40, 210, 120)))  # depth, box
CENTERS = np.array([(0.3 * (i % 3) - 0.3, 0.2 * (i // 3) - 0.2 + 0.03 * i, 0) for i in range(9)])
MARGIN = 60  # pixels by which a layer exceeds a photo, on every side


@cache
def texture(index: int) -> Image.Image:
    """Return noise of two scales, for features at all sizes."""
    random = np.random.default_rng(index)
    size = (WIDTH + 2 * MARGIN, HEIGHT + 2 * MARGIN)
    total = np.zeros((size[1], size[0], 3))
    for cell in (8, 20):
        small = random.integers(0, 256, (size[1] // cell + 1, size[0] // cell + 1, 3), np.uint8)
        total += np.asarray(Image.fromarray(small).resize(size, Image.Resampling.BICUBIC))
    return Image.fromarray((total / 2).astype(np.uint8))


@cache
def layered_photo(eye: tuple[float, float]) -> Image.Image:
    """Render the layers from a camera at (x, y, 0) that looks along z."""
    photo = Image.new("RGB", (WIDTH, HEIGHT))
    for index, (depth, box) in enumerate(LAYERS):
        shift = [MARGIN + FOCAL * coordinate / depth for coordinate in eye]
        affine = (1, 0, shift[0], 0, 1, shift[1])
        visible = texture(index).transform(
            (WIDTH, HEIGHT), Image.Transform.AFFINE, affine, Image.Resampling.BICUBIC
        )
        mask = Image.new("L", texture(index).size, 255 if box is None else 0)
        if box is not None:
            left, top, right, bottom = box
            mask.paste(255, (left + MARGIN, top + MARGIN, right + MARGIN, bottom + MARGIN))
        mask = mask.transform(
            (WIDTH, HEIGHT), Image.Transform.AFFINE, affine, Image.Resampling.BILINEAR
        )
        photo.paste(visible, (0, 0), mask)
    return photo


def write_photos(folder: Path) -> Path:
    """Write nine photos as JPEG, with their focal length in EXIF, and return the folder."""
    folder.mkdir(parents=True)
    exif = Image.Exif()
    exif[0x110] = "Layer One"
    exif.get_ifd(0x8769)[0xA405] = FOCAL_35MM
    for index, (x, y, _) in enumerate(CENTERS.tolist()):
        layered_photo((x, y)).save(folder / f"photo_{index}.jpg", quality=95, exif=exif)
    return folder


def blurred(photo: Image.Image, radius: float) -> Image.Image:
    return photo.filter(ImageFilter.GaussianBlur(radius))
