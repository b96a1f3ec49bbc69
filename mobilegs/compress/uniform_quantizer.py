"""Numbers as whole multiples of a step: what takes the place of codebooks in the mode `sq`."""

import math
from dataclasses import asdict, dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from mobilegs.compress.codebooks import SIZE_MAX, Attribute
from mobilegs.errors import InputError

# columns of each attribute; colours and lobes have as many as their decoders take latents
COLUMNS: dict[Attribute, int] = {"scale": 3, "rotation": 3, "appearance": 0, "opacity": 1}
WEIGHT_DIGITS = 6  # of the networks' matrices
CODE_MAX = 1 << 14  # of either sign
REACH = SIZE_MAX // 2 - 1  # of what is coded: so a column always has few enough codes
STEP_MIN, STEP_MAX = 0.01, 100.0  # the smallest still reaches 20 to either side
ANGLE_STEPS = 0.002, 4.0  # angles reach half a turn; with such a step more a file holds them
NUDGE = 1.05
SPREAD = 0.1  # occurrences that every code between the least and the largest has for certain


@dataclass(frozen=True)
class ScalarSteps:
    """Steps between the numbers that a file can hold."""

    scale: float = 0.15
    """Of log-scales."""
    rotation: float = 0.25
    """Of angles about axes across which a Gaussian is round, in radians; others are finer."""
    appearance: float = 0.14
    """Of the colour's latents, in units of the mean change of all harmonics together."""
    opacity: float = 0.6
    """Of the base opacity's logit."""
    lobes: float = 1.7
    """Of the lobes' latents, in units of the mean change of all coefficients together."""

    def __post_init__(self) -> None:
        for name in (*COLUMNS, "lobes"):
            step = getattr(self, name)
            finest, coarsest = ANGLE_STEPS if name == "rotation" else (STEP_MIN, STEP_MAX)
            if not finest <= step <= coarsest:
                raise InputError(
                    f"the step of {name} must lie within {finest} to {coarsest:g}, not {step:g}"
                )

    def finer(self, times: float) -> "ScalarSteps":
        """Steps so many times as fine; an InputError if a file cannot hold them."""
        try:
            return ScalarSteps(**{name: step / times for name, step in asdict(self).items()})
        except InputError as error:
            raise InputError(f"with a fineness of {times:g} {error}") from None


class ScalarCodes(nn.Module):
    """Numbers `[n, s]` held as whole multiples of a step, which may learn.

    Attributes:
        growth: logarithm of what the step is now in units of what it was at first, a parameter.
        indices: the multiples, `[n, s]`, a buffer.
    """

    indices: Tensor

    def __init__(self, step: float, indices: Int[Tensor, "n s"]) -> None:
        super().__init__()
        self.first = step
        self.growth = nn.Parameter(torch.zeros((), device=indices.device))
        self.register_buffer("indices", indices.detach().int())

    @property
    def step(self) -> Float[Tensor, ""]:
        """The step as it is now."""
        return (self.first * self.growth.exp()).clamp(STEP_MIN, STEP_MAX)

    @classmethod
    def fit(cls, values: Float[Tensor, "n s"], *, step: float) -> "ScalarCodes":
        """The nearest codes of `values`."""
        codes = cls(step, torch.zeros_like(values, dtype=torch.int32))
        codes.reassign(values)
        return codes

    def forward(
        self, rows: Tensor | slice | None = None, wanted: Float[Tensor, "m s"] | None = None
    ) -> Float[Tensor, "m s"]:
        """The values as the file will hold them, of all rows or of those that `rows` picks.

        With what these are `wanted` to be the step has a gradient, as in "Learned Step Size
        Quantization" (Esser et al., 2020): the errors of the rounding grow with it.
        """
        multiples = (self.indices if rows is None else self.indices[rows]).float()
        return stepped(multiples, self.step, wanted)

    @torch.no_grad()
    def reassign(self, values: Float[Tensor, "n s"]) -> None:
        """Give every row the codes nearest to its new values, up to 2,047 steps from 0."""
        self.indices = self.nearest(values, self.step)

    @staticmethod
    def nearest(values: Tensor, step: Float[Tensor, ""]) -> Int[Tensor, "n s"]:
        """The codes nearest to `values`."""
        return (values / step).round().clamp(-REACH, REACH).int()

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

    @torch.no_grad()
    def bits_by_growth(self, values: Float[Tensor, "n s"]) -> float:
        """By how many bits a row of codes grows with `growth`: one less for every doubled code."""
        step = self.step
        finer, coarser = (entropy(self.nearest(values, step * f)) for f in (1 / NUDGE, NUDGE))
        return (coarser - finer) / (2 * math.log(NUDGE))


def stepped(
    multiples: Float[Tensor, "m s"], step: Float[Tensor, ""], wanted: Float[Tensor, "m s"] | None
) -> Float[Tensor, "m s"]:
    """`multiples` of a step; with what they are `wanted` to be, the step has a gradient."""
    fixed = step.detach()
    values = multiples * fixed
    if wanted is None:
        return values
    return values + (multiples - wanted.detach() / fixed) * (step - fixed)


def reach(codes: Int[Tensor, "n s"]) -> tuple[Int[Tensor, "s"], Int[Tensor, "s"]]:
    """The least and the largest code of each column; there must be a row.

    Short rows are taken 64 at a time, since a reduction along long columns takes 15 times as long.
    """
    many = len(codes) // 64 * 64
    parts = [codes[many:]]
    if many:
        long = codes[:many].reshape(many // 64, -1)
        parts += [found.view(64, -1) for found in (long.amin(0), long.amax(0))]
    ends = torch.cat(parts)
    return ends.amin(0), ends.amax(0)


def entropy(codes: Int[Tensor, "n s"]) -> float:
    """Bits that a row of `codes` takes, each column by itself."""
    bits = 0.0
    for column in codes.T:
        counts = torch.bincount((column - column.min()).long())
        shares = counts[counts > 0] / len(column)
        bits -= float((shares * shares.log2()).sum())
    return bits


def _prices(column: Int[Tensor, "n"]) -> tuple[int, Float[Tensor, "k"]]:
    """Bits of each code from the first returned on, two more at either end than occur."""
    least, largest = int(column.min()) - 2, int(column.max()) + 2
    counts = torch.bincount(column.long() - least, minlength=largest - least + 1) + SPREAD
    return least, (counts.sum() / counts).log2()
