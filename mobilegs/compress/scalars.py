"""Numbers as whole multiples of a step: what takes the place of codebooks in the mode `sq`."""

from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from mobilegs.compress.codebooks import SIZE_MAX, Attribute
from mobilegs.errors import InputError

# columns of each attribute; the lobes' are as many as their decoder takes latents
COLUMNS: dict[Attribute, int] = {"scale": 3, "rotation": 3, "appearance": 6, "opacity": 1}
WEIGHT_DIGITS = 6  # of the networks' matrices
CODE_MAX = 1 << 14  # of either sign
REACH = SIZE_MAX // 2 - 1  # of what is coded: so a column always has few enough codes
FINEST = {"rotation": 0.002}  # steps; of all others 0.01
SPREAD = 0.1  # occurrences that every code between the least and the largest has for certain


@dataclass(frozen=True)
class ScalarSteps:
    """Steps between the numbers that a file can hold."""

    scale: float = 0.15
    """Of log-scales."""
    rotation: float = 0.3
    """Of angles about axes across which a Gaussian is round, in radians; others are finer."""
    appearance: float = 0.1
    """Of the colour's latents, in units of the mean change of all harmonics together."""
    opacity: float = 0.5
    """Of the base opacity's logit."""
    lobes: float = 1.0
    """Of the lobes' latents, in units of the mean change of all coefficients together."""

    def __post_init__(self) -> None:
        for name in (*COLUMNS, "lobes"):
            step, finest = getattr(self, name), FINEST.get(name, 0.01)
            if not finest <= step <= 100:
                raise InputError(f"the step of {name} must lie within {finest} to 100, not {step}")


class ScalarCodes(nn.Module):
    """Numbers `[n, s]` held as whole multiples of a step.

    Attributes:
        step: the step.
        indices: the multiples, `[n, s]`, a buffer.
    """

    indices: Tensor

    def __init__(self, step: float, indices: Int[Tensor, "n s"]) -> None:
        super().__init__()
        self.step = step
        self.register_buffer("indices", indices.detach().int())

    @classmethod
    def fit(cls, values: Float[Tensor, "n s"], *, step: float) -> "ScalarCodes":
        """The nearest codes of `values`."""
        codes = cls(step, torch.zeros_like(values, dtype=torch.int32))
        codes.reassign(values)
        return codes

    def forward(self, rows: Tensor | slice | None = None) -> Float[Tensor, "m s"]:
        """The values as the file will hold them, of all rows or of those that `rows` picks."""
        return (self.indices if rows is None else self.indices[rows]).float() * self.step

    @torch.no_grad()
    def reassign(self, values: Float[Tensor, "n s"]) -> None:
        """Give every row the codes nearest to its new values, up to 2,047 steps from 0."""
        self.indices = (values / self.step).round().clamp(-REACH, REACH).int()

    def select(self, rows: Tensor) -> None:
        """Keep only the rows that `rows` picks."""
        self.indices = self.indices[rows]

    @torch.no_grad()
    def slopes(self, values: Float[Tensor, "n s"]) -> Float[Tensor, "n s"]:
        """By how many bits a value's code grows with the value, per unit.

        A code takes `-log2` of the share that it has of its column; between two codes the price
        is interpolated.
        """
        places = values / self.step
        lower = places.floor()
        found = []
        for column, codes in zip(lower.T, self.indices.T, strict=True):
            least, prices = _prices(codes)
            at = (column - least).long().clamp(0, len(prices) - 2)
            found.append((prices[at + 1] - prices[at]) / self.step)
        return torch.stack(found, dim=1)


def _prices(column: Int[Tensor, "n"]) -> tuple[int, Float[Tensor, "k"]]:
    """Bits of each code from the first returned on, two more at either end than occur."""
    least, largest = int(column.min()) - 2, int(column.max()) + 2
    counts = torch.bincount(column.long() - least, minlength=largest - least + 1) + SPREAD
    return least, (counts.sum() / counts).log2()
