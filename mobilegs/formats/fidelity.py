"""Finds what a file does not hold of a scene, by comparing the scene with what is read back.

Lengths are relative to each Gaussian's own size, its largest standard deviation. Sizes below a
ten-thousandth of the scene count as that, because no image shows the difference. A change of
colour is the root mean square over all directions, of the channel that changes most.
"""

from dataclasses import dataclass

from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0

SIZE_MIN = 1e-4  # of the extent of nine in ten Gaussians
MOVED_FROM = 1.0  # of the size: distance from which a Gaussian is moved
RESIZED_FROM, RECOLORED_FROM = 0.25, 0.25  # of the size, of the range from black to white
LOST_FROM = 0.5  # of the size: change of it from which a Gaussian is lost


@dataclass(frozen=True)
class Fidelity:
    """The Gaussians of a scene that a file does not hold well.

    Attributes:
        count: all Gaussians.
        moved: those that are moved by more than their size.
        resized: those whose size changes by more than a quarter, in any direction.
        recolored: those whose colour changes by more than a quarter of the range.
        lost: those that are moved, or whose size changes by more than half.
    """

    count: int
    moved: int
    resized: int
    recolored: int
    lost: int

    def __str__(self) -> str:
        """Return what is lost in words; empty if nothing is."""
        parts = {
            "positions of {:,} move by more than their size": self.moved,
            "sizes of {:,} change by more than a quarter": self.resized,
            "colours of {:,} change by more than a quarter of the range": self.recolored,
        }
        changes = ", ".join(words.format(number) for words, number in parts.items() if number)
        return f"{changes}, out of {self.count:,} Gaussians" if changes else ""


def measure_fidelity(before: Gaussians, after: Gaussians) -> Fidelity:
    """Compare a scene, on the CPU, with what is read back, in the same order."""
    scales = before.log_scales.double().exp()
    size = scales.amax(1).clamp_min(SIZE_MIN * _extent(before.means))
    moved = (after.means.double() - before.means.double()).norm(dim=1) > MOVED_FROM * size
    resized = (after.log_scales.double().exp() - scales).abs().amax(1) / size
    change = (after.sh - before.sh).double().square().sum(1).amax(1).sqrt() * C0
    return Fidelity(
        len(before),
        _number(moved),
        _number(resized > RESIZED_FROM),
        _number(change > RECOLORED_FROM),
        _number(moved | (resized > LOST_FROM)),
    )


def _extent(means: Float[Tensor, "n 3"]) -> float:
    """Return the largest coordinate, from the median, of nine in ten Gaussians."""
    if not len(means):
        return 0.0
    away = (means.double() - means.double().median(0).values).abs().amax(1)
    return float(away.kthvalue(max(1, round(0.9 * len(away)))).values)


def _number(rows: Bool[Tensor, "n"]) -> int:
    return int(rows.sum())
