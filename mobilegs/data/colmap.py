"""Reads COLMAP captures: a folder with `images/` and `sparse/0/`."""

import logging
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Literal

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.data import images
from mobilegs.data.colmap_files import (
    ColmapCamera,
    ColmapImage,
    count_images,
    read_cameras,
    read_images,
    read_moments,
    read_points,
)
from mobilegs.data.dataset import (
    Color,
    Dataset,
    assemble,
    posed_frames,
    recentred,
    split_every_eighth,
)
from mobilegs.data.masks import find_masks
from mobilegs.errors import InputError, quoted
from mobilegs.render.project import rotation_matrices

BESIDE_PHOTOS = ("sparse",)
MODEL_FOLDERS = (*BESIDE_PHOTOS, "colmap/sparse")  # and folders in them, mostly called 0, 1, ...
log = logging.getLogger(__name__)


def find_models(path: Path, folders: Sequence[str] = MODEL_FOLDERS) -> dict[Path, int]:
    """Return the COLMAP models of a capture that lie side by side, with their numbers of photos."""
    for folder in (path / name for name in folders):
        models = [each for each in (*_subfolders(folder), folder) if _is_model(each)]
        if models:
            return {each: _photo_count(each) if len(models) > 1 else 0 for each in models}
    return {}


def _subfolders(folder: Path) -> list[Path]:
    try:
        return sorted(each for each in folder.iterdir() if each.is_dir())
    except OSError:
        return []


def _is_model(folder: Path) -> bool:
    files = [f"{noun}.{kind}" for noun in ("images", "cameras") for kind in ("bin", "txt")]
    return any((folder / file).exists() for file in files)


def _photo_count(folder: Path) -> int:
    files = (folder / "images.bin", folder / "images.txt")
    return next((count_images(file) for file in files if file.is_file()), 0)


def load_colmap(
    path: Path, *, downscale: int | None, background: Color | None, masks: bool
) -> Dataset:
    """Read a COLMAP capture; every eighth photo by name is held back.

    `background` is black by default; `masks` uses those that `find_masks` finds. Photos are
    undistorted when they are decoded. `load_capture` describes the arguments. Raises `InputError`.
    """
    models = find_models(path)
    if not models:
        raise InputError(f"{path} has no COLMAP model in {'/0 or '.join(MODEL_FOLDERS)}/0")
    model = max(models, key=lambda folder: models[folder])
    if len(models) > 1:
        sizes = ", ".join(f"{each.name} of {count} photos" for each, count in models.items())
        log.warning("%s has the models %s: the largest is used", path, sizes)
    cameras = read_cameras(_model_file(model, "cameras"))
    registered = read_images(_model_file(model, "images"))
    if not registered:
        raise InputError(f"{model} has no registered photo; reconstruct it again with more overlap")
    points = read_points(_model_file(model, "points3D"))
    viewmats, xyz, offset = recentred([_viewmat(image) for image in registered], points.xyz)
    files, downscale = _photo_files(path, [image.name for image in registered], downscale)
    found = find_masks(list(files.values()), path) if masks else {}
    background = background or (0.0, 0.0, 0.0)
    groups = _moments(model)
    frames = []
    for image, viewmat in zip(registered, viewmats, strict=True):
        if image.camera_id not in cameras:
            raise InputError(
                f"{model}: photo {image.name} refers to camera {image.camera_id}, which does not "
                "exist"
            )
        lens = cameras[image.camera_id]
        frames += posed_frames(
            image.name,
            _camera(lens, viewmat),
            image_path=files[image.name],
            downscale=downscale,
            mask_path=found.get(files[image.name]),
            distortion=lens.distortion,
            group=groups.get(image.number, ""),
            background=background,
        )
    train, test = split_every_eighth(frames)
    return assemble(
        path.resolve().name,
        train,
        test,
        points=xyz,
        offset=offset,
        colors=points.rgb / 255,
        background=background,
    )


def _model_file(model: Path, noun: Literal["cameras", "images", "points3D"]) -> Path:
    for suffix in (".bin", ".txt"):
        if (model / f"{noun}{suffix}").is_file():
            return model / f"{noun}{suffix}"
    raise InputError(
        f"{model} has neither {noun}.bin nor {noun}.txt; export the COLMAP model again"
    )


def _photo_files(
    path: Path, names: list[str], downscale: int | None
) -> tuple[dict[str, Path], int | None]:
    """Return the file of every photo, and the downscale that is left to do (None: automatic)."""
    folder = path / "images"
    for name in names:
        if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts:
            raise InputError(
                f"the COLMAP model of {path} names the photo {quoted(name)}, outside of images/"
            )
    reduced = images.reduced_files(folder, names, downscale)
    if reduced is not None:
        return reduced, 1
    if not folder.is_dir():
        raise InputError(f"{path} has a COLMAP model but no folder images/ with the photos")
    missing = [name for name in names if not images.is_file(folder / name)]
    if missing:
        raise InputError(
            f"{folder} lacks {len(missing)} of the {len(names)} photos of the COLMAP model, such "
            f"as {missing[0]}; put them back or reconstruct without them"
        )
    return {name: folder / name for name in names}, downscale


def _moments(model: Path) -> dict[int, str]:
    """Return a name of the moment for each image that a rig took together with others."""
    files = (model / "frames.bin", model / "frames.txt")  # as COLMAP 3.12 and later write them
    file = next((file for file in files if file.is_file()), None)
    moments = [] if file is None else read_moments(file)
    return {
        image: f"moment {index}"
        for index, photos in enumerate(moments)
        if len(photos) > 1
        for image in photos
    }


def _camera(lens: ColmapCamera, viewmat: Float[np.ndarray, "4 4"]) -> Camera:
    fx, fy, cx, cy = lens.intrinsics
    K = torch.tensor([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return Camera(torch.from_numpy(viewmat).float(), K, lens.width, lens.height)


def _viewmat(image: ColmapImage) -> Float[np.ndarray, "4 4"]:
    """Return the world-to-camera matrix; COLMAP uses OpenCV's axes."""
    quat = torch.tensor([image.quat], dtype=torch.float64)
    quat /= quat.abs().max()  # squares of huge values stay finite
    viewmat = np.eye(4)
    viewmat[:3, :3] = rotation_matrices(quat)[0]
    viewmat[:3, 3] = image.translation
    return viewmat
