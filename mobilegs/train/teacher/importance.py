"""Importance of Gaussians for the training views, and selections by it (Mini-Splatting)."""

from collections.abc import Sequence
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint, measure_contributions
from mobilegs.render.project import CLASSIC

Metric = Literal["indoor", "outdoor"]
IMPORTANCE_MIN = 1e-6  # added to every Gaussian before `importance_mask` ranks them


@torch.no_grad()
def importance(
    gaussians: Gaussians,
    cameras: Sequence[Camera],
    metric: Metric,
    footprint: Footprint = CLASSIC,
) -> Float[Tensor, "n"]:
    """Return the contribution of each Gaussian to the images of `cameras`.

    `indoor` sums its blending weights over all pixels. `outdoor` sums, over the views in which it
    has the largest weight of some pixel, its mean weight over the pixels that it touches; distant
    and small Gaussians then count more. Both are 0 for Gaussians that have the largest weight of no
    pixel in any view ("intersection preserving", Mini-Splatting section 4.2).
    """
    total = torch.zeros_like(gaussians.logit_opacities)
    wins = torch.zeros_like(total, dtype=torch.bool)
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
    for camera in cameras:
        view = camera.to(total.device)
        contributions = measure_contributions(*shapes, camera=view, footprint=footprint)
        weights, first = contributions.weights, contributions.largest > 0
        if metric == "indoor":
            total += weights
        else:
            total += torch.where(first, weights / contributions.touched.clamp_min(1), 0.0)
        wins |= first
    return torch.where(wins, total, 0.0)


def sample_rows(
    weights: Float[Tensor, "n"], count: int, generator: torch.Generator
) -> Int[Tensor, "m"]:
    """Sample at most `count` indices without replacement, in proportion to `weights`.

    The indices are in increasing order; those of weight 0 are never sampled. This is the method of
    Efraimidis and Spirakis, the largest values of `log(uniform) / weight`, because
    `torch.multinomial` does not take more than 16 million weights.
    """
    weights = weights.double().cpu()
    keys = torch.rand(len(weights), dtype=torch.float64, generator=generator).log() / weights
    count = min(count, int((weights > 0).sum()))
    return torch.where(weights > 0, keys, -torch.inf).topk(count).indices.sort().values


def importance_mask(values: Float[Tensor, "n"], share: float) -> Bool[Tensor, "n"]:
    """Return a mask without the smallest values, which hold at most `1 - share` of the total."""
    ranked = (values.double() + IMPORTANCE_MIN).sort(stable=True)
    held = ranked.values.cumsum(0)
    kept = held > (1 - share) * held[-1:]
    return torch.zeros_like(kept).index_put((ranked.indices,), kept)
