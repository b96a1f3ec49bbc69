"""Converts photos of cameras and phones into upright JPEG or PNG photos of a limited size."""

import math
import re
import shutil
from dataclasses import asdict, dataclass
from os.path import commonpath
from pathlib import Path
from typing import Any

from PIL import Image, ImageOps

from mobilegs.atomic import atomic_path, make_folder
from mobilegs.capture.pycolmap_runtime import INSTALL, Progress
from mobilegs.data import images
from mobilegs.errors import InputError

HEIC = (".heic", ".heif")
RAW = (".dng", ".cr2", ".cr3", ".nef", ".arw", ".orf", ".rw2", ".raf", ".pef", ".srw")
PHOTOS = images.SUFFIXES + HEIC + RAW
HEIC_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1")
# folders that hold no photos to reconstruct from; also those with a file that we write
OTHER_FOLDERS = ("masks", "mask", "depth", "depths", "sparse", "colmap", "__macosx")
OUR_FILES = ("config.json", "capture.json")
LOSSLESS = (".png", ".tif", ".tiff", ".bmp")  # become PNG; others become JPEG
JPEG_QUALITY = 97  # high, because undistortion decodes and encodes the photo once more
PHOTOS_MIN = 3

_ORIENTATION, _EXIF, _MAKE, _MODEL = 0x112, 0x8769, 0x10F, 0x110
_FOCAL, _FOCAL_35MM = 0x920A, 0xA405
_DIAGONAL_35MM = math.hypot(36, 24)


@dataclass(frozen=True)
class PreparedPhoto:
    """A photo that is ready for reconstruction.

    Attributes:
        name: of its file in `work/photos` and in the finished capture.
        source: name of the original file.
        width, height: in pixels, upright.
        focal: focal length in pixels, from EXIF; None if unknown.
        lens: photos of the same lens and size share a camera.
    """

    name: str
    source: str
    width: int
    height: int
    focal: float | None = None
    lens: str = ""


def list_photos(path: Path) -> list[Path]:
    """Return the photos below `path/images`, or else below `path`, sorted by path.

    Names that start with a dot are ignored: macOS adds such a file to each photo. So are folders
    of masks, depths and models, and those that this program wrote.
    """
    for folder in (path / "images", path):
        found = [file for file in _files(folder) if file.suffix.lower() in PHOTOS]
        if found:
            return found
    return []


def other_files(photos: list[Path]) -> dict[str, int]:
    """Return the files beside `photos` that are no photos: their number by suffix."""
    found: dict[str, int] = {}
    for folder in sorted({photo.parent for photo in photos}):
        for file in sorted(each for each in folder.iterdir() if each.is_file()):
            kind = file.suffix.lower() or file.name
            if kind not in PHOTOS and file.name[0] != ".":
                found[kind] = found.get(kind, 0) + 1
    return found


def _files(folder: Path) -> list[Path]:
    """Return the files in a folder and in the folders in it, sorted."""
    if not folder.is_dir():
        return []
    found = []
    for each in sorted(folder.iterdir()):
        if each.name[0] == ".":
            continue
        if each.is_file():
            found.append(each)
        elif each.name.lower() not in OTHER_FOLDERS and not each.is_symlink():
            if not any((each / name).is_file() for name in OUR_FILES):
                found += _files(each)
    return found


def prepared_names(sources: list[Path]) -> dict[Path, str]:
    """Return the name of each photo in the capture, without characters that COLMAP cannot read.

    Photos in several folders have the folders in their names. Raises InputError if two photos would
    have the same name.
    """
    names: dict[Path, str] = {}
    taken: dict[str, Path] = {}
    root = Path(commonpath([source.parent for source in sources]))
    for source in sources:
        place = source.relative_to(root).with_suffix("").as_posix()
        stem = re.sub(r"[^\w.()+-]", "_", place)
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
    """Write every photo upright, with a longer side of at most `max_size` pixels, to `folder`.

    Existing files stay. A JPEG that needs no change is copied. Returns the record
    `{"photos": [PreparedPhoto as a dict, ...], "unreadable": [sentence, ...]}`: damaged photos are
    left out. Raises InputError for two photos of the same name, and if more photos are damaged
    than not.
    """
    make_folder(folder)
    found, damaged = [], []
    for done, (source, name) in enumerate(prepared_names(sources).items(), start=1):
        try:
            found.append(asdict(prepare_photo(source, folder / name, max_size=max_size)))
        except InputError as error:
            damaged.append(str(error))
        progress(done, len(sources))
    if len(found) < max(PHOTOS_MIN, len(damaged)):
        raise InputError(damaged[0])
    return {"photos": found, "unreadable": damaged}


def prepare_photo(source: Path, target: Path, *, max_size: int) -> PreparedPhoto:
    """Write one photo to `target`, unless it exists, and return its size, focal length and lens.

    Raises InputError if it cannot be read.
    """
    image = open_photo(source)
    try:
        with image:
            exif = image.getexif()
            details = exif.get_ifd(_EXIF)
            if not target.exists():
                image.load()  # raises for a photo that is cut off
                if target.suffix == ".jpg" and is_ready(image, max_size):
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
    return PreparedPhoto(target.name, source.name, width, height, focal, lens)


def open_photo(path: Path) -> Image.Image:
    """Open a photo by its content. HEIC photos and camera raws are decoded and already upright.

    Raises InputError if it is not an image, or needs a library that is not installed.
    """
    if path.suffix.lower() in RAW:
        return _open_raw(path)
    try:
        with path.open("rb") as file:
            head = file.read(12)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from error
    if head[4:8] != b"ftyp" or head[8:12] not in HEIC_BRANDS:
        return images.open_image(path)
    try:
        import pi_heif
    except ImportError:
        raise InputError(
            f"{path} is HEIC, which needs pi-heif, which is not installed: {INSTALL}; or "
            "export the photos as JPEG"
        ) from None
    try:
        return pi_heif.open_heif(path).to_pillow()
    except (*images.PIL_ERRORS, RuntimeError) as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error


def _open_raw(path: Path) -> Image.Image:
    """Develop a camera raw with the white balance of the camera."""
    try:
        import rawpy
    except ImportError:
        raise InputError(
            f"{path} is a camera raw, which needs rawpy: pip install 'mobilegs[raw]', or export "
            "the photos as JPEG"
        ) from None
    try:
        with rawpy.imread(str(path)) as raw:
            return Image.fromarray(raw.postprocess(use_camera_wb=True, output_bps=8))
    except (rawpy.LibRawError, *images.PIL_ERRORS) as error:
        raise InputError(f"{path} cannot be read as a camera raw ({error})") from error


def save_photo(picture: Image.Image, path: Path) -> None:
    """Write a photo without EXIF, as PNG if the suffix says so, else as JPEG."""
    with atomic_path(path) as temporary:
        if path.suffix == ".png":
            picture.save(temporary, format="PNG", compress_level=1)
        else:
            picture.save(temporary, format="JPEG", quality=JPEG_QUALITY, subsampling=0)


def fitted(width: int, height: int, longest: int) -> tuple[int, int]:
    """Return the size, reduced so that its longer side has at most `longest` pixels."""
    factor = min(1.0, longest / max(width, height))
    return max(1, round(width * factor)), max(1, round(height * factor))


def reduced(picture: Image.Image, longest: int) -> Image.Image:
    """Return the photo with at most `longest` pixels on its longer side."""
    return picture.resize(fitted(*picture.size, longest), Image.Resampling.LANCZOS)


def is_ready(image: Image.Image, longest: int) -> bool:
    """Return whether a photo can be copied: an upright JPEG in colour, small enough."""
    plain = image.format == "JPEG" and image.mode == "RGB" and max(image.size) <= longest
    return plain and image.getexif().get(_ORIENTATION, 1) not in range(2, 9)


def number(value: Any) -> float:
    """Return an EXIF value as a number in (0, 1e5), or 0 if it is not one."""
    try:
        found = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return 0.0
    return found if 0 < found < 1e5 else 0.0
