"""Uniform quantisation: numbers as integer multiples of a step size (mode `sq`)."""

import math
from dataclasses import asdict, dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from mobilegs.errors import InputError
from mobilegs.representation.codebooks import SIZE_MAX, Attribute
from mobilegs.reproducible import times

# columns of each attribute; `appearance` and `lobes` have one per latent of their decoders
COLUMNS: dict[Attribute, int] = {"scale": 3, "rotation": 3, "appearance": 0, "opacity": 1}
WEIGHT_SIGNIFICAND_BITS = 6  # of the networks' matrices
CODE_MAX = 1 << 14  # largest magnitude of a code in a file
CODE_LIMIT = SIZE_MAX // 2 - 1  # codes are clamped to it; a column has SIZE_MAX values at most
STEP_SIZE_MIN, STEP_SIZE_MAX = 0.01, 100.0  # with the smallest, values of +-20 fit in CODE_LIMIT
ANGLE_STEP_RANGE = 0.002, 4.0  # radians; angles are at most pi, which fits a file in this range
STEP_RATIO = 1.05  # of the finite differences that give a gradient to a step size
PSEUDO_COUNT = 0.1  # added to the count of every code from the smallest to the largest


@dataclass(frozen=True)
class StepSizes:
    """Step sizes of the uniform quantisers.

    Each must lie within 0.01 to 100, `rotation` within 0.002 to 4. Raises InputError otherwise.
    """

    scale: float = 0.15
    """Step size of the log-scales."""
    rotation: float = 0.25
    """Step size of the rotation angles, in radians, about axes with a round cross-section. Other
    axes have up to 8 refinement bits."""
    appearance: float = 0.14
    """Step size of the colour latents. In their unit, a change by 1 moves all harmonics by 1 (root
    of the summed squares, mean over the Gaussians)."""
    opacity: float = 0.6
    """Step size of the base opacity's logit."""
    lobes: float = 1.7
    """Step size of the lobe latents. In their unit, a change by 1 moves the lobes' coefficients by
    1, measured in the same way."""

    def __post_init__(self) -> None:
        for name in (*COLUMNS, "lobes"):
            step_size = getattr(self, name)
            low, high = ANGLE_STEP_RANGE if name == "rotation" else (STEP_SIZE_MIN, STEP_SIZE_MAX)
            if not low <= step_size <= high:
                raise InputError(
                    f"the step size of {name} must lie within {low} to {high:g}, not {step_size:g}"
                )

    def divided_by(self, quality: float) -> "StepSizes":
        """Return the step sizes divided by `quality`; InputError if one leaves its range."""
        try:
            return StepSizes(**{name: size / quality for name, size in asdict(self).items()})
        except InputError as error:
            raise InputError(f"with a quality of {quality:g} {error}") from None


class StepSizeQuantizer(nn.Module):
    """Numbers as integers, in units of a learned step size.

    Attributes:
        log_step_offset: logarithm of the step size relative to its initial value, a parameter.
        indices: the integers, `[n, s]`, a buffer.
    """

    indices: Tensor
    step_size_range = STEP_SIZE_MIN, STEP_SIZE_MAX

    def __init__(self, step_size: float, indices: Int[Tensor, "n s"]) -> None:
        super().__init__()
        self.initial_step_size = step_size
        self.log_step_offset = nn.Parameter(torch.zeros((), device=indices.device))
        self.register_buffer("indices", indices.detach().int())

    @property
    def step_size(self) -> Float[Tensor, ""]:
        """The current step size."""
        return self._grown().clamp(*self.step_size_range)

    def _grown(self) -> Float[Tensor, ""]:
        """Return the step size before it is limited."""
        return self.initial_step_size * self.log_step_offset.exp()

    def select(self, rows: Tensor) -> None:
        """Keep only the rows that `rows` picks."""
        self.indices = self.indices[rows]

    @staticmethod
    def nearest(values: Tensor, step_size: Float[Tensor, ""]) -> Int[Tensor, "n s"]:
        """Return the integers nearest to `values`."""
        raise NotImplementedError

    @torch.no_grad()
    def log_step_gradient(self, values: Tensor) -> float:
        """Return the derivative of the bits per row with respect to `log_step_offset`.

        Each doubling of the step size takes about one bit per column.
        """
        step = self.step_size
        codes = (self.nearest(values, step * f) for f in (1 / STEP_RATIO, STEP_RATIO))
        fine, coarse = (entropy(each) for each in codes)
        return (coarse - fine) / (2 * math.log(STEP_RATIO))


class UniformQuantizer(StepSizeQuantizer):
    """Numbers `[n, s]` as integer multiples of a learned step size."""

    @classmethod
    def fit(cls, values: Float[Tensor, "n s"], *, step_size: float) -> "UniformQuantizer":
        """Return a quantiser with the nearest codes of `values`."""
        quantizer = cls(step_size, torch.zeros_like(values, dtype=torch.int32))
        quantizer.reassign(values)
        return quantizer

    def forward(
        self, rows: Tensor | slice | None = None, targets: Float[Tensor, "m s"] | None = None
    ) -> Float[Tensor, "m s"]:
        """Return the dequantised values of `rows` (None: all), as a file holds them.

        With `targets`, the unquantised values, the step size has a gradient, that of "Learned Step
        Size Quantization" (Esser et al., 2020): rounding errors are proportional to it.
        """
        multiples = (self.indices if rows is None else self.indices[rows]).float()
        return scale_multiples(multiples, self.step_size, targets)

    @torch.no_grad()
    def reassign(self, values: Float[Tensor, "n s"]) -> None:
        """Assign every row the codes nearest to its new values, clamped to +-2,047."""
        self.indices = self.nearest(values, self.step_size)

    @staticmethod
    def nearest(values: Tensor, step_size: Float[Tensor, ""]) -> Int[Tensor, "n s"]:
        return (values / step_size).round().clamp(-CODE_LIMIT, CODE_LIMIT).int()

    @torch.no_grad()
    def bits_gradient(self, values: Float[Tensor, "n s"]) -> Float[Tensor, "n s"]:
        """Return the derivative of each code's length, in bits, with respect to its value.

        A code's length is `-log2` of its share of its column, interpolated linearly between codes.
        """
        multiples = values / self.step_size
        lower = multiples.floor()
        gradients = []
        for column, codes in zip(lower.T, self.indices.T, strict=True):
            least, lengths = _code_lengths(codes)
            at = (column - least).long().clamp(0, len(lengths) - 2)
            gradients.append((lengths[at + 1] - lengths[at]) / self.step_size)
        return torch.stack(gradients, dim=1)


def scale_multiples(
    multiples: Float[Tensor, "m s"],
    step_size: Float[Tensor, ""],
    targets: Float[Tensor, "m s"] | None,
) -> Float[Tensor, "m s"]:
    """Return `multiples * step_size`; with `targets`, the step size has a gradient."""
    fixed = step_size.detach()
    values = multiples * fixed
    if targets is None:
        return values
    return values + times(multiples - targets.detach() / fixed, step_size - fixed)


def column_ranges(codes: Int[Tensor, "n s"]) -> tuple[Int[Tensor, "s"], Int[Tensor, "s"]]:
    """Return the least and the largest code of each column; `n` is at least 1.

    Rows are reduced in groups of 64: a reduction along long columns takes 15 times as long.
    """
    many = len(codes) // 64 * 64
    parts = [codes[many:]]
    if many:
        long = codes[:many].reshape(many // 64, -1)
        parts += [ends.view(64, -1) for ends in (long.amin(0), long.amax(0))]
    ends = torch.cat(parts)
    return ends.amin(0), ends.amax(0)


def entropy(codes: Int[Tensor, "n s"]) -> float:
    """Return the entropy of a row of `codes` in bits, summed over independent columns."""
    bits = 0.0
    for column in codes.T:
        counts = torch.bincount((column - column.min()).long())
        shares = counts[counts > 0] / len(column)
        bits -= float((shares * shares.log2()).sum())
    return bits


def _code_lengths(column: Int[Tensor, "n"]) -> tuple[int, Float[Tensor, "k"]]:
    """Return a first code, two below the least, and the bits of each from there to two above."""
    least, largest = int(column.min()) - 2, int(column.max()) + 2
    counts = torch.bincount(column.long() - least, minlength=largest - least + 1) + PSEUDO_COUNT
    return least, (counts.sum() / counts).log2()
