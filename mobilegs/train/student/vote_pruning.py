"""Pruning by votes (paper, section 3.4) of Gaussians that most views see small and faint."""

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.validation import COUNT, FRACTION, check

CRITERIA = ("both", "opacity", "scale")


@dataclass(frozen=True)
class VoteConfig:
    """Criteria and schedule of pruning by votes."""

    criterion: str = "both"
    """Values that must lie below the quantile: `both` opacity and largest scale, as in the paper,
    or one of them, `opacity` or `scale`."""
    quantile: float = 0.2
    """Quantile of all Gaussians, 0 to 1, below which a vote goes against a Gaussian (paper: 0.2).
    0 never prunes."""
    share: float = 0.6
    """Share of an interval's votes, 0 to 1, above which a Gaussian is removed (paper: 0.6)."""
    interval: float = 1 / 30
    """Time between two prunings, 0 to 1 (paper: 1,000 of 30,000)."""
    until: float = 0.8
    """Time of the last pruning, 0 to 1 (paper: 24,000 of 30,000)."""
    votes_per_interval: int = 12
    """Evenly spaced steps per interval that hold a vote, at least 1. A vote evaluates opacities of
    all Gaussians, visible or not. (The release votes in every step.)"""

    def __post_init__(self) -> None:
        if self.criterion not in CRITERIA:
            raise InputError(
                f"unknown criterion '{self.criterion}': use one of {', '.join(CRITERIA)}"
            )
        fractions = dict.fromkeys(("quantile", "share", "interval", "until"), FRACTION)
        check(self, votes_per_interval=COUNT, **fractions)


def vote(
    opacities: Float[Tensor, "n"],
    scales: Float[Tensor, "n 3"],
    *,
    quantile: float,
    criterion: str = "both",
) -> Bool[Tensor, "n"]:
    """Return the Gaussians with opacity and largest scale (or one) below the `quantile` of all.

    `opacities` are those seen from one camera. Quantiles interpolate linearly. The comparison is
    strict, so that no vote goes against equal values.
    """
    if not len(opacities):
        return torch.zeros_like(opacities, dtype=torch.bool)
    largest = scales.amax(1)
    faint = opacities < _quantile(opacities, quantile)
    small = largest < _quantile(largest, quantile)
    return {"both": faint & small, "opacity": faint, "scale": small}[criterion]


def _quantile(values: Float[Tensor, "n"], q: float) -> Float[Tensor, ""]:
    # torch.quantile raises an error above 16 million values, and sorts them all
    place = q * (len(values) - 1)
    low, high = int(place), min(int(place) + 1, len(values) - 1)
    if values.is_cuda:  # there a sort takes a tenth of the time of kthvalue
        ordered = values.sort().values
        first, second = ordered[low], ordered[high]
    else:
        first, second = (values.kthvalue(rank + 1).values for rank in (low, high))
    return first + (second - first) * (place - low)


class VoteCounter:
    """The votes of one interval, and the schedule of votes and prunings in a run.

    Attributes:
        against: votes against each Gaussian in this interval, `[n]`.
        held: votes in this interval.
    """

    def __init__(self, config: VoteConfig, steps: int, count: int, device: torch.device) -> None:
        """Begin the first interval of a run of `steps`, with `count` Gaussians."""
        self.config = config
        self.set_steps(steps)
        self.against = torch.zeros(count, dtype=torch.int32, device=device)
        self.held = 0

    def set_steps(self, steps: int) -> None:
        """Fit the schedule to a run of `steps`; votes of the current interval count on."""
        self.interval = max(1, round(self.config.interval * steps))
        self.until = round(self.config.until * steps)
        self.spacing = max(1, self.interval // self.config.votes_per_interval)

    def votes_at(self, step: int) -> bool:
        """Return whether step `step`, counted from 1, holds a vote."""
        return self.config.quantile > 0 and step <= self.until and step % self.spacing == 0

    def prunes_after(self, step: int) -> bool:
        """Return whether an interval ends with step `step`, counted from 1."""
        return step <= self.until and step % self.interval == 0

    def add(self, candidates: Bool[Tensor, "n"]) -> None:
        """Count one vote against `candidates`."""
        self.against += candidates
        self.held += 1

    def kept(self) -> Bool[Tensor, "n"]:
        """Return the Gaussians with at most `share` of the votes against them."""
        return self.against <= self.config.share * self.held

    def reset(self, count: int) -> None:
        """Begin the next interval, with `count` Gaussians."""
        self.against = torch.zeros(count, dtype=torch.int32, device=self.against.device)
        self.held = 0

    def state(self) -> dict:
        """Return the votes of this interval."""
        return {"against": self.against, "held": self.held}

    def restore(self, state: dict) -> None:
        """Continue from the result of `state()`."""
        self.against = state["against"].to(self.against.device)
        self.held = state["held"]
