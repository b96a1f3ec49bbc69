"""Converts photos of cameras and phones into upright JPEG or PNG photos of a limited size."""

import filecmp
import logging
import math
import re
import shutil
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from itertools import permutations, product
from os import fsencode
from os.path import commonpath, realpath
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
# folders that are not entered; also those with a file that we write
OTHER_FOLDERS = ("sparse", "colmap", "__macosx")
OUR_FILES = ("config.json", "capture.json", "photos.json")
# images that are no photos, by the name of a folder, or the first or last part of a file's name
NOT_PHOTOS = {
    "depth maps": r"(\w+_)?depths?(_?maps?|_\w+)?",
    "confidence maps": r"conf(idence)?s?(_?maps?)?",
    "normal maps": r"normals?(_?maps?|_from_\w+)?",
    "label maps": r"segmentations?|semantics?|label_?maps?",
    "thumbnails and previews": r"thumb(nail)?s?|previews?|@eadir",
    "textures": r"textures?|textured(_output)?|diffuse|albedo|basecolor|roughness|metallic",
}
# folders with the photos of another folder, as a program changed them
CHANGED = r"(corrected|undistorted|rectified|edited|enhanced)(_\w+)?|\w+_(undistorted|edited)"
# of several files of a photo in a folder, those that are not used, and endings of their names
SECOND_FORMATS = ("camera raws", "smaller versions", "edits", "HEIC photos")
SMALLER = r"[ _-]+(\(?small\)?|resized|scaled|\d+x\d+)"
EDITED = r"(-edited|~\d+)"
RAW_FOLDERS = ("raw", "raws", *(suffix[1:] for suffix in RAW))
JPEG_FOLDERS = ("jpg", "jpgs", "jpeg", "jpegs", "heic")
# camera poses that are not read: the tool that writes them, the file, and a text in it
OTHER_POSES = (
    ("Polycam", "*cameras/*.json", b'"t_00"'),
    ("3D Scanner App", "frame_*.json", b"cameraPose"),
    ("Scaniverse", "frames.pb", b""),
    ("Record3D", "metadata.json", b'"poses"'),
    ("Stray Scanner", "odometry.csv", b""),
    ("ios_logger (ARKit)", "ARposes.txt", b""),
    ("RealityScan or RealityCapture", "*.xmp", b"xcr:Rotation"),
    ("Metashape", "*.xml", b"<chunk"),
    ("OpenSfM or OpenDroneMap", "reconstruction.json", b""),
    ("Bundler", "bundle*.out", b""),
    ("VisualSFM", "*.nvm", b""),
    ("Meshroom", "*.sfm", b""),
)
LOSSLESS = (".png", ".tif", ".tiff", ".bmp")  # become PNG; others become JPEG
JPEG_QUALITY = 97  # high, because undistortion decodes and encodes the photo once more
PHOTOS_MIN = 3
SAME_LOOK = 8  # mean difference of the grey values of two versions of a photo, of 255

_ORIENTATION, _MAKE, _MODEL = 0x112, 0x10F, 0x110
_FOCAL, _FOCAL_35MM = 0x920A, 0xA405
_DIAGONAL_35MM = math.hypot(36, 24)

log = logging.getLogger(__name__)


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


def list_photos(path: Path, *, rig: bool = False) -> list[Path]:
    """Return the photos below `path/images`, or else below `path`, sorted by path.

    Of several files of one photo there is one: the largest, as the camera took it, and rather a
    JPEG than a camera raw. With `rig` the same names in several folders are several photos. Images
    that are no photos (`NOT_PHOTOS`) and second versions are counted in one logged warning; masks
    are not. Raises InputError for a folder that cannot be read.
    """
    files = list_files(path)
    photos = masks.without_masks(
        [
            file
            for file in files
            if file.suffix.lower() in PHOTOS
            and not any(map(masks.is_mask_folder, file.relative_to(path).parts[:-1]))
        ]
    )
    left_out = {photo: kind for photo in photos if (kind := _kind_by_folder(photo, path))}
    by_name = {photo: kind for photo in photos if (kind := _kind_by_name(photo))}
    for model in (file for file in files if file.suffix.lower() == ".mtl"):
        with reading(model):
            text = model.read_bytes()
        beside = [photo for photo in photos if photo.parent == model.parent]
        by_name |= {photo: "textures" for photo in beside if fsencode(photo.name) in text}
    if len(left_out | by_name) < len(photos):  # else the photos show textures or the like
        left_out |= by_name
    photos = [photo for photo in photos if photo not in left_out]
    if any(photo.is_relative_to(path / "images") for photo in photos):
        outside = [photo for photo in photos if not photo.is_relative_to(path / "images")]
        left_out |= dict.fromkeys(outside, "images outside images/")
        photos = [photo for photo in photos if photo not in left_out]
    left_out |= _second_formats(photos)
    if not rig:
        left_out |= _second_versions([photo for photo in photos if photo not in left_out], path)
    if counts := Counter(left_out.values()):
        kinds = ", ".join(f"{kind} ({number})" for kind, number in sorted(counts.items()))
        log.warning("%s: not used as photos are %s", path, kinds)
    return [photo for photo in photos if photo not in left_out]


def list_files(path: Path) -> list[Path]:
    """Return the files below a folder, sorted by path; links are followed, but nothing met twice.

    Names that start with a dot are ignored: macOS adds such a file to each photo. So are folders
    of models, and those that this program wrote. Links that lead nowhere are returned.
    """
    entered: set[str] = set()
    found: dict[str, Path] = {}
    starts = [path]
    for start in starts:  # links come after all that is not linked
        if not start.is_dir():
            if start != path:
                found.setdefault(realpath(start) if start.exists() else str(start), start)
            continue
        folders = [start]
        for folder in folders:
            real = Path(realpath(folder))
            if str(real) in entered:
                continue
            entered.add(str(real))
            with reading(folder):
                entries = [entry for entry in folder.iterdir() if entry.name[0] != "."]
            for entry in sorted(entries):
                if entry.is_symlink():
                    if not real.is_relative_to(realpath(entry)):  # else a loop
                        starts.append(entry)
                elif entry.is_file():
                    found.setdefault(str(real / entry.name), entry)
                elif entry.is_dir() and (entry == path / "images" or not _is_other(entry)):
                    folders.append(entry)
    return sorted(found.values())


def _is_other(folder: Path) -> bool:
    """Return whether a folder is not entered: it holds a model, or this program wrote it."""
    ours = any((folder / name).is_file() for name in OUR_FILES)
    return ours or folder.name.lower() in OTHER_FOLDERS


def _kind_by_folder(photo: Path, root: Path) -> str:
    """Return the kind of an image that is no photo by the folders below `root`, or ''."""
    if not photo.is_file():
        return "links to missing files"
    folders = photo.relative_to(root).parts[:-1]
    kinds = (k for k, name in NOT_PHOTOS.items() for each in folders if _matches(name, each))
    return next(kinds, "")


def _kind_by_name(photo: Path) -> str:
    """Return the kind of an image that is no photo by its name, or ''."""
    kinds = (
        kind
        for kind, name in NOT_PHOTOS.items()
        if _matches(rf"({name})([_-].+)?|.+[._-]({name})", photo.stem)
    )
    return next(kinds, "")


def _matches(pattern: str, name: str) -> bool:
    return re.fullmatch(pattern, name, re.IGNORECASE) is not None


def _second_formats(photos: list[Path]) -> dict[Path, str]:
    """Return the files with another file of the same photo beside them, and their kind.

    A JPEG goes before HEIC, an original before an edit (IMG_E1234 is one of IMG_1234) and before a
    smaller version, and all before a camera raw, which may lie in a folder of its own (raw/1.dng).
    """
    second: dict[Path, str] = {}
    shots: dict[tuple[Path, str], list[Path]] = {}
    for photo in photos:
        name = re.sub(r"^img_e(?=\d)", "img_", photo.stem.lower())
        for ending in (SMALLER, EDITED, r"(\.raw-\d+)?(\.mp)?(\.cover|\.original)?"):
            name = re.sub(f"{ending}$", "", name)
        folder = photo.parent.name.lower()
        apart = folder in JPEG_FOLDERS or (folder in RAW_FOLDERS and photo.suffix.lower() in RAW)
        shots.setdefault((photo.parent.parent if apart else photo.parent, name), []).append(photo)
    for files in shots.values():
        ranks = {file: _rank(file) for file in files}
        for file, rank in ranks.items():
            if rank > min(ranks.values()):
                kind = SECOND_FORMATS[rank.index(True)]
                second[file] = f"{kind} beside another file of the photo"
    return second


def _rank(photo: Path) -> tuple[bool, ...]:
    """Return for each of `SECOND_FORMATS` whether a photo is one: the least is the one to use."""
    suffix = photo.suffix.lower()
    edited = _matches(rf"img_e\d+|.+{EDITED}", photo.stem)
    return suffix in RAW, _matches(f".+{SMALLER}", photo.stem), edited, suffix in HEIC


def _second_versions(photos: list[Path], root: Path) -> dict[Path, str]:
    """Return the photos that another folder has in a better version, and their kind.

    Two folders are compared by the first three names that both have.
    """
    folders: dict[Path, dict[str, Path]] = {}
    for photo in photos:
        folders.setdefault(photo.parent, {})[photo.stem.lower()] = photo
    second: dict[Path, str] = {}
    for one, other in permutations(folders, 2):
        common = sorted(folders[one].keys() & folders[other].keys())
        pairs = [(folders[one][name], folders[other][name]) for name in common[:PHOTOS_MIN]]
        if len(pairs) == PHOTOS_MIN and all(_is_second(*pair) for pair in pairs):
            kind = f"second versions in {one.relative_to(root).as_posix()}"
            second |= {folders[one][name]: kind for name in common}
    return second


def _is_second(one: Path, other: Path) -> bool:
    """Return whether `one` is a copy of `other`, smaller, changed, or in a format to avoid."""
    if one.stat().st_size == other.stat().st_size and filecmp.cmp(one, other, shallow=False):
        return one > other
    try:
        size, look = _look(one)
        other_size, other_look = _look(other)
    except InputError:  # damaged, or a library is missing: said when it is prepared
        return False
    changed, other_changed = (_matches(CHANGED, each.parent.name) for each in (one, other))
    if changed != other_changed:
        return (math.prod(size), other_changed) < (math.prod(other_size), changed)
    turned = (np.rot90(other_look, turns) for turns in range(4))  # EXIF turns photos
    if min(abs(look - each).mean() for each in turned) > SAME_LOOK:
        return False
    if size == other_size:
        return PHOTOS.index(one.suffix.lower()) > PHOTOS.index(other.suffix.lower())
    shape = size[0] * other_size[1] / (size[1] * other_size[0])
    return size < other_size and abs(shape - 1) < 0.03


def _look(photo: Path) -> tuple[list[int], np.ndarray]:
    """Return the shorter and the longer side of a photo, and 16x16 grey values in 0..255.

    The photo is as it is stored. Raises InputError if it cannot be decoded.
    """
    with open_photo(photo) as image, images.decoding(photo):
        size = sorted(image.size)
        image.draft("RGB", (64, 64))
        grey = image.convert("L").resize((16, 16), Image.Resampling.BOX)
    return size, np.asarray(grey, np.float32)


def other_poses(path: Path) -> str:
    """Return a sentence about camera poses below `path` that are not read; empty if none are."""
    for file, (tool, name, text) in product(list_files(path), OTHER_POSES):
        if file.match(name) and _holds(file, text):
            return (
                f"{path} has camera poses of {tool} in {file.relative_to(path)}, which are not "
                "read: poses are computed from the photos"
            )
    return ""


def _holds(file: Path, text: bytes) -> bool:
    """Return whether the first 64 kB of a file hold a text."""
    with reading(file), file.open("rb") as content:
        return text in content.read(2**16)


def other_files(photos: list[Path]) -> dict[str, int]:
    """Return the files beside `photos` that are no photos: their number by suffix."""
    counts: dict[str, int] = {}
    for folder in sorted({photo.parent for photo in photos}):
        for file in sorted(each for each in folder.iterdir() if each.is_file()):
            kind = file.suffix.lower() or file.name
            if kind not in PHOTOS and file.name[0] != ".":
                counts[kind] = counts.get(kind, 0) + 1
    return counts


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
