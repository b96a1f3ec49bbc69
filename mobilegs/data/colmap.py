"""Reads COLMAP captures: a folder with photos, mostly in `images/`, and a model in `sparse/0/`."""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.data.colmap_files import (
    ColmapCamera,
    ColmapImage,
    ColmapPoints,
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
from mobilegs.data.file_names import Folder, find_photos, reduced_photos, report_missing
from mobilegs.data.masks import find_masks
from mobilegs.data.points import read_points_ply
from mobilegs.errors import InputError
from mobilegs.render.project import rotation_matrices

BESIDE_PHOTOS = ("sparse",)
# "" is the capture itself
MODEL_FOLDERS = (
    *BESIDE_PHOTOS, "colmap/sparse", "colmap", "dense/sparse", "dense/0/sparse", "", "images",
    "input", "sparse_text", "distorted/sparse",
)  # fmt: skip
log = logging.getLogger(__name__)


def find_models(path: Path, folders: Sequence[str] = MODEL_FOLDERS) -> dict[Path, int]:
    """Return the COLMAP models of a capture that lie side by side, with their numbers of photos."""
    for folder in (path / name for name in folders):
        own = folder.name == "sparse"  # of COLMAP: it may have folders 0, 1, ...
        places = (*_subfolders(folder), folder) if own else (folder,)
        models = [each for each in places if (any if own else all)(_model_parts(each))]
        if models:
            return {each: _photo_count(each) if len(models) > 1 else 0 for each in models}
    return {}


def _subfolders(folder: Path) -> list[Path]:
    try:
        return sorted(each for each in folder.iterdir() if each.is_dir())
    except OSError:
        return []


def _model_parts(folder: Path) -> list[bool]:
    """Return whether a folder has the photos and the cameras of a model."""
    nouns, kinds = ("images", "cameras"), ("bin", "txt")
    return [any((folder / f"{noun}.{kind}").exists() for kind in kinds) for noun in nouns]


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
    registered = read_images(_model_file(model, "images"))
    if not registered:
        raise InputError(f"{model} has no registered photo; reconstruct it again with more overlap")
    used = {image.camera_id for image in registered}
    cameras = read_cameras(_model_file(model, "cameras"), used)
    for image in registered:
        if image.camera_id not in cameras:
            raise InputError(
                f"{model}: photo {image.name} refers to camera {image.camera_id}, which does not "
                "exist, or follows a camera of an unknown lens model"
            )
    sizes = {image.name: cameras[image.camera_id][:2] for image in registered}
    files, names, downscale = _photo_files(path, model, sizes, downscale)
    registered = [image for image in registered if image.name in files]
    points = _points(model)
    viewmats, xyz, offset = recentred([_viewmat(image) for image in registered], points.xyz)
    found = find_masks(list(files.values()), path) if masks else {}
    background = background or (0.0, 0.0, 0.0)
    groups = _moments(model)
    frames = []
    for image, viewmat in zip(registered, viewmats, strict=True):
        lens, name = cameras[image.camera_id], names[image.name]
        frames += posed_frames(
            name,
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


def _model_file(model: Path, noun: Literal["cameras", "images"]) -> Path:
    for suffix in (".bin", ".txt"):
        if (model / f"{noun}{suffix}").is_file():
            return model / f"{noun}{suffix}"
    raise InputError(
        f"{model} has neither {noun}.bin nor {noun}.txt; export the COLMAP model again"
    )


def _points(model: Path) -> ColmapPoints:
    """Return the sparse points of a model; none if it has no file of them."""
    for file in (model / "points3D.bin", model / "points3D.txt"):
        if file.is_file():
            return read_points(file)
    file = Folder(model).find("points3D.ply")  # which 3DGS writes beside them
    if file is None:
        return ColmapPoints(np.zeros((0, 3)), np.zeros((0, 3), np.uint8))
    xyz, rgb = read_points_ply(file)
    return ColmapPoints(xyz, (255 * rgb).round().astype(np.uint8))


def _photo_files(
    path: Path, model: Path, sizes: dict[str, tuple[int, int]], downscale: int | None
) -> tuple[dict[str, Path], dict[str, str], int | None]:
    """Return file and frame name of each photo, and the downscale that is left (None: automatic).

    `sizes` has the photos of the model.
    """
    places = [model, *model.parents[: len(model.relative_to(path).parts)]]
    usual = ("input", "images") if "distorted" in model.parts else ("images", "input")
    folders = [place / name for place in places for name in usual]
    photos = find_photos(path, [*folders, path], list(sizes), model)
    files, folder = photos.files, photos.folder.root if photos.files else path / "images"
    reduced = None
    if folder != path:
        reduced = reduced_photos(folder, {name: sizes[name] for name in files or sizes}, downscale)
    if reduced and not files:
        files, folder = reduced, folder.with_name(f"{folder.name}_{downscale}")
    report_missing(photos.folder, files, list(sizes), model)
    names = {name: file.relative_to(folder).as_posix() for name, file in files.items()}
    return reduced or files, names, 1 if reduced else downscale


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
