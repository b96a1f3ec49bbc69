"""Reads photos and masks from disk: sizes, and pixels averaged down to a given size."""

import math
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8
from PIL import Image, ImageOps
from scipy.sparse import csr_array

from mobilegs.errors import InputError

SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".avif")
WIDTH_MAX = 1600  # pixels: wider photos are downscaled if no factor is given, as in 3DGS

EXIF, TIME, F_NUMBER, ISO, ORIENTATION = 0x8769, 0x829A, 0x829D, 0x8827, 0x0112  # tags

# of SUFFIXES; of PIL's others, EPS would start Ghostscript
FORMATS = ("JPEG", "PNG", "WEBP", "BMP", "TIFF", "AVIF")
# the errors that PIL raises for damaged or oversized files; it names none in its documentation
PIL_ERRORS = (
    ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, OSError, RuntimeError,
    SyntaxError, TypeError, ValueError, struct.error, zlib.error, Image.DecompressionBombError,
)  # fmt: skip


def is_file(path: Path) -> bool:
    """Return whether `path` is a file; False for names that the file system cannot hold."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def open_image(path: Path) -> Image.Image:
    """Open an image without decoding it. Raises `InputError` if it is not an image."""
    try:
        return Image.open(path, formats=FORMATS)
    except PIL_ERRORS as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error


@contextmanager
def decoding(path: Path) -> Iterator[None]:
    """Raise `InputError` for an image at `path` that PIL cannot decode in the block."""
    try:
        yield
    except InputError:
        raise
    except PIL_ERRORS as error:
        raise InputError(f"{path} cannot be decoded ({error})") from error


def image_size(path: Path) -> tuple[int, int]:
    """Return width and height in pixels as stored, without EXIF rotation."""
    with open_image(path) as image:
        return image.size


def is_turned(image: Image.Image, shape: tuple[int, int]) -> bool:
    """Return whether an opened image has the aspect ratio of a size only after EXIF rotation."""
    if same_shape(image.size, shape) or not same_shape((image.height, image.width), shape):
        return False
    return image.getexif().get(ORIENTATION) in (5, 6, 7, 8)


def _upright(image: Image.Image, shape: tuple[int, int]) -> Image.Image:
    return ImageOps.exif_transpose(image) if is_turned(image, shape) else image


def exposure_of(image: Image.Image) -> float | None:
    """Return the exposure of a photo after its EXIF, None if it does not say.

    It is log2 of exposure time (seconds) times ISO speed over the square of the f-number: 1 more
    is twice the brightness of the same light.
    """
    try:
        details = image.getexif().get_ifd(EXIF)
    except PIL_ERRORS:  # a PNG is decoded before its EXIF is known
        return None
    time, iso, number = (exif_number(details.get(tag)) for tag in (TIME, ISO, F_NUMBER))
    return math.log2(time * iso / number**2) if time and iso and number else None


def exif_number(value: object) -> float:
    """Return an EXIF value as a number in (1e-9, 1e5), or 0 if it is not one."""
    try:
        number = float(value[0] if isinstance(value, tuple) else value)  # pyright: ignore
    except (TypeError, ValueError, ZeroDivisionError, IndexError):
        return 0.0
    return number if 1e-9 < number < 1e5 else 0.0


def has_alpha(path: Path) -> bool:
    """Return whether an image file has transparency."""
    with open_image(path) as image:
        return _has_alpha(image)


def reduced_size(width: int, height: int, downscale: int | None) -> tuple[int, int]:
    """Return (width, height) divided by `downscale`, to the nearest pixel.

    None makes the width at most 1600 and rounds the height down, as 3DGS does.
    """
    if downscale is None:
        if width <= WIDTH_MAX:
            return width, height
        return WIDTH_MAX, max(1, height * WIDTH_MAX // width)
    return max(1, int(width / downscale + 0.5)), max(1, int(height / downscale + 0.5))


def same_shape(size: tuple[int, int], other: tuple[int, int]) -> bool:
    """Return whether two sizes have the same aspect ratio, up to rounding to pixels."""
    (w, h), (W, H) = size, other
    return abs(W * h - w * H) <= 1.5 * max(H, W)


def read_pixels(
    path: Path, width: int, height: int, *, over: tuple[float, float, float] | None
) -> tuple[UInt8[np.ndarray, "h w 3"], Bool[np.ndarray, "h w"] | None]:
    """Decode a photo and average it down to `width` x `height` pixels.

    Returns (sRGB, opaque). A transparent image is composited over the colour `over`, RGB in
    [0, 1]. With `over` None its colours stay, and `opaque` is True where all averaged pixels are
    opaque; in all other cases `opaque` is None. Raises `InputError` if it cannot be decoded.
    """
    with open_image(path) as image, decoding(path):
        image.load()
        image = _upright(image, (width, height))
        if not _has_alpha(image):
            return np.asarray(_boxed(as_rgb(image), width, height)), None
        rgba = image.convert("RGBA")
    alpha, rgb = rgba.getchannel("A"), rgba.convert("RGB")
    if over is None:
        return np.asarray(_boxed(rgb, width, height)), _solid(alpha, width, height)
    paper = Image.new("RGB", rgba.size, tuple(round(255 * channel) for channel in over))
    return np.asarray(_boxed(Image.composite(rgb, paper, alpha), width, height)), None


def read_mask(path: Path, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return a mask, True where all pixels that are averaged are white (128 or more).

    Raises `InputError` if the file cannot be decoded.
    """
    with open_image(path) as image, decoding(path):
        return _solid(image.convert("L"), width, height)


def read_opaque(path: Path, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return where a photo shows something, at `width` x `height` pixels.

    A pixel is False if all that are averaged into it are transparent. Raises `InputError` if the
    file cannot be decoded.
    """
    with open_image(path) as image, decoding(path):
        alpha = _upright(image, (width, height)).convert("RGBA").getchannel("A")
    shown = Image.fromarray(np.where(np.asarray(alpha) > 0, np.uint8(255), np.uint8(0)))
    return np.asarray(shown.resize((width, height), Image.Resampling.BOX)) > 0


def list_images(folder: Path) -> list[Path]:
    """Return the image files in `folder`, sorted by name; empty if there is no such folder."""
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)


def _has_alpha(image: Image.Image) -> bool:
    return image.mode in ("RGBA", "LA", "PA", "RGBa", "La") or "transparency" in image.info


def as_rgb(image: Image.Image) -> Image.Image:
    """Return the image as RGB with 8 bits per channel; transparency is dropped."""
    if image.mode.startswith("I;16"):  # convert() would clip 16-bit grey to white
        image = Image.fromarray((np.asarray(image).astype(np.uint16) >> 8).astype(np.uint8))
    return image.convert("RGB")


def _boxed(image: Image.Image, width: int, height: int) -> Image.Image:
    """Resize by averaging areas, rounded once.

    PIL's box filter averages whole pixels only. It also rounds up twice, which makes the result
    half a step of 8 bits too bright.
    """
    if image.size == (width, height):
        return image
    across, down = image.width // width, image.height // height
    if image.size == (across * width, down * height):
        return image.reduce((across, down))
    bands = []
    for band in image.split():
        rows = _overlap(image.height, height) @ np.asarray(band, np.float32)
        bands.append(
            Image.fromarray((rows @ _overlap(image.width, width).T).round().astype(np.uint8))
        )
    return Image.merge(image.mode, bands)


def _overlap(size: int, cells: int) -> csr_array:
    """Return the weights `[cells, size]` of pixels in the averages of `cells` equal parts."""
    borders = np.arange(cells + 1) * (size / cells)
    cuts = np.union1d(borders, np.arange(size + 1))
    middle, share = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts) * (cells / size)
    part = np.searchsorted(borders, middle).clip(1, cells) - 1
    pixel = middle.astype(np.int64).clip(0, size - 1)
    return csr_array((share.astype(np.float32), (part, pixel)), shape=(cells, size))


def _solid(image: Image.Image, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    white = Image.fromarray(np.where(np.asarray(image) >= 128, 255, 0).astype(np.uint8))
    return np.asarray(_boxed(white, width, height)) == 255
