"""A set of 3D Gaussians in the raw parameters that training optimises."""

import logging
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.reproducible import sigmoid

log = logging.getLogger(__name__)

NUMBER_MAX = 1e30  # larger numbers count as infinite: their products overflow float32
SQUARE_MIN, SQUARE_MAX = 1e-24, 1e36  # of the length of a rotation that float32 can normalise
LOG_SCALE_MAX = 69.0  # logarithm of 1e30
LOGIT_MAX, LOG_SCALE_MIN = 13.8, -69.0  # replace infinities: logit of 1 - 1e-6, logarithm of 1e-30
UNDRAWABLE = "a rotation of length 0, an opacity of 0, or a number that is not finite"


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
        left_out: rows of the file that cannot be drawn, and are not among the Gaussians.
    """

    means: Float[Tensor, "n 3"]
    quats: Float[Tensor, "n 4"]
    log_scales: Float[Tensor, "n 3"]
    logit_opacities: Float[Tensor, "n"]
    sh: Float[Tensor, "n k 3"]
    left_out: int = field(default=0, init=False)

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
        return {each.name: getattr(self, each.name) for each in fields(self)[:5]}

    def select(self, rows: Bool[Tensor, "n"] | Int[Tensor, "m"] | slice) -> "Gaussians":
        """Return the Gaussians at `rows`: a mask, indices or a slice."""
        return Gaussians(**{name: value[rows] for name, value in self.tensors().items()})

    def to(
        self, device: torch.device | str | None = None, dtype: torch.dtype | None = None
    ) -> "Gaussians":
        """Return the Gaussians on `device` and in `dtype`."""
        moved = Gaussians(**{name: v.to(device, dtype) for name, v in self.tensors().items()})
        moved.left_out = self.left_out
        return moved

    def detached(self) -> "Gaussians":
        """Return the same values without gradients."""
        return Gaussians(**{name: value.detach() for name, value in self.tensors().items()})

    def can_be_drawn(self) -> Bool[Tensor, "n"]:
        """Return which Gaussians can be drawn, `[n]`.

        Their numbers are finite, which means below 1e30 in magnitude, the length of their rotation
        lies between 1e-12 and 1e18, their opacity is not 0, and their scales are below e^69. A
        scale of 0 and an opacity of 1 can be drawn: here, their logarithm or logit is infinite.
        `canBeDrawn` in viewer/src/load/ply.js is the same rule; a test compares the two.
        """
        square = self.quats.double().square().sum(1)
        good = (square > SQUARE_MIN) & (square < SQUARE_MAX)
        good &= (self.log_scales < LOG_SCALE_MAX).all(1)
        good &= self.logit_opacities > -NUMBER_MAX
        for value in (self.means, self.quats, self.sh):
            low, high = value.detach().unsqueeze(1).flatten(1).aminmax(dim=1)  # NaN stays NaN
            good &= (low > -NUMBER_MAX) & (high < NUMBER_MAX)
        return good

    def drawable(self, path: Path | str, count: int | None = None) -> "Gaussians":
        """Return the Gaussians that can be drawn, and warn how many rows of `path` are left out.

        Infinite logits of opacities become 13.8 and logarithms of scales of 0 become -69, which
        draws the same. `path` is the file that is read or written, `count` its rows, by default as
        many as there are Gaussians. Raises InputError if it has rows, and none can be drawn.
        """
        count = len(self) if count is None else count
        good = self.can_be_drawn()
        lost = count - int(good.sum())
        if lost and lost == count:
            raise InputError(f"{path} has no Gaussian that can be drawn: each has {UNDRAWABLE}")
        if lost:
            message = "%s: left out %d of %d Gaussians, which cannot be drawn: they have %s"
            log.warning(message, path, lost, count, UNDRAWABLE)
        drawn = self.select(good) if lost else self
        solid = drawn.logit_opacities > NUMBER_MAX
        flat = drawn.log_scales < -NUMBER_MAX
        drawn = replace(
            drawn,
            logit_opacities=drawn.logit_opacities.masked_fill(solid, LOGIT_MAX),
            log_scales=drawn.log_scales.masked_fill(flat, LOG_SCALE_MIN),
        )
        drawn.left_out = lost
        return drawn
