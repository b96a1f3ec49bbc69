"""Reads a capture from disk into a `Dataset`: posed photos, held-back photos, sparse points."""

import math
import os
from dataclasses import replace
from itertools import islice
from pathlib import Path

from mobilegs.atomic import read_json, read_text
from mobilegs.data import images
from mobilegs.data.colmap import BESIDE_PHOTOS, find_models, load_colmap
from mobilegs.data.dataset import Color, Dataset, Frame, View, ViewLoader, load_view
from mobilegs.data.file_names import FILES_MAX, walk_files
from mobilegs.data.nerfstudio import load_blender, load_nerfstudio
from mobilegs.errors import InputError, quoted

__all__ = ["Dataset", "Frame", "View", "ViewLoader", "has_poses", "load_capture", "load_view"]

NEAR_PLANE = "near_plane.txt"
CAPTURE_FILE = "capture.json"  # written by `mobilegs capture`
# the errors of a `CAPTURE_FILE` that is missing or says nothing
CAPTURE_FILE_ERRORS = (ValueError, LookupError, TypeError, OverflowError)
TRANSFORMS = ("transforms_train.json", "transforms.json")
# those of which COLMAP needs two, those of its features and of Metashape
POSE_FILES = (
    *TRANSFORMS, "cameras.bin", "cameras.txt", "images.bin", "images.txt", "database.db",
    "cameras.xml",
)  # fmt: skip


def has_poses(path: Path) -> bool:
    """Return whether a folder holds camera poses in a format that `load_capture` reads."""
    return bool(find_models(path)) or any((path / name).is_file() for name in TRANSFORMS)


def load_capture(
    path: Path | str,
    *,
    downscale: int | None = None,
    background: Color | None = None,
    masks: bool = True,
) -> Dataset:
    """Read a capture: a folder in the layout of COLMAP, nerfstudio or NeRF-synthetic.

    Photos are not decoded yet. A few that are gone are left out, which is logged; no name leads out
    of the folder, except through links in it. A file near_plane.txt in the folder, with one number
    in world units, replaces the near plane that follows from the spread of the cameras.

    `downscale` divides the size of the photos, and uses a folder `images_N` if it exists; None
    makes photos at most 1600 pixels wide. `background` is RGB in [0, 1]; None is white for
    transparent renders and black otherwise. `masks` False ignores the masks of the photos. Raises
    InputError if an argument is out of range, or the folder is not a valid capture.
    """
    path = Path(os.path.abspath(path))
    if downscale is not None and downscale < 1:
        raise InputError(f"downscale must be 1 or more, got {downscale}")
    if background is not None and not all(0 <= channel <= 1 for channel in background):
        raise InputError(f"the channels of a background must lie in [0, 1], got {background}")
    if not path.exists():
        raise InputError(f"there is no capture at {path}: no such folder")
    if not path.is_dir():
        raise InputError(f"{path} is a file; give the folder that holds the photos and their poses")
    if find_models(path, BESIDE_PHOTOS):
        load = load_colmap
    elif (path / "transforms_train.json").is_file():
        load = load_blender
    elif (path / "transforms.json").is_file():
        load = load_nerfstudio
    elif find_models(path):  # colmap/, from which nerfstudio makes transforms.json
        load = load_colmap
    else:
        raise InputError(_no_poses(path))
    dataset = load(path, downscale=downscale, background=background, masks=masks)
    dataset = _with_exposures(replace(dataset, name=_name_of(path)), path / CAPTURE_FILE)
    return _with_near(dataset, path / NEAR_PLANE) if (path / NEAR_PLANE).is_file() else dataset


def _name_of(path: Path) -> str:
    """Return the name of a capture: that of the photos or the video it was made from, if known.

    Else it is the folder's, or that of the folder around one called `capture`.
    """
    try:
        return Path(read_json(path / CAPTURE_FILE)["source"]).stem
    except CAPTURE_FILE_ERRORS:
        folder = path.resolve()
        return folder.parent.name if folder.name == "capture" else folder.name


def _with_exposures(dataset: Dataset, file: Path) -> Dataset:
    """Return the dataset with the exposures of photos, if the file knows that of each."""
    try:
        known = read_json(file)["exposures"]
        exposures = {name: float(known[name]) for name in known}
    except CAPTURE_FILE_ERRORS:
        return dataset
    if not all(map(math.isfinite, exposures.values())):
        return dataset

    def exposed(frames: list[Frame]) -> list[Frame]:
        return [replace(frame, exposure=exposures.get(frame.name)) for frame in frames]

    return replace(dataset, train=exposed(dataset.train), test=exposed(dataset.test))


def _with_near(dataset: Dataset, file: Path) -> Dataset:
    try:
        near = float(read_text(file)[:100])
    except ValueError:
        near = 0.0
    if not 0 < near < 1e20:
        raise InputError(
            f"{file} has no valid near plane: write one number above 0, in world units"
        )
    return dataset.with_near(near)


def _no_poses(path: Path) -> str:
    half = None
    for file in islice(walk_files(path), FILES_MAX):
        if file.name in POSE_FILES:
            inner = list(file.parents)[: len(file.relative_to(path).parts) - 1]
            whole = next((folder for folder in reversed(inner) if has_poses(folder)), None)
            if whole is not None:
                return f"{path} is not a capture, but {whole} is one: give that folder"
            half = half or file
    if half is not None:
        return (
            f"{path} has {quoted(half.relative_to(path).as_posix())}, but no camera poses that are "
            "read: export COLMAP's cameras and images (.bin or .txt) into its folder sparse/0"
        )
    for folder in (path / "images", path):
        if images.list_images(folder):
            return (
                f"{folder} has photos but {path} has no camera poses; compute them with "
                f"`mobilegs capture {path} -o CAPTURE`, then give CAPTURE"
            )
    return (
        f"{path} is not a capture: it has no sparse/0 (COLMAP), no transforms.json (nerfstudio) "
        "and no transforms_train.json (Blender)"
    )
