"""`cameras.json`, which 3DGS leaves beside a scene: where its photos were taken from."""

import json
import math
from pathlib import Path
from typing import Any

import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError

SIDE_MAX = 1 << 16


def read_cameras_json(path: Path) -> list[Camera]:
    """The cameras, in the file's order.

    Each is `{width, height, fx, fy, position [3], rotation [3][3]}`, the rotation from the camera
    (OpenCV axes) to the world; principal points are central. Source of the layout: INRIA's
    gaussian-splatting, which writes the file beside each scene.

    Raises InputError for a file that is no such list, or numbers that no camera has.
    """
    try:
        rows = json.loads(path.read_bytes())
    except FileNotFoundError:
        raise InputError(f"there is no file {path}") from None
    except (ValueError, RecursionError):
        raise InputError(f"{path} is no JSON: a cameras.json of 3DGS is needed") from None
    if not isinstance(rows, list) or not rows:
        raise InputError(f"{path} holds no list of cameras, as a cameras.json of 3DGS does")
    return [_camera(row, f"camera {number} of {path}") for number, row in enumerate(rows)]


def _camera(row: Any, name: str) -> Camera:
    try:
        width, height = row["width"], row["height"]
        focal = torch.tensor([row["fx"], row["fy"]], dtype=torch.float64)
        position = torch.tensor(row["position"], dtype=torch.float64)
        rotation = torch.tensor(row["rotation"], dtype=torch.float64)
    except (KeyError, TypeError, ValueError, RuntimeError, OverflowError):
        raise InputError(
            f"{name} lacks a number: width, height, fx, fy, position and rotation are needed"
        ) from None
    sides = all(type(side) is int and 1 <= side <= SIDE_MAX for side in (width, height))
    shapes = focal.shape, position.shape, rotation.shape
    if not sides or shapes != ((2,), (3,), (3, 3)):
        raise InputError(f"{name} has a size, focal length, position or rotation that none has")
    turned = torch.eye(3, dtype=torch.float64)
    right = torch.allclose(rotation @ rotation.T, turned, atol=1e-3) and rotation.det() > 0
    small = position.float().isfinite().all() and all(0 < f < math.inf for f in focal.float())
    if not right or not small:  # as floats, which it is drawn with
        raise InputError(f"{name} has a rotation that is none, or numbers that are not finite")
    viewmat = torch.eye(4, dtype=torch.float64)
    viewmat[:3, :3], viewmat[:3, 3] = rotation.T, -rotation.T @ position
    K = torch.tensor([[focal[0], 0, width / 2], [0, focal[1], height / 2], [0, 0, 1]])
    return Camera(viewmat.float(), K.float(), width, height)
