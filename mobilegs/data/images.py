"""Photos and masks on disk: their sizes, and their pixels at the size that is asked for."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from jaxtyping import Bool, UInt8
from PIL import Image
from scipy.sparse import csr_array

from mobilegs.errors import InputError

SUFFIXES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff")
WIDEST = 1600  # pixels: wider photos are reduced unless a factor is asked for, as in 3DGS

# everything PIL raises for a damaged file, besides the oversized one it calls a bomb
PIL_ERRORS = (OSError, SyntaxError, ValueError, EOFError, Image.DecompressionBombError)


def is_file(path: Path) -> bool:
    """Whether `path` is a file; a name that the file system cannot hold is not one."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def open_image(path: Path) -> Image.Image:
    """The image, header read, pixels not yet; `InputError` if it is not one."""
    try:
        return Image.open(path)
    except PIL_ERRORS as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error


def image_size(path: Path) -> tuple[int, int]:
    """Width and height in pixels as stored; an EXIF rotation is not applied."""
    with open_image(path) as image:
        return image.size


def has_alpha(path: Path) -> bool:
    """Whether the file carries transparency."""
    with open_image(path) as image:
        return _has_alpha(image)


def reduced_size(width: int, height: int, downscale: int | None) -> tuple[int, int]:
    """Size after division by `downscale`, to the nearest pixel.

    None makes it at most 1600 wide, and its height what 3DGS makes of it, which drops fractions.
    """
    if downscale is None:
        return (width, height) if width <= WIDEST else (WIDEST, max(1, height * WIDEST // width))
    return max(1, int(width / downscale + 0.5)), max(1, int(height / downscale + 0.5))


def same_shape(size: tuple[int, int], other: tuple[int, int]) -> bool:
    """Whether two sizes are the same picture at two resolutions, rounding to pixels allowed."""
    (w, h), (W, H) = size, other
    return abs(W * h - w * H) <= 1.5 * max(H, W)


def read_pixels(
    path: Path, width: int, height: int, *, over: tuple[float, float, float] | None
) -> tuple[UInt8[np.ndarray, "h w 3"], Bool[np.ndarray, "h w"] | None]:
    """Decode, and average over boxes of pixels down to `width` x `height`.

    A transparent image is composited `over` that colour (each in [0, 1]). With None its colours
    are left alone and the second result says which pixels are opaque throughout.
    """
    with open_image(path) as image:
        try:
            image.load()
            if not _has_alpha(image):
                return np.asarray(_boxed(as_rgb(image), width, height)), None
            rgba = image.convert("RGBA")
        except PIL_ERRORS as error:
            raise InputError(f"{path} cannot be decoded ({error})") from error
    alpha = rgba.getchannel("A")
    if over is None:
        return np.asarray(_boxed(rgba.convert("RGB"), width, height)), _solid(alpha, width, height)
    paper = Image.new("RGB", rgba.size, tuple(round(255 * channel) for channel in over))
    return np.asarray(
        _boxed(Image.composite(rgba.convert("RGB"), paper, alpha), width, height)
    ), None


def read_mask(path: Path, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """True where the mask is white (over half) in all that the pixel covers."""
    with open_image(path) as image:
        try:
            return _solid(image.convert("L"), width, height)
        except PIL_ERRORS as error:
            raise InputError(f"{path} cannot be decoded ({error})") from error


def list_images(folder: Path) -> list[Path]:
    """The image files directly in `folder`, sorted by name; none if there is no such folder."""
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)


def reduced_files(
    folder: Path, names: Iterable[str], downscale: int | None
) -> dict[str, Path] | None:
    """Photos that someone already reduced: `images_4/` beside `images/`, for a factor of 4.

    Files are matched by name, or, where the reduced ones are named otherwise, by their place in
    sorted order if both folders hold as many. None if there is no usable folder.
    """
    beside = folder.with_name(f"{folder.name}_{downscale}")
    if downscale is None or downscale == 1 or not beside.is_dir():
        return None
    names = list(names)
    if all(is_file(beside / name) for name in names):
        return {name: beside / name for name in names}
    full, small = list_images(folder), list_images(beside)
    ranks = {path.name: rank for rank, path in enumerate(full)}
    if len(full) != len(small) or not ranks.keys() >= set(names):
        return None
    return {name: small[ranks[name]] for name in names}


def _has_alpha(image: Image.Image) -> bool:
    return image.mode in ("RGBA", "LA", "PA", "RGBa", "La") or "transparency" in image.info


def as_rgb(image: Image.Image) -> Image.Image:
    """The picture with three channels of 8 bits; transparency is dropped."""
    if image.mode.startswith("I;16"):  # 16-bit grey, which convert() would clip to white
        image = Image.fromarray((np.asarray(image).astype(np.uint16) >> 8).astype(np.uint8))
    return image.convert("RGB")


def _boxed(image: Image.Image, width: int, height: int) -> Image.Image:
    """Area average, rounded once.

    PIL's own box filter takes whole pixels only, and rounds up twice: half a level too bright.
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
    """How much of each of `cells` equal parts of a line of `size` pixels each pixel makes up."""
    borders = np.arange(cells + 1) * (size / cells)
    cuts = np.union1d(borders, np.arange(size + 1))
    middle, share = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts) * (cells / size)
    part = np.searchsorted(borders, middle).clip(1, cells) - 1
    pixel = middle.astype(np.int64).clip(0, size - 1)
    return csr_array((share.astype(np.float32), (part, pixel)), shape=(cells, size))


def _solid(image: Image.Image, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    white = Image.fromarray(np.where(np.asarray(image) >= 128, 255, 0).astype(np.uint8))
    return np.asarray(_boxed(white, width, height)) == 255
