"""Reads `cameras.json`, the list of training cameras that 3DGS writes next to a scene."""

import math
from pathlib import Path
from typing import Any

import torch

from mobilegs.atomic import read_json
from mobilegs.camera import Camera
from mobilegs.errors import InputError

SIDE_MAX = 1 << 16  # pixels


def read_cameras_json(path: Path) -> list[Camera]:
    """Read the cameras in the file's order.

    Each entry has `width`, `height`, `fx`, `fy` in pixels, `position [3]` in world units, and
    `rotation [3][3]` from camera (OpenCV axes) to world. The principal point is the image's
    centre. The layout is that of INRIA's gaussian-splatting.

    Raises InputError if the file is missing or not such a list, or if a camera is not valid.
    """
    rows = read_json(path)
    if not isinstance(rows, list) or not rows:
        raise InputError(f"{path} has no list of cameras: give a cameras.json of 3DGS")
    return [parse_camera(row, f"camera {number} of {path}") for number, row in enumerate(rows)]


def parse_camera(row: Any, name: str) -> Camera:
    """Return the camera of an entry of a cameras.json, which messages call `name`.

    Raises InputError if something is missing or not possible.
    """
    try:
        width, height = row["width"], row["height"]
        focal = torch.tensor([row["fx"], row["fy"]], dtype=torch.float64)
        position = torch.tensor(row["position"], dtype=torch.float64)
        rotation = torch.tensor(row["rotation"], dtype=torch.float64)
    except (KeyError, TypeError, ValueError, RuntimeError, OverflowError):
        raise InputError(
            f"{name} is incomplete: width, height, fx, fy, position and rotation must be numbers"
        ) from None
    sides = all(type(side) is int and 1 <= side <= SIDE_MAX for side in (width, height))
    shapes = focal.shape, position.shape, rotation.shape
    if not sides or shapes != ((2,), (3,), (3, 3)):
        raise InputError(f"{name} has a size, focal length, position or rotation that is not valid")
    turned = torch.eye(3, dtype=torch.float64)
    right = torch.allclose(rotation @ rotation.T, turned, atol=1e-3) and rotation.det() > 0
    small = position.float().isfinite().all() and all(0 < f < math.inf for f in focal.float())
    if not right or not small:  # checked as float32, in which it is rendered
        raise InputError(
            f"{name} has a rotation matrix that is not a rotation, or numbers that are not finite"
        )
    viewmat = torch.eye(4, dtype=torch.float64)
    viewmat[:3, :3], viewmat[:3, 3] = rotation.T, -rotation.T @ position
    K = torch.tensor([[focal[0], 0, width / 2], [0, focal[1], height / 2], [0, 0, 1]])
    return Camera(viewmat.float(), K.float(), width, height)
