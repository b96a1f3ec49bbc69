"""Reads photos from disk: sizes, and pixels averaged down to a given size."""

import math
import re
import struct
import threading
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8
from PIL import Image, ImageOps, UnidentifiedImageError
from scipy.sparse import csr_array

from mobilegs.atomic import file_size, open_input
from mobilegs.data.color import (
    ADOBE,
    Colors,
    h273_colors,
    name_of,
    png_colors,
    to_srgb,
    validate_depth,
)
from mobilegs.errors import InputError

SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff", ".avif")
OPAQUE = 128  # alpha from which on a pixel of a photo counts
WIDTH_MAX = 1600  # pixels: wider photos are downscaled if no factor is given, as in 3DGS

# larger JPEG photos are reduced as they are read; 200 megapixels would take 800 MB
REDUCED_FROM = 64_000_000  # pixels
PIXELS_MAX = 180_000_000  # that are decoded at once; PIL's own limit is as high
JPEG_PIXELS_MAX = 1_000_000_000

EXIF, TIME, F_NUMBER, ISO, ORIENTATION = 0x8769, 0x829A, 0x829D, 0x8827, 0x0112  # tags
COLOR_SPACE, INTEROP, INTEROP_INDEX = 0xA001, 0xA005, 1

# of SUFFIXES; of PIL's others, EPS would start Ghostscript
FORMATS = ("JPEG", "PNG", "WEBP", "BMP", "TIFF", "AVIF")
# the errors that PIL raises for damaged or oversized files; it names none in its documentation
PIL_ERRORS = (
    ArithmeticError, AssertionError, AttributeError, EOFError, LookupError, OSError, RuntimeError,
    SyntaxError, TypeError, ValueError, struct.error, zlib.error, Image.DecompressionBombError,
)  # fmt: skip

_unlimited = threading.Lock()  # held while PIL's limit of pixels, a global, is lifted


def is_file(path: Path) -> bool:
    """Return whether `path` is a file; False for names that the file system cannot hold."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def open_image(path: Path) -> Image.Image:
    """Open an image without decoding it. Raises `InputError` if it is none, or is too large."""
    file_size(path)  # raises for a pipe, at which PIL would wait
    try:
        with _unlimited:
            limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
            try:
                image = Image.open(path, formats=FORMATS)
            finally:
                Image.MAX_IMAGE_PIXELS = limit
        if image.format in ("PNG", "AVIF"):
            image.info.update(_code_points(path))
    except UnidentifiedImageError as error:
        kinds = ", ".join(FORMATS)
        raise InputError(
            f"{path} cannot be read as an image: it is damaged, or not {kinds} with 8 or 16 bits "
            "per channel"
        ) from error
    except PIL_ERRORS as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error
    try:
        validate_pixels(path, image.size, jpeg=image.format in ("JPEG", "MPO"))
        if any(";16" in str(tile) for tile in getattr(image, "tile", ())):
            with decoding(path):
                validate_depth(image.mode, colors_of(image))
    except InputError:
        image.close()
        raise
    return image


def validate_pixels(path: Path, size: tuple[int, int], *, jpeg: bool = False) -> None:
    """Raise `InputError` for more pixels than can be decoded, or, of a `jpeg`, can be reduced."""
    most = JPEG_PIXELS_MAX if jpeg else PIXELS_MAX
    if size[0] * size[1] > most:
        raise InputError(
            f"{path} has {size[0] * size[1] / 1e6:,.0f} megapixels, and at most {most / 1e6:,.0f} "
            "can be decoded: make it smaller (a JPEG of up to "
            f"{JPEG_PIXELS_MAX / 1e6:,.0f} megapixels, not progressive, is reduced as it is read)"
        )


def _code_points(path: Path) -> dict[str, tuple[int, int]]:
    """Return `{"cicp": (primaries, transfer)}` of H.273 if a PNG or AVIF file has them."""
    with open_input(path) as file:
        head = file.read(1 << 16)
    chunk = re.search(rb"\0\0\0\x04cICP(.)(.)|colrnclx\0(.)\0(.)", head, re.DOTALL)
    if chunk is None:
        return {}
    primaries, transfer = (number[0] for number in chunk.groups() if number is not None)
    return {"cicp": (primaries, transfer)}


def colors_of(image: Image.Image) -> bytes | Colors | None:
    """Return the ICC profile of an opened image, or what else it says of its colours.

    None is sRGB, or that it says nothing. The precedence is that of the specifications of PNG and
    of AVIF and HEIC.
    """
    info = image.info
    if "cicp" in info and (image.format == "PNG" or not info.get("icc_profile")):
        return h273_colors(*info["cicp"])
    if info.get("icc_profile"):
        return bytes(info["icc_profile"])
    if image.format == "PNG":
        known = "srgb" not in info
        return png_colors(info.get("gamma"), info.get("chromaticity")) if known else None
    try:
        exif = image.getexif()
        space = exif.get_ifd(EXIF).get(COLOR_SPACE)
        index = str(exif.get_ifd(INTEROP).get(INTEROP_INDEX, ""))
    except PIL_ERRORS:
        return None
    return ADOBE if space == 2 or (space != 1 and index.startswith("R03")) else None


def colors_name(image: Image.Image) -> str:
    """Return the name of the colours of an opened image; empty for sRGB."""
    return name_of(image.mode, colors_of(image))


def decode_srgb(
    image: Image.Image, path: Path, least: tuple[int, int], *, upright: bool = False
) -> Image.Image:
    """Decode an opened photo to RGB or RGBA with 8 bits per channel in sRGB.

    A JPEG of more than `REDUCED_FROM` pixels is reduced by 2, 4 or 8 as it is read, to not less
    than `least`, width and height in stored pixels. `upright` turns the photo as its EXIF says.
    Raises `InputError` for `path` if the photo is damaged or too large.
    """
    with decoding(path):
        colors = colors_of(image)
        if image.width * image.height > REDUCED_FROM and not image.info.get("progressive"):
            image.draft(None, least)
        validate_pixels(path, image.size)
        image.load()
        if upright:
            ImageOps.exif_transpose(image, in_place=True)
        picture = to_srgb(image, colors)
        if is_transparent(image):
            picture.putalpha(alpha_channel(image))
    picture.info = {}  # of other colours
    return picture


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
        return is_transparent(image)


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
    """Decode a photo, convert it to sRGB and average it down to `width` x `height` pixels.

    Returns (sRGB, opaque). A transparent image is composited over the colour `over`, RGB in
    [0, 1]. With `over` None its colours stay, and `opaque` is True where all averaged pixels are
    opaque; in all other cases `opaque` is None. Raises `InputError` if it cannot be decoded.
    """
    with open_image(path) as image:
        turned = is_turned(image, (width, height))
        least = (height, width) if turned else (width, height)
        rgba = decode_srgb(image, path, least, upright=turned)
    if rgba.mode == "RGB":
        return np.asarray(_boxed(rgba, width, height)), None
    alpha, rgb = rgba.getchannel("A"), rgba.convert("RGB")
    if over is None:
        return np.asarray(_boxed(rgb, width, height)), all_of(
            np.asarray(alpha) >= OPAQUE, width, height
        )
    paper = Image.new("RGB", rgba.size, tuple(round(255 * channel) for channel in over))
    return np.asarray(_boxed(Image.composite(rgb, paper, alpha), width, height)), None


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


def is_transparent(image: Image.Image) -> bool:
    """Return whether an image has transparency."""
    return image.mode in ("RGBA", "LA", "PA", "RGBa", "La") or "transparency" in image.info


def alpha_channel(image: Image.Image) -> Image.Image:
    """Return the opacity of each pixel of an image `is_transparent`, 0 to 255."""
    if image.mode == "I;16":  # convert() would clip to 8 bits
        shown = np.asarray(image) != image.info["transparency"]
        return Image.fromarray(shown.astype(np.uint8) * 255)
    return image.convert("RGBA").getchannel("A")


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


def all_of(used: Bool[np.ndarray, "H W"], width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return a mask resized to `width` x `height`, True where all pixels averaged are."""
    white = Image.fromarray(np.where(used, np.uint8(255), np.uint8(0)))
    return np.asarray(_boxed(white, width, height)) == 255
