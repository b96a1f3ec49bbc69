"""Pruning by learned masks: each Gaussian learns how probable it is that it is needed."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn.functional import normalize, pad

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.lobes import lobe_degree
from mobilegs.spherical_harmonics import C0, sh_basis
from mobilegs.validation import FRACTION, NOT_NEGATIVE, check

LOGIT_MAX = 60.0  # beyond, exp(logit) leaves float32


@dataclass(frozen=True)
class PresenceConfig:
    """Masks beside the votes (after MaskGaussian, Liu et al. 2025, whose blending is sorted).

    Opacities are multiplied by random numbers that are near 1 with a Gaussian's probability, near
    0 else. Unlike a mask that is either, these let the absent receive gradients, which MaskGaussian
    gets from a rasteriser of its own.
    """

    weight: float = 0.0
    """Weight of the mean probability's square in the loss (MaskGaussian: 0.1 for a scene that is
    trained already): more leaves fewer Gaussians. 0 has no masks; 0.005 leaves some three
    quarters."""
    start: float = 0.95
    """Probability at the start."""
    temperature: float = 0.5
    """Of the random numbers: small ones are nearly 0 or 1, but tell less about the difference."""
    rate: float = 0.05
    """Rate of the probabilities' logits."""
    until: float = 0.4
    """Fraction of the run at which those below one half are removed, and the others stay: what
    follows learns without chance."""
    least: float = 0.05
    """Before, Gaussians that have become less probable than this go whenever votes are counted."""

    def __post_init__(self) -> None:
        if self.weight < 0 or not 0 < self.start < 1 or self.temperature <= 0:
            raise InputError(
                "masks need a weight of at least 0, a start within 0 to 1 and a temperature above "
                f"0, not {self.weight}, {self.start} and {self.temperature}"
            )
        check(self, rate=NOT_NEGATIVE, until=FRACTION, least=FRACTION)

    def logits(self, count: int, device: torch.device) -> Float[Tensor, "n"]:
        """Where the probabilities of `count` Gaussians begin."""
        return torch.full((count,), math.log(self.start / (1 - self.start)), device=device)

    def draw(self, logits: Float[Tensor, "n"], generator: torch.Generator) -> Float[Tensor, "n"]:
        """Random numbers in (0, 1), differentiable: the binary concrete distribution.

        Source: Maddison, Mnih, Teh 2017, `sigmoid((logits + log u - log(1 - u)) / temperature)`.
        """
        uniform = torch.rand(len(logits), generator=generator).clamp(1e-6, 1 - 1e-6)
        noise = torch.logit(uniform).to(logits.device)
        return torch.sigmoid((logits + noise) / self.temperature)

    def loss(self, logits: Float[Tensor, "n"]) -> Float[Tensor, ""]:
        """`weight mean(p)^2`: it pulls the less at each, the fewer there are."""
        return self.weight * logits.sigmoid().mean().square()

    def stay(self, logits: Float[Tensor, "n"], *, last: bool) -> Bool[Tensor, "n"]:
        """Which Gaussians are not removed."""
        return logits.sigmoid() >= (0.5 if last else self.least)


def fainter(
    lobes: Float[Tensor, "n m 2"],
    presence: Float[Tensor, "n"],
    means: Float[Tensor, "n 3"],
    camera: Camera,
) -> Float[Tensor, "n m 2"]:
    """Lobes whose opacity, as `camera` sees it, is `presence` times as large; phi is as it was.

    With the logit x along the ray, `sigmoid(x + d) = presence sigmoid(x)` for
    `d = log(presence) - log(1 + (1 - presence) exp(x))`. `presence` lies in (0, 1]; gradients reach
    it and the lobes.
    """
    directions = normalize(means.detach() - camera.position, dim=1)
    logits = (sh_basis(directions, lobe_degree(lobes)) * lobes[:, :, 0]).sum(1)
    presence = presence.clamp_min(torch.finfo(presence.dtype).tiny)
    more = torch.log1p((1 - presence) * logits.clamp_max(LOGIT_MAX).exp())
    shift = (torch.log(presence) - more) / C0
    return lobes + pad(shift[:, None, None], (0, 1, 0, lobes.shape[1] - 1))
