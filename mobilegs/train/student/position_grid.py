"""Choice of the position grid: as coarse as the training images allow."""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import EXPONENT_MAX
from mobilegs.reproducible import total

CAMERAS_MAX = 64


@torch.no_grad()
def choose_grid(means: Float[Tensor, "n 3"], cameras: list[Camera], error: float) -> PositionGrid:
    """Return the coarsest grid that moves Gaussians by at most `error` pixels (root mean square).

    The mean is over the Gaussians that at least one of the `cameras` sees, in the images of these
    cameras. If no grid is fine enough, it is the finest.
    """
    grid, magnification = PositionGrid.around(means), pixels_per_unit(means, cameras)
    for exponent in range(EXPONENT_MAX, -1, -1):
        grid = replace(grid, exponent=exponent)
        moved = (grid.world(grid.store(means)) - means).norm(dim=1)
        # two of the three directions of an error are parallel to the image
        pixels = (2 / 3) ** 0.5 * moved * magnification
        if (total(pixels.square()) / (magnification > 0).sum().clamp_min(1)).sqrt() <= error:
            break
    return grid


def pixels_per_unit(means: Float[Tensor, "n 3"], cameras: list[Camera]) -> Float[Tensor, "n"]:
    """Return the pixels per world unit at each mean: root mean square over cameras that see it.

    It is 0 where no camera does. At most 64 cameras, evenly chosen, count.
    """
    total, views = torch.zeros_like(means[:, 0]), torch.zeros_like(means[:, 0])
    for camera in cameras[:: -(-len(cameras) // CAMERAS_MAX)]:
        viewmat, K = camera.viewmat.to(means), camera.K.to(means)
        points = means @ viewmat[:3, :3].T + viewmat[:3, 3]
        x, y, z = points.unbind(1)
        u, v = K[0, 0] * x / z + K[0, 2], K[1, 1] * y / z + K[1, 2]
        visible = (z > camera.near) & (u > 0) & (v > 0) & (u < camera.width) & (v < camera.height)
        squares = (K[0, 0] * K[1, 1]).abs() / z.square()
        total += torch.where(visible, squares, 0)
        views += visible
    return (total / views.clamp_min(1)).sqrt()
