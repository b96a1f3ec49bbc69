"""Chooses the pinhole views that stand for a photo in training.

A photo through an ordinary lens is one view with the intrinsics of the photo. A fisheye photo is
one view around its optical axis. A panorama of the whole sphere is the six faces of a cube.
"""

import math
from typing import NamedTuple

import torch

from mobilegs.camera import Camera
from mobilegs.data import images
from mobilegs.data.distortion import Distortion, LensPhoto
from mobilegs.errors import InputError

HALF_ANGLE_MAX = math.radians(50)  # of a fisheye view, from the optical axis to each side
ANGLES = 5001  # at which the extent of a fisheye photo is measured: 0.01 degrees apart
SIDE_MAX = 4  # times the photo's, of a fisheye view; more is no lens
FACES = {  # of a panorama: rotations from the face's axes to the panorama's, row by row
    "front": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "right": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),
    "back": ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
    "left": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),
    "up": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    "down": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
}
EQUIRECTANGULAR = Distortion(projection="equirectangular")


class PinholeView(NamedTuple):
    """A pinhole view of a photo.

    Attributes:
        face: of a panorama, else empty.
        camera: of the view, at the size at which it is used.
        photo: the photo at the size at which it is decoded, or None if it is the view itself.
    """

    face: str
    camera: Camera
    photo: LensPhoto | None


def pinhole_views(
    where: str,
    camera: Camera,
    size: tuple[int, int],
    *,
    distortion: Distortion,
    downscale: int | None,
) -> list[PinholeView]:
    """Return the views of a photo of `size` (width, height), divided by `downscale`.

    `camera` has the photo's pose, and its intrinsics before the distortion at any resolution.
    Raises InputError, which begins with `where`, for a panorama that is not twice as wide as high
    and for a fisheye lens that shows nothing.
    """
    if distortion.projection == "equirectangular":
        quarter = max(1, size[0] // 4)
        side, _ = images.reduced_size(quarter, quarter, downscale)
        return panorama_views(where, camera, size, side)
    camera = camera.resized(*images.reduced_size(*size, downscale))
    if not distortion:
        return [PinholeView("", camera, None)]
    photo = LensPhoto(camera.width, camera.height, _intrinsics(camera), distortion)
    if distortion.projection != "perspective":
        camera = fisheye_view(where, camera, photo)
    return [PinholeView("", camera, photo)]


def panorama_views(
    where: str, camera: Camera, size: tuple[int, int], side: int
) -> list[PinholeView]:
    """Return the faces of a cube around a panorama of `size`, each `side` pixels wide and high.

    A face a quarter as wide as the panorama has pixels 1.27 times as wide as the panorama's in its
    middle, and 0.64 times at its edges. The panorama is decoded at a whole fraction of its size,
    near four faces. Raises InputError, which begins with `where`, unless it is twice as wide as
    high.
    """
    width, height = size
    if not images.same_shape(size, (2, 1)):
        raise InputError(
            f"{where} is {width}x{height} pixels: a panorama must show the whole sphere, which is "
            "twice as wide as high"
        )
    part = max(1, round(width / (4 * side)))
    width, height = max(1, width // part), max(1, height // part)
    focal = side / 2
    K = torch.tensor([[focal, 0, focal], [0, focal, focal], [0, 0, 1]])
    intrinsics = sphere_intrinsics(width, height)
    views = []
    for face, rotation in FACES.items():
        turn = torch.eye(4)
        turn[:3, :3] = torch.tensor(rotation).T
        turned = Camera(turn.to(camera.viewmat) @ camera.viewmat, K, side, side)
        photo = LensPhoto(width, height, intrinsics, EQUIRECTANGULAR, rotation)
        views.append(PinholeView(face, turned, photo))
    return views


def sphere_intrinsics(width: int, height: int) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy from longitude and latitude (radians) to pixels of a panorama."""
    return width / (2 * math.pi), height / math.pi, width / 2, height / 2


def fisheye_view(where: str, camera: Camera, photo: LensPhoto) -> Camera:
    """Return a camera for the middle of a fisheye photo, with the focal length of the photo.

    It extends to each side of the optical axis as far as the photo does, at most by
    `HALF_ANGLE_MAX`.
    """
    fx, fy, *_ = photo.intrinsics
    left, right = fx * _reach(photo, -1, 0), fx * _reach(photo, 1, 0)
    top, bottom = fy * _reach(photo, 0, -1), fy * _reach(photo, 0, 1)
    width, height = left + right, top + bottom
    if not (1 <= width <= SIDE_MAX * photo.width and 1 <= height <= SIDE_MAX * photo.height):
        raise InputError(
            f"{where} has a lens whose distortion leaves no view of the photo; calibrate it again"
        )
    K = torch.tensor([[fx, 0, left], [0, fy, top], [0, 0, 1]])
    return Camera(camera.viewmat, K, int(width), int(height), camera.near)


def fields_of_view(camera: Camera) -> tuple[float, float]:
    """Return the angles that a camera sees across and down, along its axes, in degrees."""
    fx, fy, cx, cy = _intrinsics(camera)
    across = math.atan(cx / fx) + math.atan((camera.width - cx) / fx)
    down = math.atan(cy / fy) + math.atan((camera.height - cy) / fy)
    return math.degrees(across), math.degrees(down)


def _reach(photo: LensPhoto, x: int, y: int) -> float:
    """Return the tangent of the angle up to which a photo shows directions, along an image axis."""
    angles = torch.linspace(0, HALF_ANGLE_MAX, ANGLES, dtype=torch.float64)
    _, _, seen = photo.pixels_of(x * angles.sin(), y * angles.sin(), angles.cos())
    unseen = (~seen).nonzero()
    last = int(unseen[0, 0]) - 1 if len(unseen) else ANGLES - 1
    return float(angles[max(0, last)].tan())


def _intrinsics(camera: Camera) -> tuple[float, float, float, float]:
    K = camera.K
    return float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2])
