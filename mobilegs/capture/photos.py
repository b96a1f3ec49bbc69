"""Converts photos of cameras and phones into upright JPEG or PNG photos of a limited size."""

import math
import re
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from os.path import commonpath
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import torch
from jaxtyping import Bool
from PIL import Image, ImageOps

from mobilegs.atomic import atomic_path, make_folder, reading
from mobilegs.camera import Camera
from mobilegs.data import images, masks
from mobilegs.data.dataset import undistorted
from mobilegs.data.pinhole_views import panorama_views
from mobilegs.errors import InputError
from mobilegs.extras import extra_module
from mobilegs.progress_display import Advance

HEIC = (".heic", ".heif")
RAW = (".dng", ".cr2", ".cr3", ".nef", ".arw", ".orf", ".rw2", ".raf", ".pef", ".srw")
PHOTOS = images.SUFFIXES + HEIC + RAW
HEIC_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1")
# folders that hold no photos to reconstruct from; also those with a file that we write
OTHER_FOLDERS = ("depth", "depths", "sparse", "colmap", "__macosx")
OUR_FILES = ("config.json", "capture.json", "photos.json")
LOSSLESS = (".png", ".tif", ".tiff", ".bmp")  # become PNG; others become JPEG
JPEG_QUALITY = 97  # high, because undistortion decodes and encodes the photo once more
PHOTOS_MIN = 3

_ORIENTATION, _MAKE, _MODEL = 0x112, 0x10F, 0x110
_FOCAL, _FOCAL_35MM = 0x920A, 0xA405
_DIAGONAL_35MM = math.hypot(36, 24)


@dataclass(frozen=True)
class PreparedPhoto:
    """A photo that is ready for reconstruction.

    Attributes:
        name: of its file in `work/photos` and in the finished capture; with a folder for photos
            of a rig and for faces of panoramas.
        source: name of the original file, below the folder that all of them share.
        width, height: in pixels, upright.
        focal: focal length in pixels, from EXIF; None if unknown.
        lens: photos of the same lens and size share a camera.
        sphere: whether the file says that it is a panorama of the whole sphere.
        exposure: `images.exposure_of` the original; None if unknown.
    """

    name: str
    source: str
    width: int
    height: int
    focal: float | None = None
    lens: str = ""
    sphere: bool = False
    exposure: float | None = None


def list_photos(path: Path) -> list[Path]:
    """Return the photos below `path/images`, or else below `path`, sorted by path.

    Names that start with a dot are ignored: macOS adds such a file to each photo. So are folders
    of masks, depths and models, and those that this program wrote.
    """
    for folder in (path / "images", path):
        photos = [file for file in _files(folder) if file.suffix.lower() in PHOTOS]
        if photos:
            return masks.without_masks(photos)
    return []


def other_files(photos: list[Path]) -> dict[str, int]:
    """Return the files beside `photos` that are no photos: their number by suffix."""
    counts: dict[str, int] = {}
    for folder in sorted({photo.parent for photo in photos}):
        for file in sorted(each for each in folder.iterdir() if each.is_file()):
            kind = file.suffix.lower() or file.name
            if kind not in PHOTOS and file.name[0] != ".":
                counts[kind] = counts.get(kind, 0) + 1
    return counts


def _files(folder: Path) -> list[Path]:
    """Return the files in a folder and in the folders in it, sorted."""
    if not folder.is_dir():
        return []
    files = []
    for each in sorted(folder.iterdir()):
        if each.name[0] == ".":
            continue
        if each.is_file():
            files.append(each)
        elif each.name.lower() not in OTHER_FOLDERS and not each.is_symlink():
            ours = any((each / name).is_file() for name in OUR_FILES)
            if not ours and not masks.is_mask_folder(each.name):
                files += _files(each)
    return files


def relative_names(sources: list[Path]) -> list[str]:
    """Return the path of each photo below the folder that all of them share."""
    root = Path(commonpath([source.parent for source in sources]))
    return [source.relative_to(root).as_posix() for source in sources]


def prepared_names(sources: list[Path], *, rig: bool = False) -> dict[Path, str]:
    """Return the name of each photo in the capture, without characters that COLMAP cannot read.

    Photos in several folders have the folders in their names; with `rig`, the photo left/1.jpg
    stays in the folder left. Raises InputError if two photos would have the same name.
    """
    names: dict[Path, str] = {}
    taken: dict[str, Path] = {}
    for source, relative in zip(sources, relative_names(sources), strict=True):
        place = PurePosixPath(relative).with_suffix("")
        parts = (place.parent.as_posix(), place.name) if rig else (place.as_posix(),)
        stem = "/".join(re.sub(r"[^\w.()+-]", "_", part) for part in parts)
        if stem in taken:
            raise InputError(
                f"{taken[stem].name} and {source.name} in {source.parent} have the same name: "
                "keep one of them, or rename it"
            )
        taken[stem] = source
        names[source] = f"{stem}.png" if source.suffix.lower() in LOSSLESS else f"{stem}.jpg"
    return names


def prepare_photos(
    sources: list[Path],
    folder: Path,
    *,
    max_size: int,
    progress: Advance,
    rig: bool = False,
    panorama: bool = False,
    masks_of: Mapping[Path, Path] | None = None,
) -> dict[str, Any]:
    """Write every photo upright, with a longer side of at most `max_size` pixels, to `folder`.

    Existing files stay. A JPEG that needs no change is copied. With `panorama` the faces of each
    photo are written instead. Masks, by `masks_of` and of transparent photos, go to the folder
    `masks` beside `folder`, as a.jpg.png for a.jpg: COLMAP's spelling. Returns the record
    `{"photos": [PreparedPhoto as a dict, ...], "unreadable": [sentence, ...]}`: photos that are
    damaged or masked nearly whole are left out. Raises InputError for two photos of the same name,
    and if more photos are left out than not.
    """
    make_folder(folder)
    prepared, damaged, read = [], [], 0
    names = prepared_names(sources, rig=rig).values()
    files = zip(sources, names, relative_names(sources), strict=True)
    for done, (source, name, original) in enumerate(files, start=1):
        mask = (masks_of or {}).get(source)
        try:
            if panorama:
                photos = prepare_panorama(source, folder, name, max_size=max_size, mask=mask)
            else:
                mask_target = mask_file(folder, name)
                photo = prepare_photo(
                    source, folder / name, max_size=max_size, mask=mask, mask_target=mask_target
                )
                photos = [replace(photo, name=name)]
            prepared += [asdict(replace(photo, source=original)) for photo in photos]
            read += 1
        except InputError as error:
            damaged.append(str(error))
        progress(done, len(sources))
    if read < max(PHOTOS_MIN, len(damaged)):
        raise InputError(damaged[0])
    return {"photos": prepared, "unreadable": damaged}


def prepare_photo(
    source: Path,
    target: Path,
    *,
    max_size: int,
    mask: Path | None = None,
    mask_target: Path | None = None,
) -> PreparedPhoto:
    """Write one photo to `target`, unless it exists, and return its size, focal length and lens.

    Its mask, of the file `mask` and of its transparency, goes to `mask_target`. Raises InputError
    if it cannot be read, or is masked nearly whole.
    """
    with open_photo(source) as image, images.decoding(source):
        exif = image.getexif()
        details = exif.get_ifd(images.EXIF)
        exposure = images.exposure_of(image)
        sphere = b"equirectangular" in _xmp(image)
        if not target.exists():
            image.load()  # raises for a photo that is cut off
            size = fitted(*image.size, max_size)
            used = masks.upright_mask(source, image, mask, size)
            if used is not None and mask_target is not None:
                save_mask(used, mask_target)
            if target.suffix == ".jpg" and is_ready(image, max_size):
                with atomic_path(target) as temporary:
                    shutil.copyfile(source, temporary)
            else:
                save_photo(reduced(upright(image), max_size), target)
    width, height = images.image_size(target)
    focal = images.exif_number(details.get(_FOCAL_35MM))
    focal = focal * math.hypot(width, height) / _DIAGONAL_35MM if focal else None
    own_focal = images.exif_number(details.get(_FOCAL))
    made_by = [exif.get(_MAKE), exif.get(_MODEL), own_focal, focal]
    lens = " ".join(str(part).strip("\0 ") for part in made_by if part)
    return PreparedPhoto(target.name, source.name, width, height, focal, lens, sphere, exposure)


def prepare_panorama(
    source: Path, folder: Path, name: str, *, max_size: int, mask: Path | None = None
) -> list[PreparedPhoto]:
    """Write the faces of a panorama. Raises InputError if it is none, or cannot be read."""
    with open_photo(source) as image, images.decoding(source):
        used = masks.upright_mask(source, image, mask, fitted(*image.size, 4 * max_size))
        picture = upright(image)
    return save_faces(picture, folder, name, source=source, max_size=max_size, used=used)


def save_faces(
    picture: Image.Image,
    folder: Path,
    name: str,
    *,
    source: Path,
    max_size: int,
    used: Bool[np.ndarray, "h w"] | None = None,
) -> list[PreparedPhoto]:
    """Write the six faces of a panorama to `folder / face / name`, unless they exist.

    `used` is the panorama's mask, from which those of the faces are made.

    A face is a quarter as wide as the panorama, and at most `max_size`. Raises InputError, which
    begins with `source`, if the picture is no panorama of the whole sphere.
    """
    side = max(1, min(picture.width // 4, max_size))
    anywhere = Camera(torch.eye(4), torch.eye(3), *picture.size)
    views = panorama_views(str(source), anywhere, picture.size, side)
    missing = [view for view in views if not (folder / view.face / name).exists()]
    for view in missing:
        assert view.photo is not None
        size = (view.photo.width, view.photo.height)
        picture = picture if picture.size == size else picture.resize(size)
        pixels = torch.from_numpy(np.array(picture))
        mask = None if used is None else torch.from_numpy(images.all_of(used, *size))
        face, seen = undistorted(pixels, mask, view.photo, view.camera)
        if mask is not None:
            save_mask(seen.numpy(), mask_file(folder, f"{view.face}/{name}"))
        save_photo(Image.fromarray(face.numpy()), folder / view.face / name)
    return [
        PreparedPhoto(f"{view.face}/{name}", source.name, side, side, side / 2) for view in views
    ]


def upright(image: Image.Image) -> Image.Image:
    """Return a photo as its EXIF orientation says, as RGB without transparency."""
    return images.as_rgb(ImageOps.exif_transpose(image))


def _xmp(image: Image.Image) -> bytes:
    """Return the XMP metadata of a photo, where 360-degree cameras name the projection."""
    xmp = image.info.get("xmp", b"")
    return xmp if isinstance(xmp, bytes) else b""


def open_photo(path: Path) -> Image.Image:
    """Open a photo by its content. HEIC photos and camera raws are decoded and already upright.

    Raises InputError if it is not an image, or needs a library that is not installed.
    """
    if path.suffix.lower() in RAW:
        return _open_raw(path)
    with reading(path), path.open("rb") as file:
        head = file.read(12)
    if head[4:8] != b"ftyp" or head[8:12] not in HEIC_BRANDS:
        return images.open_image(path)
    needed = f"{path} is HEIC: export the photos as JPEG, or use pi-heif"
    pi_heif = extra_module("pi_heif", needed, "capture")
    try:
        return pi_heif.open_heif(path).to_pillow()
    except (*images.PIL_ERRORS, RuntimeError) as error:
        raise InputError(f"{path} cannot be read as an image ({error})") from error


def _open_raw(path: Path) -> Image.Image:
    """Develop a camera raw with the white balance of the camera."""
    needed = f"{path} is a camera raw: export the photos as JPEG, or use rawpy"
    rawpy = extra_module("rawpy", needed, "raw")
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


def mask_file(folder: Path, name: str) -> Path:
    """Return the file of the mask of a photo in `folder`, in the folder `masks` beside it."""
    return folder.with_name("masks") / f"{name}.png"


def save_mask(used: Bool[np.ndarray, "h w"], path: Path) -> None:
    """Write a mask, white where the photo is used, unless all of it is."""
    if not used.all():
        save_photo(Image.fromarray(used.astype(np.uint8) * 255), path)


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
