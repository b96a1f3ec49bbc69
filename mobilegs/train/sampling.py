"""The finest detail that the training cameras sample, as a lower limit of scales."""

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.csrc.binding import address, library, supports, validate

LIMIT_EVERY = 100  # steps between two applications of the limit
MARGIN = 0.15  # of the image's sides: Gaussians a little outside of it count as seen
ROWS = 1 << 16  # Gaussians at a time


@torch.no_grad()
def sampling_intervals(means: Float[Tensor, "n 3"], cameras: list[Camera]) -> Float[Tensor, "n"]:
    """Return the smallest distance in world units between two samples of any camera at each mean.

    A camera samples at `z / f`: one pixel at the mean's depth (Mip-Splatting, Yu et al. 2024,
    Eq. 6). Infinite for a mean that no camera sees. This is the reference of csrc/sampling.cpp,
    which runs for float32 on the CPU.
    """
    packed = packed_cameras(cameras).to(means)
    if supports(means):
        return _by_library(means.detach().contiguous(), packed)
    finest = torch.full_like(means[:, 0], torch.inf)
    for rows in torch.arange(len(means), device=means.device).split(ROWS):
        some, best = means[rows], finest[rows]
        for camera in packed:
            left, right, top, bottom, near, interval = camera[12:]
            x, y, z = (some @ camera[:9].view(3, 3).T + camera[9:12]).unbind(1)
            seen = (z > near) & (x > left * z) & (x < right * z) & (y > top * z) & (y < bottom * z)
            best = torch.where(seen, torch.minimum(best, z * interval), best)
        finest[rows] = best
    return finest


def packed_cameras(cameras: list[Camera]) -> Float[Tensor, "cameras 18"]:
    """Return for each camera its rotation, its translation, and what it sees, in float64.

    The last six columns: x / z of the left and the right border and y / z of the upper and the
    lower, with a margin; the nearest depth; the sampling interval at depth 1.
    """
    rows = []
    for camera in cameras:
        fx, fy, cx, cy = (float(camera.K[at]) for at in ((0, 0), (1, 1), (0, 2), (1, 2)))
        wide, high = MARGIN * camera.width, MARGIN * camera.height
        seen = [(-wide - cx) / fx, (camera.width + wide - cx) / fx]
        seen += [(-high - cy) / fy, (camera.height + high - cy) / fy]
        viewmat = camera.viewmat.double().cpu()
        seen = torch.tensor([*seen, camera.near, 1 / max(fx, fy)], dtype=torch.float64)
        rows.append(torch.cat([viewmat[:3, :3].flatten(), viewmat[:3, 3], seen]))
    return torch.stack(rows)


def _by_library(
    means: Float[Tensor, "n 3"], packed: Float[Tensor, "cameras 18"]
) -> Float[Tensor, "n"]:
    validate(means, len(means), 3)
    validate(packed, len(packed), 18)
    finest = torch.empty(len(means))
    library().mgs_sampling_intervals(
        len(means), address(means), len(packed), address(packed), address(finest)
    )
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
