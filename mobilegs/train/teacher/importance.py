"""What Gaussians are worth to the training views, and who stays when there are too many."""

from collections.abc import Sequence
from typing import Literal

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import measure_contributions

Metric = Literal["indoor", "outdoor"]
LEAST = 1e-6  # importance that even a Gaussian without any counts with in the second choice


@torch.no_grad()
def importance(
    gaussians: Gaussians, cameras: Sequence[Camera], metric: Metric
) -> Float[Tensor, "n"]:
    """What each Gaussian gives to the views of `cameras`, which are drawn one by one.

    `indoor` adds up its shares of all pixels. `outdoor` adds up, over the views in which it has
    the largest share of a pixel, its mean share of the pixels that it touches, so that the far
    and small count, too. Either is 0 for Gaussians that have the largest share of no pixel of
    any view ("intersection preserving", Mini-Splatting section 4.2).
    """
    total = torch.zeros_like(gaussians.logit_opacities)
    wins = torch.zeros_like(total, dtype=torch.bool)
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
    for camera in cameras:
        found = measure_contributions(*shapes, camera=camera.to(total.device))
        first = found.largest > 0
        if metric == "indoor":
            total += found.weights
        else:
            total += torch.where(first, found.weights / found.touched.clamp_min(1), 0.0)
        wins |= first
    return torch.where(wins, total, 0.0)


def drawn_rows(
    weights: Float[Tensor, "n"], count: int, generator: torch.Generator
) -> Int[Tensor, "m"]:
    """At most `count` indices, rising, drawn with chances as `weights` without replacement.

    Those of weight 0 are never drawn. `torch.multinomial` refuses more than 16 million weights;
    this is the same by Efraimidis and Spirakis: the largest of `log(uniform) / weight`.
    """
    weights = weights.double().cpu()
    keys = torch.rand(len(weights), dtype=torch.float64, generator=generator).log() / weights
    count = min(count, int((weights > 0).sum()))
    return torch.where(weights > 0, keys, -torch.inf).topk(count).indices.sort().values


def holding_most(values: Float[Tensor, "n"], share: float) -> Bool[Tensor, "n"]:
    """All but the least, which together hold no more than `1 - share` of the total."""
    ranked = (values.double() + LEAST).sort(stable=True)
    held = ranked.values.cumsum(0)
    kept = held > (1 - share) * held[-1:]
    return torch.zeros_like(kept).index_put((ranked.indices,), kept)
