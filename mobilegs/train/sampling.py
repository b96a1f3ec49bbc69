"""The finest detail that the training cameras sample, as a lower limit of scales."""

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera

EVERY = 100  # steps between two applications of the limit
MARGIN = 0.15  # of the image's sides: Gaussians a little outside of it count as seen
ROWS = 1 << 16  # Gaussians at a time


@torch.no_grad()
def sampling_intervals(means: Float[Tensor, "n 3"], cameras: list[Camera]) -> Float[Tensor, "n"]:
    """Return the smallest distance in world units between two samples of any camera at each mean.

    A camera samples at `z / f`: one pixel at the mean's depth (Mip-Splatting, Yu et al. 2024,
    Eq. 6). Infinite for a mean that no camera sees.
    """
    finest = torch.full_like(means[:, 0], torch.inf)
    for rows in torch.arange(len(means), device=means.device).split(ROWS):
        some = means[rows]
        best = finest[rows]
        for camera in cameras:
            viewmat = camera.viewmat.to(some)
            x, y, z = (some @ viewmat[:3, :3].T + viewmat[:3, 3]).unbind(1)
            fx, fy = float(camera.K[0, 0]), float(camera.K[1, 1])
            cx, cy = float(camera.K[0, 2]), float(camera.K[1, 2])
            wide, high = MARGIN * camera.width, MARGIN * camera.height
            column, row = fx * x / z + cx, fy * y / z + cy
            seen = (z > camera.near) & (column > -wide) & (column < camera.width + wide)
            seen &= (row > -high) & (row < camera.height + high)
            best = torch.where(seen, torch.minimum(best, z / max(fx, fy)), best)
        finest[rows] = best
    return finest


@torch.no_grad()
def limit_scales(
    log_scales: Float[Tensor, "n 3"],
    means: Float[Tensor, "n 3"],
    cameras: list[Camera],
    variance: float,
) -> None:
    """Raise scales in place to `sqrt(variance)` sampling intervals where they are smaller.

    Thinner Gaussians are detail that no photo shows, and become visible in larger images. Those
    that no camera sees keep their scales. Mip-Splatting widens every Gaussian by a filter of
    variance 0.2 instead, which stays as a part of the scene; a limit needs no such part.
    """
    least = 0.5 * torch.log(variance * sampling_intervals(means, cameras).square())
    least = torch.where(least.isfinite(), least, -torch.inf)
    log_scales.clamp_(min=least[:, None])
