"""Random points within an object, for captures whose photos are transparent around it."""

import logging
from collections.abc import Callable, Sequence
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data import images
from mobilegs.data.dataset import Frame

log = logging.getLogger(__name__)

PHOTOS_MAX = 40  # that are read
CELL = 8  # pixels of a photo across and down that are one of its silhouette
DRAWS_MAX = 50  # of random points
POINTS_SHARE_MIN = 0.1  # ratio of points within the silhouettes to those wanted


class Silhouette(NamedTuple):
    """The part of a photo that shows the object, `[h, w]`, and its camera at that size."""

    camera: Camera
    shown: Bool[Tensor, "h w"]


def read_silhouettes(frames: Sequence[Frame]) -> list[Silhouette]:
    """Return where the photos that lie over a background are not transparent.

    At most 40 of them are read, evenly spaced. Photos through a lens are left out. Raises
    `InputError` if a photo cannot be decoded.
    """
    over = [frame for frame in frames if frame.alpha == "over" and frame.photo is None]
    silhouettes = []
    for frame in over[:: max(1, -(-len(over) // PHOTOS_MAX))]:
        if frame.image_path is not None:
            camera = frame.camera
            width, height = -(-camera.width // CELL), -(-camera.height // CELL)
            shown = torch.from_numpy(images.read_opaque(frame.image_path, width, height))
            silhouettes.append(Silhouette(camera.resized(width, height), shown))
    return silhouettes


def shown_share(frames: Sequence[Frame]) -> float:
    """Return the fraction of the photos' pixels that show the object; 1 without transparency."""
    silhouettes = read_silhouettes(frames)
    if not silhouettes:
        return 1.0
    return sum(float(shown.float().mean()) for _, shown in silhouettes) / len(silhouettes)


def within(points: Float[Tensor, "n 3"], silhouettes: Sequence[Silhouette]) -> Float[Tensor, "m 3"]:
    """Return the points that some photo shows and none shows as transparent.

    This is the visual hull of the silhouettes (Laurentini 1994), as far as the photos reach.
    """
    shows = torch.zeros(len(points), dtype=torch.bool)
    for camera, shown in silhouettes:
        viewmat, K = camera.viewmat.double(), camera.K.double()
        local = points.double() @ viewmat[:3, :3].T + viewmat[:3, 3]
        pixels = (local @ K.T)[:, :2] / local[:, 2:]
        size = torch.tensor([camera.width, camera.height])
        seen = (local[:, 2] > camera.near) & (pixels >= 0).all(1) & (pixels < size).all(1)
        column, row = pixels.where(seen[:, None], 0).long().unbind(1)
        kept = ~seen | shown[row, column]
        points, shows = points[kept], (shows | seen)[kept]
    return points[shows]


def draw_within(
    silhouettes: Sequence[Silhouette],
    draw: Callable[[int], Float[Tensor, "n 3"]],
    count: int,
) -> Float[Tensor, "n 3"]:
    """Return at most `count` of the points that `draw(count)` returns, within the silhouettes.

    If 50 draws find fewer than a tenth of `count`, the silhouettes contradict one another, or the
    object is too thin: the result is a single draw, and a warning says so.
    """
    inside: list[Tensor] = []
    for _ in range(DRAWS_MAX):
        inside.append(within(draw(count), silhouettes))
        if sum(map(len, inside)) >= count:
            break
    points = torch.cat(inside)[:count]
    if len(points) < POINTS_SHARE_MIN * count:
        log.warning(
            "transparent pixels leave almost no place for an object: wrong poses, or a thin "
            "object; training starts from Gaussians all around it"
        )
        return draw(count)
    return points
