"""Pruning by learned masks: each Gaussian learns how probable it is that it is needed."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.train.ranges import FRACTION, NOT_NEGATIVE, check


@dataclass(frozen=True)
class PresenceConfig:
    """Masks as a rival of the votes, for sorted blending (after MaskGaussian, Liu et al. 2025).

    Opacities are multiplied by random numbers that are near 1 with a Gaussian's probability, near
    0 else. Unlike a mask that is either, these let the absent receive gradients, which MaskGaussian
    gets from a rasteriser of its own.
    """

    weight: float = 0.0
    """Weight of the mean probability's square in the loss (MaskGaussian: 0.1 for a scene that is
    trained already); 0 has no masks."""
    start: float = 0.95
    """Probability at the start."""
    temperature: float = 0.5
    """Of the random numbers: small ones are nearly 0 or 1, but tell less about the difference."""
    rate: float = 0.01
    """Rate of the probabilities' logits."""
    least: float = 0.05
    """Gaussians that have become less probable than this are removed now and then, as the votes
    would; after the last time, those below one half."""

    def __post_init__(self) -> None:
        if self.weight < 0 or not 0 < self.start < 1 or self.temperature <= 0:
            raise InputError(
                "masks need a weight of at least 0, a start within 0 to 1 and a temperature above "
                f"0, not {self.weight}, {self.start} and {self.temperature}"
            )
        check(self, rate=NOT_NEGATIVE, least=FRACTION)

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
