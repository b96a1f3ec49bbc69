"""Pruning by learned masks: each Gaussian learns the probability that the scene needs it."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.nn.functional import normalize, pad

from mobilegs.camera import Camera
from mobilegs.render.lobes import lobe_degree
from mobilegs.reproducible import sigmoid, total
from mobilegs.spherical_harmonics import C0, sh_basis
from mobilegs.validation import FRACTION, NOT_NEGATIVE, POSITIVE, Range, check

LOGIT_MAX = 60.0  # exp of larger logits exceeds float32


@dataclass(frozen=True)
class MaskConfig:
    """Masks as in MaskGaussian (Liu et al. 2025), but for blending without sorting.

    Opacities are multiplied by random masks: near 1 with the Gaussian's probability, and near 0
    otherwise. Masks are never exactly 0, so masked Gaussians still receive gradients;
    MaskGaussian has a rasteriser of its own for that. `lr.masks` is their learning rate.
    """

    weight: float = 0.0
    """Weight of the squared mean probability in the loss, at least 0 (MaskGaussian: 0.1, for a
    trained scene). Larger weights leave fewer Gaussians; 0.005 leaves about three quarters. 0
    switches masks off."""
    initial_probability: float = 0.95
    """Probability at the start, between 0 and 1."""
    temperature: float = 0.5
    """Temperature of the masks, above 0. Low temperatures give masks of nearly 0 or 1, but noisy
    gradients."""
    until: float = 0.4
    """Time at which masks end, 0 to 1: Gaussians with a probability below 0.5 are removed, and the
    others train on without masks."""
    min_probability: float = 0.05
    """Probability, 0 to 1, below which Gaussians are removed before `until`, each time that votes
    prune."""

    def __post_init__(self) -> None:
        check(
            self,
            weight=NOT_NEGATIVE,
            initial_probability=Range(high=1.0, above=True, below=True),
            temperature=POSITIVE,
            until=FRACTION,
            min_probability=FRACTION,
        )

    def initial_logits(self, count: int, device: torch.device) -> Float[Tensor, "n"]:
        """Return the logits of the probabilities of `count` Gaussians at the start."""
        logit = math.log(self.initial_probability / (1 - self.initial_probability))
        return torch.full((count,), logit, device=device)

    def sample(self, logits: Float[Tensor, "n"], generator: torch.Generator) -> Float[Tensor, "n"]:
        """Draw masks in (0, 1) from the binary concrete distribution, differentiably.

        Source: Maddison, Mnih, Teh 2017, `sigmoid((logits + log u - log(1 - u)) / temperature)`.
        """
        uniform = torch.rand(len(logits), generator=generator).clamp(1e-6, 1 - 1e-6)
        noise = torch.logit(uniform).to(logits.device)
        return sigmoid((logits + noise) / self.temperature)

    def loss(self, logits: Float[Tensor, "n"]) -> Float[Tensor, ""]:
        """Return `weight mean(p)^2`; its gradient falls with the number of Gaussians left."""
        return self.weight * (total(sigmoid(logits)) / len(logits)).square()

    def kept(self, logits: Float[Tensor, "n"], *, final: bool) -> Bool[Tensor, "n"]:
        """Return the Gaussians that stay; `final` is the removal at the end of the masks."""
        return sigmoid(logits) >= (0.5 if final else self.min_probability)


def mask_lobes(
    lobes: Float[Tensor, "n m 2"],
    masks: Float[Tensor, "n"],
    means: Float[Tensor, "n 3"],
    camera: Camera,
) -> Float[Tensor, "n m 2"]:
    """Return lobes with the opacities, as `camera` sees them, multiplied by `masks`; phi stays.

    For the logit x along the ray, `sigmoid(x + d) = mask sigmoid(x)` with
    `d = log(mask) - log(1 + (1 - mask) exp(x))`. Masks are in (0, 1]. Gradients reach masks and
    lobes.
    """
    directions = normalize(means.detach() - camera.position, dim=1)
    logits = (sh_basis(directions, lobe_degree(lobes)) * lobes[:, :, 0]).sum(1)
    masks = masks.clamp_min(torch.finfo(masks.dtype).tiny)
    correction = torch.log1p((1 - masks) * logits.clamp_max(LOGIT_MAX).exp())
    shift = (torch.log(masks) - correction) / C0
    return lobes + pad(shift[:, None, None], (0, 1, 0, lobes.shape[1] - 1))
