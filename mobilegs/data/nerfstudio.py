"""Reads captures with a `transforms.json`, of nerfstudio and instant-ngp, and NeRF-synthetic ones.

Poses are camera-to-world with OpenGL axes (x right, y up, z back). An `applied_transform` is
ignored: poses and points already include it. The format is documented at
https://docs.nerf.studio/quickstart/data_conventions.html.
"""

import logging
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from os.path import commonpath
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.atomic import read_json
from mobilegs.camera import Camera
from mobilegs.data import images
from mobilegs.data.colmap_files import SIDE_MAX, lens_model
from mobilegs.data.dataset import (
    Color,
    Dataset,
    Frame,
    Offset,
    assemble,
    posed_frames,
    recentred,
    split_every_eighth,
)
from mobilegs.data.distortion import Distortion
from mobilegs.data.file_names import Folder, find_photos, reduced_photos, report_missing
from mobilegs.data.masks import find_masks
from mobilegs.data.pinhole_views import EQUIRECTANGULAR, sphere_intrinsics
from mobilegs.data.points import read_points_ply
from mobilegs.errors import InputError, quoted

PINHOLES = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "FULL_OPENCV")
FISHEYES = (
    "OPENCV_FISHEYE", "FISHEYE", "SIMPLE_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
)  # fmt: skip
PANORAMA = "EQUIRECTANGULAR"
INSTANT_NGP_LENSES = ("ftheta_p0", "latlong", "equirectangular", "orthographic")  # their keys
POINT_FILES = ("points3D.ply", "points3d.ply", "sparse_pc.ply", "pointcloud.ply")
log = logging.getLogger(__name__)


def load_nerfstudio(
    path: Path, *, downscale: int | None, background: Color | None, masks: bool
) -> Dataset:
    """Read `transforms.json`.

    The held-back views are those that the file or `transforms_test.json` lists, or else every
    eighth by name. Transparent photos are composited over `background`: by default white if any
    photo is transparent, else black. `load_capture` describes the arguments. Raises `InputError`.
    """
    source = path / "transforms.json"
    meta = read_transforms(source)
    listed = [frame.get("file_path") for frame in meta["frames"]]
    files = frame_files(path, meta, source)
    if background is None:
        see_through = any(images.has_alpha(file) for file in files)
        background = (1.0, 1.0, 1.0) if see_through else (0.0, 0.0, 0.0)
    points, colors = _points(source, meta)
    poses = [
        _viewmat(f"{source}: frame {index}", entry.get("transform_matrix"))
        for index, entry in enumerate(meta["frames"])
    ]
    _, points, offset = recentred(poses, points)
    options: dict[str, Any] = {"downscale": downscale, "background": background, "masks": masks}
    options["offset"] = offset
    photos = _frames_of_photos(path, source, meta, files, **options)
    frames = list(chain.from_iterable(photos))
    if (path / "transforms_test.json").is_file():
        train, test = frames, read_frames(path, "transforms_test.json", **options)
    elif "train_filenames" in meta and ("test_filenames" in meta or "val_filenames" in meta):
        train = _named(source, meta, "train_filenames", listed, files, photos)
        held = "test_filenames" if meta.get("test_filenames") else "val_filenames"
        test = _named(source, meta, held, listed, files, photos)
    else:
        train, test = split_every_eighth(frames)
    return assemble(
        path.resolve().name,
        train,
        test,
        points=points,
        colors=colors,
        background=background,
        offset=offset,
    )


def load_blender(
    path: Path, *, downscale: int | None, background: Color | None, masks: bool
) -> Dataset:
    """Read a NeRF-synthetic capture: renders with alpha over `background`, white by default.

    Its poses are in `transforms_train.json` and `_test.json`; without the latter every eighth view
    by name is held back. `load_capture` describes the arguments. Raises `InputError`.
    """
    background = background or (1.0, 1.0, 1.0)
    options: dict[str, Any] = {"downscale": downscale, "background": background, "masks": masks}
    train = read_frames(path, "transforms_train.json", **options)
    if (path / "transforms_test.json").is_file():
        test = read_frames(path, "transforms_test.json", **options)
    else:
        train, test = split_every_eighth(train)
    source = path / "transforms_train.json"
    points, colors = _points(source, read_transforms(source))
    name = path.resolve().name
    return assemble(name, train, test, points=points, colors=colors, background=background)


def read_transforms(path: Path) -> dict[str, Any]:
    """Read the JSON object of a transforms file. Raises `InputError` without a list `frames`."""
    meta = read_json(path)
    frames = meta.get("frames") if isinstance(meta, dict) else None
    if not isinstance(frames, list) or not all(isinstance(frame, dict) for frame in frames):
        raise InputError(f"{path} has no list `frames` of posed photos")
    if not frames:
        raise InputError(f"{path} lists no photo")
    return meta


def frame_files(path: Path, meta: dict[str, Any], source: Path) -> list[Path]:
    """Return the photo of every frame, and leave out of `meta` the frames without one.

    Raises `InputError`, which names `source`, if half of the photos or more do not exist.
    """
    names: list[str] = []
    for index, frame in enumerate(meta["frames"]):
        name = frame.get("file_path")
        if not isinstance(name, str) or not name:
            raise InputError(f"{source}: frame {index} has no file_path")
        names.append(name)
    photos = find_photos(path, [path], names, source)
    report_missing(photos.folder, photos.files, names, source)
    meta["frames"] = [frame for frame in meta["frames"] if frame["file_path"] in photos.files]
    return [photos.files[name] for name in names if name in photos.files]


def read_frames(path: Path, file: str, **options: Any) -> list[Frame]:
    """Read the frames of a transforms file, in its order; options as `_frames_of_photos` has."""
    meta = read_transforms(path / file)
    files = frame_files(path, meta, path / file)
    return list(chain.from_iterable(_frames_of_photos(path, path / file, meta, files, **options)))


def _frames_of_photos(
    path: Path,
    source: Path,
    meta: dict[str, Any],
    photos: list[Path],
    *,
    downscale: int | None,
    background: Color,
    masks: bool = True,
    offset: Offset = (0.0, 0.0, 0.0),
) -> list[list[Frame]]:
    """Return the frames of each of `photos` of the capture `path`, which `source` describes.

    A panorama has six frames, any other photo one. `offset` is subtracted from the positions of
    the cameras.
    """
    root = Path(commonpath([photo.parent for photo in photos]))
    names = [photo.relative_to(root).as_posix() for photo in photos]
    sizes = {n: images.image_size(photo) for n, photo in zip(names, photos, strict=True)}
    reduced = None if root == path else reduced_photos(root, sizes, downscale)
    entries = list(zip(meta["frames"], photos, names, strict=True))
    found = {}
    if masks:
        folder = Folder(path)
        named = {
            photo: _named_file(f"{source}: {name}", folder, "mask", entry["mask_path"])
            for entry, photo, name in entries
            if entry.get("mask_path") is not None
        }
        found = find_masks(photos, path, named)
    frames = []
    for index, (entry, photo, name) in enumerate(entries):
        where = f"{source}: frame {index} ({name})"
        values = {**meta, **entry}
        frames.append(
            posed_frames(
                name,
                _camera(where, values, sizes[name], offset),
                image_path=photo if reduced is None else reduced[name],
                downscale=downscale if reduced is None else 1,
                mask_path=found.get(photo),
                distortion=_distortion(where, values),
                alpha="over",
                background=background,
            )
        )
    return frames


def _number(
    where: str, values: dict[str, Any], key: str, default: int | float | None = None
) -> float:
    value = values.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e30:
        raise InputError(f"{where} needs a finite number as {key}, got {quoted(value)}")
    return float(value)


def _camera(where: str, values: dict[str, Any], size: tuple[int, int], offset: Offset) -> Camera:
    width, height = (
        round(_number(where, values, key, default)) for key, default in zip("wh", size, strict=True)
    )
    if not (0 < width <= SIDE_MAX and 0 < height <= SIDE_MAX):
        raise InputError(f"{where} has an impossible size of {width}x{height} pixels")
    if _model(where, values) == PANORAMA:  # of the whole sphere: it needs no focal length
        fx, fy, cx, cy = sphere_intrinsics(width, height)
    else:
        fx = fy = _focal(where, values, "x", width)
        if "fl_y" in values or "camera_angle_y" in values:
            fy = _focal(where, values, "y", height)
        cx = _number(where, values, "cx", width / 2)
        cy = _number(where, values, "cy", height / 2)
    viewmat = _viewmat(where, values.get("transform_matrix"))
    viewmat[:3, 3] += viewmat[:3, :3] @ offset
    return Camera(
        viewmat=torch.from_numpy(viewmat).float(),
        K=torch.tensor([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]),
        width=width,
        height=height,
    )


def _focal(where: str, values: dict[str, Any], axis: str, side: int) -> float:
    """Return the focal length in pixels along one axis, from `fl_x` or the field of view.

    The field of view is that of a pinhole camera: it does not count for a fisheye.
    """
    given = f"fl_{axis}" in values or f"camera_angle_{axis}" not in values
    if given or _model(where, values) not in PINHOLES:
        focal = _number(where, values, f"fl_{axis}")
    else:
        angle = _number(where, values, f"camera_angle_{axis}")
        focal = side / (2 * math.tan(angle / 2)) if 0 < angle < math.pi else 0.0
    if not focal > 0:
        raise InputError(f"{where} has a focal length or field of view out of range")
    return focal


def _viewmat(where: str, matrix: Any) -> Float[np.ndarray, "4 4"]:
    """Convert camera-to-world with OpenGL axes into world-to-camera with OpenCV axes.

    A uniform scale in the rotation, as modelling tools leave it, is divided out.
    """
    try:
        pose = np.array(matrix, np.float64)
    except (TypeError, ValueError, OverflowError):
        pose = np.zeros(0)
    if pose.shape not in ((4, 4), (3, 4)) or not (np.abs(pose) < 1e30).all():
        raise InputError(f"{where} has no transform_matrix of 4 x 4 finite numbers")
    rotation, eye = pose[:3, :3] * [1, -1, -1], pose[:3, 3]
    rotation = rotation / max(np.linalg.norm(rotation[:, 0]), 1e-30)
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > 1e-2 or np.linalg.det(rotation) < 0:
        raise InputError(f"{where} has a transform_matrix that is not a rotation and a translation")
    viewmat = np.eye(4)
    viewmat[:3, :3] = rotation.T
    viewmat[:3, 3] = -rotation.T @ eye
    return viewmat


def _model(where: str, values: dict[str, Any]) -> str:
    model = values.get("camera_model", "OPENCV")
    model = lens_model(model) if isinstance(model, str) else model
    if values.get("is_fisheye"):  # as instant-ngp writes it
        model = "OPENCV_FISHEYE"
    model = next((key for key in INSTANT_NGP_LENSES if values.get(key)), model)
    if model not in (*PINHOLES, *FISHEYES, PANORAMA):
        raise InputError(
            f"{where} has the camera model {quoted(model)}, which is not supported; undistort the "
            "photos first, for example with `colmap image_undistorter`"
        )
    return model


def _distortion(where: str, values: dict[str, Any]) -> Distortion:
    model = _model(where, values)
    if model == PANORAMA:
        return EQUIRECTANGULAR
    k1, k2, k3, k4, k5, k6, p1, p2, sx1, sy1 = (
        _number(where, values, key, 0.0)
        for key in ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "sx1", "sy1")
    )
    if model == "FULL_OPENCV":
        return Distortion((k1, k2, k3, 0.0), (k4, k5, k6), (p1, p2))
    if model in PINHOLES:
        return Distortion((k1, k2, k3, k4), tangential=(p1, p2))
    lens = Distortion((k1, k2, k3, k4), projection="equidistant")
    if model == "THIN_PRISM_FISHEYE":  # others have no p1 and p2
        lens = replace(lens, tangential=(p1, p2), prism=(sx1, sy1))
    return lens


def _named_file(where: str, folder: Folder, noun: str, name: Any) -> Path:
    """Return the file of `noun` that a transforms file calls `name`. Raises `InputError`."""
    file = folder.find(name) if isinstance(name, str) and name else None
    if file is None:
        raise InputError(f"{where} names the {noun} {quoted(name)}, which is not in {folder.root}")
    return file


def _named(
    source: Path,
    meta: dict[str, Any],
    key: str,
    listed: list[str],
    files: Sequence[Path],
    photos: list[list[Frame]],
) -> list[Frame]:
    """Return the frames of the photos that the list `meta[key]` names, in the file's order.

    `listed` has the names of all frames, also of those whose photo is gone.
    """
    names, folder = meta[key], Folder(source.parent)
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{source} has a {key} that is not a list of file names")
    known = {frame["file_path"]: file for frame, file in zip(meta["frames"], files, strict=True)}
    found = {name: known.get(name) or folder.find(name, photo=True) for name in names if name}
    wanted = {file or name for name, file in found.items() if file or name not in listed}
    picked = [frames for frames, file in zip(photos, files, strict=True) if file in wanted]
    if len(picked) < len(wanted):
        raise InputError(
            f"{source}: {key} names {len(wanted)} photos, but only {len(picked)} of them are frames"
        )
    return list(chain.from_iterable(picked))


def _points(
    source: Path, meta: dict[str, Any]
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m 3"]]:
    """Return the points that a transforms file names, or else those under a usual name."""
    folder, name = Folder(source.parent), meta.get("ply_file_path")
    if name is not None:
        return read_points_ply(_named_file(str(source), folder, "points file", name))
    file = next(filter(None, map(folder.find, POINT_FILES)), None)
    if file is None:
        return np.zeros((0, 3)), np.zeros((0, 3))
    log.warning("%s names no points: those of %s are used", source, file.name)
    return read_points_ply(file)
