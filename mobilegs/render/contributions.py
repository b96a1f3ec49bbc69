"""Who a picture owes its light to: the definition of sorted blending's statistics."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import project
from mobilegs.render.sorted import blend

NOBODY = -1


class Contributions(NamedTuple):
    """What each Gaussian gives to a picture blended front to back; without gradients.

    A Gaussian's share of a pixel is `a T`: its alpha there, times the light that those in front
    let pass. Pixels that the early stop keeps from it have no share.

    Attributes:
        weights: sum of its shares, in pixels, `[n]`.
        touched: number of pixels of which it has a share, int32, `[n]`.
        largest: number of pixels of which it has the largest share, int32, `[n]`.
        winner: whose share of a pixel is the largest, the nearer one's of equal shares, -1 where
            nobody has one, int32, `[h, w]`.
        alpha: how much of the background is covered, in [0, 1], `[h, w]`.
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
) -> Contributions:
    """The statistics of one picture, of which Mini-Splatting (Fang and Wang 2024) makes use."""
    black = torch.zeros_like(means[:, None, :])
    blending = blend(
        project(means, quats, scales, opacities, black, camera=camera), opacities, camera
    )
    shares, order = blending.shares, blending.order  # [pixels, n], front first
    count, size = len(means), (camera.height, camera.width)
    weights, touched = torch.zeros_like(opacities), torch.zeros_like(order, dtype=torch.int32)
    weights[order] = shares.sum(0)
    touched[order] = (shares > 0).sum(0, dtype=torch.int32)
    winner = torch.full((len(shares),), NOBODY, dtype=torch.int32, device=means.device)
    if count:
        best = shares.amax(1, keepdim=True)
        # argmax of equal values may be any of them
        ranks = torch.arange(count, device=means.device).expand_as(shares)
        first = torch.where(shares == best, ranks, count).amin(1)
        winner = torch.where(best[:, 0] > 0, order[first].int(), winner)
    winner = winner.reshape(size)
    alpha = (1 - blending.light[:, -1]).reshape(size)
    return Contributions(weights, touched, pixels_won(winner, count), winner, alpha)


def pixels_won(winner: Int[Tensor, "h w"], count: int) -> Int[Tensor, "n"]:
    """How many pixels each of `count` Gaussians has won; by sorting, which needs no atomics."""
    ranked = winner.flatten().sort().values
    bounds = torch.arange(count + 1, dtype=ranked.dtype, device=ranked.device)
    return torch.searchsorted(ranked, bounds).diff().int()
