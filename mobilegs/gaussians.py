"""A set of 3D Gaussians in the raw parameters that training optimises."""

import logging
from dataclasses import dataclass, fields
from pathlib import Path

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mobilegs.reproducible import sigmoid

log = logging.getLogger(__name__)


@dataclass
class Gaussians:
    """3D Gaussians, parameterised as in 3DGS (Kerbl et al. 2023).

    Attributes:
        means: positions in world space, `[n, 3]`.
        quats: rotations as quaternions wxyz of any length but 0, `[n, 4]`.
        log_scales: natural logarithm of the standard deviations along the rotated axes, in world
            units, `[n, 3]`.
        logit_opacities: opacity before the sigmoid, `[n]`.
        sh: spherical harmonics of the colour, `[n, (degree + 1)^2, 3]`, degree 0 to 3; the
            colour in a direction is `max(0, 0.5 + sum(sh * basis))` (`sh_colors`).
    """

    means: Float[Tensor, "n 3"]
    quats: Float[Tensor, "n 4"]
    log_scales: Float[Tensor, "n 3"]
    logit_opacities: Float[Tensor, "n"]
    sh: Float[Tensor, "n k 3"]

    def __len__(self) -> int:
        return self.means.shape[0]

    @property
    def scales(self) -> Float[Tensor, "n 3"]:
        """Standard deviations in world units, `[n, 3]`."""
        return self.log_scales.exp()

    @property
    def opacities(self) -> Float[Tensor, "n"]:
        """Opacities in (0, 1), `[n]`."""
        return sigmoid(self.logit_opacities)

    @property
    def sh_degree(self) -> int:
        """Degree of the colour's spherical harmonics, 0 to 3."""
        return round(self.sh.shape[1] ** 0.5) - 1

    def tensors(self) -> dict[str, Tensor]:
        """Return the five tensors by name, in the order of the fields."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def select(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"] | slice) -> "Gaussians":
        """Return the Gaussians at `rows`: a mask, indices or a slice."""
        return Gaussians(**{name: value[rows] for name, value in self.tensors().items()})

    def to(
        self, device: torch.device | str | None = None, dtype: torch.dtype | None = None
    ) -> "Gaussians":
        """Return the Gaussians on `device` and in `dtype`."""
        return Gaussians(**{name: v.to(device, dtype) for name, v in self.tensors().items()})

    def detached(self) -> "Gaussians":
        """Return the same values without gradients."""
        return Gaussians(**{name: value.detach() for name, value in self.tensors().items()})

    def finite(self, path: Path | str) -> "Gaussians":
        """Return the Gaussians with finite values only, and warn how many of `path` are not."""
        good = torch.ones(len(self), dtype=torch.bool, device=self.means.device)
        for value in self.tensors().values():
            good &= value.isfinite().unsqueeze(1).flatten(1).all(1)
        lost = len(self) - int(good.sum())
        if not lost:
            return self
        log.warning(
            "%s: left out %d of %d Gaussians, which have values that are not finite",
            path,
            lost,
            len(self),
        )
        return self.select(good)
