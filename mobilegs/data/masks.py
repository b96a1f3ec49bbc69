"""Masks of photos: the names that other tools give them, and their pixels."""

import logging
import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePosixPath

import numpy as np
from jaxtyping import Bool
from PIL import Image, ImageOps

from mobilegs.data import images
from mobilegs.errors import InputError

SUFFIXES = (*images.SUFFIXES, ".gif", ".mask")  # Brush has NAME.ext.mask; GIF is refused by name
SHARE_MIN = 0.01  # of a photo's pixels that its mask leaves
RULE = "what is black (0) in a mask, or transparent in a photo, is left out"
INVERTED = "dynamic_mask_"  # of instant-ngp, which leaves out what is not 0
_OF_PHOTOS = (*images.SUFFIXES, ".heic", ".heif")
LOSSY = ("JPEG", "WEBP", "AVIF")
ORIENTATION = 0x112  # tag of EXIF
_FOLDER = re.compile(r"[._]?masks?(_\d+)?", re.IGNORECASE)  # .mask of RealityCapture; masks_4
_BESIDE = re.compile(rf"{INVERTED}(.+)|(.+)[._]mask", re.IGNORECASE)  # without the suffix
log = logging.getLogger(__name__)


def is_mask_folder(name: str) -> bool:
    """Return whether a folder is called masks, mask, .mask, _mask or masks_2, in any case."""
    return _FOLDER.fullmatch(name) is not None


def photo_of(name: str) -> str | None:
    """Return the name of the photo for which a file beside it would be a mask, else None.

    The name is `a` for a_mask.png, a.mask.png and dynamic_mask_a.png, and `a.jpg` for
    a.jpg.mask.png and a.jpg.png.
    """
    stem = PurePosixPath(name).stem
    spelled = _BESIDE.fullmatch(stem)
    if spelled is None:
        return stem if PurePosixPath(stem).suffix.lower() in _OF_PHOTOS else None
    return spelled[1] or spelled[2]


def without_masks(files: Sequence[Path]) -> list[Path]:
    """Return the files that are not masks of others of them by their names."""
    photos = {spelling for file in files for spelling in _spellings(file.as_posix())}

    def is_mask(file: Path) -> bool:
        photo = photo_of(file.name)
        return photo is not None and not photos.isdisjoint(
            (file.with_name(photo).as_posix(), _folded(file.with_name(photo).as_posix()))
        )

    return [file for file in files if not is_mask(file)]


def find_masks(
    photos: Sequence[Path], top: Path, named: Mapping[Path, Path] | None = None
) -> dict[Path, Path]:
    """Return the masks of photos that have one, by photo; `top` is a folder above all of them.

    Those that are `named` stay. Others are in a folder of masks or beside the photo. Such folders
    are looked for from the photo's folder up to `top`; folders in them are those of the photos.
    Case, Unicode form and suffix may differ. One warning counts photos without a mask and masks
    without a photo.
    """
    folders: dict[Path, dict[str, Path]] = {}
    beside = [file for folder in {file.parent for file in photos} for file in _files(folder)]
    found = dict(named or {})
    for photo in dict.fromkeys([*photos, *beside]):
        mask = found.get(photo) or _mask_of(photo, top, folders)
        if mask is not None:
            found[photo] = mask
    used = set(found.values())
    masks = {mask for names in folders.values() for mask in names.values()}
    _report(photos, found, sorted(masks - used), top)
    for each in (each for folder in folders for each in _entries(folder)):
        if "mask" in each.name.lower() and not is_mask_folder(each.name) and _files(each):
            log.warning("the folder %s is not read: masks are in a folder called masks", each)
    return {photo: found[photo] for photo in photos if photo in found}


def _report(
    photos: Sequence[Path], found: dict[Path, Path], others: Sequence[Path], top: Path
) -> None:
    """Say in one warning which photos have no mask, and which masks belong to no photo."""
    with_photos = {mask.parent for mask in found.values()}
    # masks of another list of photos are in a folder of their own
    others = [mask for mask in others if mask.parent in with_photos or not found]
    missing = [photo for photo in photos if photo not in found]
    inverted = sum(found[photo].name.lower().startswith(INVERTED) for photo in found)
    said = []
    if missing and (found or others):
        said.append(f"{len(missing)} of {len(photos)} photos have none, such as {missing[0].name}")
    if others:
        said.append(f"{len(others)} belong to no photo, such as {others[0].name}")
    if inverted:
        said.append(f"{inverted} named {INVERTED}NAME leave out what is white, as in instant-ngp")
    if said:
        log.warning("masks in %s: %s", top, "; ".join(said))


def _mask_of(photo: Path, top: Path, folders: dict[Path, dict[str, Path]]) -> Path | None:
    """Return the mask of a photo; `folders` keeps the masks of each folder."""
    above = [folder for folder in photo.parents if folder == top or top in folder.parents]
    for folder in above or [photo.parent]:
        if folder not in folders:
            folders[folder] = _masks_in(folder)
        place = photo.relative_to(folder)
        places = [place, Path(*place.parts[1:])] if len(place.parts) > 1 else [place]
        for spelling in (each for place in places for each in _spellings(place.as_posix())):
            mask = folders[folder].get(spelling)
            if mask is not None and mask != photo:
                return mask
    return None


def _masks_in(folder: Path) -> dict[str, Path]:
    """Return the masks in a folder of photos and in its folders of masks, by spellings."""
    within: list[tuple[str, Path]] = []
    beside: list[tuple[str, Path]] = []
    for each in sorted(_entries(folder), key=lambda path: len(path.name)):  # masks before masks_2
        if is_mask_folder(each.name) and each.is_dir():
            for file in sorted(each.rglob("*")):
                if file.suffix.lower() in SUFFIXES and file.name[0] != ".":
                    name = file.relative_to(each)
                    within.append((name.with_suffix("").as_posix(), file))
                    if (photo := photo_of(name.name)) is not None:
                        beside.append((name.with_name(photo).as_posix(), file))
        elif each.suffix.lower() in SUFFIXES and (photo := photo_of(each.name)) is not None:
            beside.append((photo, each))
    masks: dict[str, Path] = {}
    spellings: tuple[Callable[[str], str], ...] = (str, _folded)
    for spelled in spellings:
        for name, file in (*within, *beside):
            masks.setdefault(spelled(name), file)
    return masks


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _files(folder: Path) -> list[Path]:
    return [path for path in _entries(folder) if path.suffix.lower() in images.SUFFIXES]


def _spellings(name: str) -> tuple[str, ...]:
    """Return the name of a photo as masks have it, the most exact spelling first."""
    stem = PurePosixPath(name).with_suffix("").as_posix()
    return name, stem, _folded(name), _folded(stem)


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


def read_mask(path: Path, width: int, height: int) -> Bool[np.ndarray, "h w"]:
    """Return a mask resized to `width` x `height`, True where all pixels averaged are used.

    `used_pixels` says which are. Raises `InputError` if the file cannot be decoded.
    """
    return images.all_of(used_pixels(path), width, height)


def used_pixels(path: Path) -> Bool[np.ndarray, "h w"]:
    """Return where a mask says that its photo is used, at the size of the mask.

    What is not 0 is used, as in COLMAP and nerfstudio; in a lossy file, what exceeds half of its
    brightest value. Transparency that varies decides instead of colours. A palette counts by its
    colours, or by its indices if the colours are all used or all not. The masks `dynamic_mask_NAME`
    of instant-ngp say the opposite. Raises `InputError` if the file cannot be decoded.
    """
    with images.open_image(path) as image, images.decoding(path):
        image.load()
        used = _used(image)
    return ~used if path.name.lower().startswith(INVERTED) else used


def _used(image: Image.Image) -> Bool[np.ndarray, "h w"]:
    if images.is_transparent(image):
        alpha = np.asarray(image.convert("RGBA").getchannel("A"))
        if alpha.min() < alpha.max():
            return alpha > 0
    values = np.asarray(image)
    if image.mode != "1" and image.mode[0] not in "LIF":
        values = np.asarray(image.convert("RGB")).max(axis=2)
    elif values.ndim == 3:
        values = values[:, :, 0]
    used = values > (values.max() / 2 if image.format in LOSSY else 0)
    if image.mode == "P" and (used.all() or not used.any()):
        indices = np.asarray(image) > 0
        return used if indices.all() or not indices.any() else indices
    return used


def upright_mask(
    where: Path, photo: Image.Image, mask: Path | None, size: tuple[int, int]
) -> Bool[np.ndarray, "h w"] | None:
    """Return where a photo is used after its transparency and its mask, upright; None: all of it.

    `size` (width, height) is that to which the photo is reduced, before EXIF turns it. A mask is
    turned as well, unless it is upright already. Raises `InputError`, which names `where`, for a
    mask of another aspect ratio, one that cannot be decoded, and if less than 1 % of the photo is
    left.
    """
    used = []
    if images.is_transparent(photo):
        used.append(np.asarray(photo.convert("RGBA").getchannel("A")) >= images.OPAQUE)
    if mask is not None:
        used.append(used_pixels(mask))
    if not used:
        return None
    turn = photo.getexif().get(ORIENTATION, 1)
    upright = []
    for each in used:
        shape = each.shape[1], each.shape[0]
        if images.same_shape(shape, photo.size):
            image = Image.fromarray(images.all_of(each, *size))
            image.getexif()[ORIENTATION] = turn
            upright.append(np.asarray(ImageOps.exif_transpose(image)))
        elif images.same_shape(shape, (photo.height, photo.width)) and turn in (5, 6, 7, 8):
            upright.append(images.all_of(each, *size[::-1]))
        else:
            raise InputError(f"mask {mask} has another aspect ratio than its photo {where}")
    left = np.logical_and.reduce(upright)
    if left.mean() < SHARE_MIN:
        raise InputError(f"{where} is masked nearly whole: {RULE}")
    return left
