"""Contributions of each Gaussian to a sorted image: the reference.

The kernels are csrc/cpu_contributions.h and csrc/cuda_contributions.h.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import CLASSIC, Footprint, project
from mobilegs.render.sorted import blend

NO_WINNER = -1


class Contributions(NamedTuple):
    """Statistics of one image blended front to back.

    A Gaussian's share of a pixel is its blending weight `a T`: alpha times the transmittance in
    front of it. It is 0 behind the early stop.

    Attributes:
        weights: sum of the shares over all pixels, `[n]`.
        touched: number of pixels in which the share is above 0, int32, `[n]`.
        largest: number of pixels in which the share is the largest, int32, `[n]`.
        winner: index of the Gaussian with the largest share of each pixel, the nearer one if
            shares are equal, -1 where no Gaussian has one, int32, `[h, w]`.
        alpha: coverage of the background, in [0, 1], `[h, w]`.
    """

    weights: Float[Tensor, "n"]
    touched: Int[Tensor, "n"]
    largest: Int[Tensor, "n"]
    winner: Int[Tensor, "h w"]
    alpha: Float[Tensor, "h w"]


def measure_contributions(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    footprint: Footprint = CLASSIC,
) -> Contributions:
    """Return the statistics from which Mini-Splatting (Fang and Wang 2024) computes importance.

    Shapes and units as in `render_sorted`.
    """
    black = torch.zeros_like(means[:, None, :])
    shapes = (means, quats, scales, opacities, black)
    projected = project(*shapes, camera=camera, footprint=footprint)
    blending = blend(projected, opacities, camera)
    shares, order = blending.weights, blending.order  # [pixels, n], front first
    count, size = len(means), (camera.height, camera.width)
    weights, touched = torch.zeros_like(opacities), torch.zeros_like(order, dtype=torch.int32)
    weights[order] = shares.sum(0)
    touched[order] = (shares > 0).sum(0, dtype=torch.int32)
    winner = torch.full((len(shares),), NO_WINNER, dtype=torch.int32, device=means.device)
    if count:
        best = shares.amax(1, keepdim=True)
        # argmax of equal values may be any of them
        ranks = torch.arange(count, device=means.device).expand_as(shares)
        first = torch.where(shares == best, ranks, count).amin(1)
        winner = torch.where(best[:, 0] > 0, order[first].int(), winner)
    winner = winner.reshape(size)
    alpha = (1 - blending.transmittance[:, -1]).reshape(size)
    return Contributions(weights, touched, count_wins(winner, count), winner, alpha)


def count_wins(winner: Int[Tensor, "h w"], count: int) -> Int[Tensor, "n"]:
    """Count the pixels that each of `count` Gaussians wins, by a sort, which needs no atomics."""
    ranked = winner.flatten().sort().values
    bounds = torch.arange(count + 1, dtype=ranked.dtype, device=ranked.device)
    return torch.searchsorted(ranked, bounds).diff().int()
