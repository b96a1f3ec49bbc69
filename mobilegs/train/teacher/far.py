"""Gaussians on a far sphere: skies, and what is behind the scene where it has holes."""

import math
from collections.abc import Sequence

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import MIN_SIDE
from mobilegs.data.dataset import Dataset, Frame, load_view
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint, measure_contributions

FAR_RADIUS = 20.0  # of the far sphere, in extents
FAR_PHOTOS = 32  # photos from which it takes colours
SIDE = 200  # pixels of the shorter side of images in which visibility is measured


def far_points(
    frames: Sequence[Frame], center: Float[Tensor, "3"], extent: float, *, count: int
) -> tuple[Float[Tensor, "n 3"], Float[Tensor, "n 3"]]:
    """Return points of a far sphere that photos show, and their colours: at most `count`.

    The sphere has a radius of 20 extents around `center`, and points at equal distances from each
    other. A colour is the mean over the photos that show the direction, at most 32 of the capture,
    whether or not something is before the sphere.
    """
    number = torch.arange(count) + 0.5
    polar, turn = (1 - 2 * number / count).acos(), math.pi * (1 + math.sqrt(5)) * number
    away = torch.stack([polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()], dim=1)
    points = center + FAR_RADIUS * extent * away
    sums, seen = torch.zeros(count, 3), torch.zeros(count)
    for frame in frames[:: math.ceil(len(frames) / FAR_PHOTOS)]:
        view = load_view(frame)
        view = view.reduced(max(1, min(view.camera.width, view.camera.height) // MIN_SIDE))
        camera = view.camera
        local = points @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
        place = (local @ camera.K.T)[:, :2] / local[:, 2:]
        inside = (local[:, 2] > 0) & (place >= 0).all(1)
        inside &= (place[:, 0] < camera.width) & (place[:, 1] < camera.height)
        column, row = place[inside].long().T
        sums[inside] += view.image[row, column]
        seen[inside] += 1
    shown = seen > 0
    return points[shown], (sums / seen.clamp_min(1)[:, None])[shown]


@torch.no_grad()
def hidden_far(
    gaussians: Gaussians, dataset: Dataset, footprint: Footprint, least: float
) -> Bool[Tensor, "n"]:
    """Return a mask of the Gaussians near the far sphere that the scene before them hides.

    The visibility of a Gaussian is its blending weight, summed over the pixels of at most 32
    training photos, divided by this sum without what is nearer than half the sphere's radius. It
    lies in [0, 1]. Hidden are those with a visibility below `least`.
    """
    center = dataset.center.to(gaussians.means)
    far = (gaussians.means - center).norm(dim=1) > FAR_RADIUS / 2 * dataset.extent
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
    far_shapes = tuple(values[far] for values in shapes)
    seen, unobstructed = torch.zeros_like(shapes[3]), torch.zeros_like(far_shapes[3])
    for frame in dataset.train[:: math.ceil(len(dataset.train) / FAR_PHOTOS)]:
        camera = frame.camera
        camera = camera.reduced(max(1, min(camera.width, camera.height) // SIDE)).to(seen.device)
        seen += measure_contributions(*shapes, camera=camera, footprint=footprint).weights
        unobstructed += measure_contributions(
            *far_shapes, camera=camera, footprint=footprint
        ).weights
    hidden = torch.zeros_like(far)
    hidden[far] = seen[far] < least * unobstructed
    return hidden
