"""Photos as cameras and phones leave them -> upright ones of the size that is reconstructed."""

import math
import re
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from PIL import Image, ImageOps

from mobilegs.atomic import atomic_path, make_folder
from mobilegs.capture.engine import INSTALL, Progress
from mobilegs.data import images
from mobilegs.errors import InputError

HEIC = (".heic", ".heif")
LOSSLESS = (".png", ".tif", ".tiff", ".bmp")  # become PNG; all others become JPEG
QUALITY = 97  # of JPEG on the way; what is written in the end is decoded once more
FEWEST = 3  # photos

_ORIENTATION, _EXIF, _MAKE, _MODEL = 0x112, 0x8769, 0x10F, 0x110
_FOCAL, _FOCAL_35MM = 0x920A, 0xA405
_DIAGONAL_35MM = math.hypot(36, 24)


@dataclass(frozen=True)
class Prepared:
    """A photo that can be reconstructed.

    Attributes:
        name: of its file in `work/photos`, and of what the capture will hold.
        source: name of the file that it was made from.
        width, height: in pixels, as it is to be looked at.
        focal: in pixels, from EXIF; None where EXIF does not say.
        lens: photos of the same lens and size share a camera.
    """

    name: str
    source: str
    width: int
    height: int
    focal: float | None = None
    lens: str = ""


def list_photos(path: Path) -> list[Path]:
    """The photos in `path/images`, or else in `path` itself, by name; none if there are none.

    Names that begin with a dot are not photos: macOS leaves such a file beside each of them.
    """
    for folder in (path / "images", path):
        if folder.is_dir():
            found = [
                file
                for file in folder.iterdir()
                if file.suffix.lower() in images.SUFFIXES + HEIC and file.name[0] != "."
            ]
            if found:
                return sorted(found)
    return []


def prepared_names(sources: list[Path]) -> dict[Path, str]:
    """The name of each photo in the capture: its own, of letters that COLMAP's lists can hold.

    InputError where two photos would have the same.
    """
    names: dict[Path, str] = {}
    taken: dict[str, Path] = {}
    for source in sources:
        stem = re.sub(r"[^\w.()+-]", "_", source.stem)
        if stem in taken:
            raise InputError(
                f"{taken[stem].name} and {source.name} in {source.parent} have the same name: "
                "keep one of them, or rename it"
            )
        taken[stem] = source
        names[source] = f"{stem}.png" if source.suffix.lower() in LOSSLESS else f"{stem}.jpg"
    return names


def prepare_photos(
    sources: list[Path], folder: Path, *, max_size: int, progress: Progress
) -> dict[str, Any]:
    """Write every photo upright and at most `max_size` pixels long into `folder`.

    Those that are there already stay. A JPEG that needs no change is copied byte by byte.
    Returns the record `{"photos": [Prepared, ...]}`. Raises InputError for too few photos, for
    two of the same name, and for one that cannot be read.
    """
    if len(sources) < FEWEST:
        raise InputError(
            f"{sources[0].parent} holds {len(sources)} photo{'s' * (len(sources) > 1)}: a scene "
            f"needs {FEWEST} at least, and 30 or more to look good"
        )
    make_folder(folder)
    found = []
    for done, (source, name) in enumerate(prepared_names(sources).items(), start=1):
        found.append(asdict(prepare_photo(source, folder / name, max_size=max_size)))
        progress(done, len(sources))
    return {"photos": found}


def prepare_photo(source: Path, target: Path, *, max_size: int) -> Prepared:
    """Write one photo, unless it is there, and say what was found about it."""
    image = open_photo(source)
    try:
        with image:
            exif = image.getexif()
            details = exif.get_ifd(_EXIF)
            if not target.exists():
                if is_ready(image, max_size):
                    with atomic_path(target) as temporary:
                        shutil.copyfile(source, temporary)
                else:
                    picture = images.as_rgb(ImageOps.exif_transpose(image))
                    save_photo(reduced(picture, max_size), target)
    except images.PIL_ERRORS as error:
        raise InputError(f"{source} cannot be decoded ({error})") from error
    width, height = images.image_size(target)
    focal = number(details.get(_FOCAL_35MM))
    focal = focal * math.hypot(width, height) / _DIAGONAL_35MM if focal else None
    made_by = [exif.get(_MAKE), exif.get(_MODEL), number(details.get(_FOCAL)), focal]
    lens = " ".join(str(part).strip("\0 ") for part in made_by if part)
    return Prepared(target.name, source.name, width, height, focal, lens)


def open_photo(path: Path) -> Image.Image:
    """A photo, its header read; those of HEIC are decoded, and upright already.

    Raises InputError if it is none, or HEIC and pi-heif is missing.
    """
    if path.suffix.lower() not in HEIC:
        return images.open_image(path)
    try:
        import pi_heif
    except ImportError:
        raise InputError(
            f"{path} is HEIC, which needs pi-heif, and that is not installed: {INSTALL}; or "
            "export the photos as JPEG"
        ) from None
    try:
        return pi_heif.open_heif(path).to_pillow()
    except (*images.PIL_ERRORS, RuntimeError) as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error


def save_photo(picture: Image.Image, path: Path) -> None:
    """Write a picture, as PNG or JPEG by its suffix, without EXIF."""
    with atomic_path(path) as temporary:
        if path.suffix == ".png":
            picture.save(temporary, format="PNG", compress_level=1)
        else:
            picture.save(temporary, format="JPEG", quality=QUALITY, subsampling=0)


def fitted(width: int, height: int, longest: int) -> tuple[int, int]:
    """The size, reduced so that its longer side has at most `longest` pixels."""
    factor = min(1.0, longest / max(width, height))
    return max(1, round(width * factor)), max(1, round(height * factor))


def reduced(picture: Image.Image, longest: int) -> Image.Image:
    """The picture with at most `longest` pixels on its longer side."""
    return picture.resize(fitted(*picture.size, longest), Image.Resampling.LANCZOS)


def is_ready(image: Image.Image, longest: int) -> bool:
    """Whether a photo can be used byte by byte: an upright JPEG in colour, small enough."""
    plain = image.format == "JPEG" and image.mode == "RGB" and max(image.size) <= longest
    return plain and image.getexif().get(_ORIENTATION, 1) not in range(2, 9)


def number(value: Any) -> float:
    """What EXIF holds as a number, 0 where that is none."""
    try:
        found = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return 0.0
    return found if 0 < found < 1e5 else 0.0
