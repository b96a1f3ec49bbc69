"""Pruning by votes (paper, section 3.4) of Gaussians that most views see small and faint."""

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.train.times import Times
from mobilegs.validation import COUNT, FRACTION, check

TIME_MIN = 1e-9  # an interval of 0 ends with every step
VOTE_SHARE = 0.6  # of an interval's votes above which a Gaussian is removed (paper: 0.6)


@dataclass(frozen=True)
class VoteConfig:
    """Criteria and schedule of pruning by votes."""

    quantile: float = 0.2
    """Quantile of all Gaussians, 0 to 1 (paper: 0.2). A vote goes against a Gaussian whose opacity
    and largest scale are both below it; more than 0.6 of an interval's votes against it remove it.
    0 never prunes."""
    interval: float = 1 / 30
    """Time between two prunings, 0 to 1 (paper: 1,000 of 30,000)."""
    until: float = 0.8
    """Time of the last pruning, 0 to 1 (paper: 24,000 of 30,000)."""
    votes_per_interval: int = 12
    """Evenly spaced steps per interval that hold a vote, at least 1. A vote evaluates opacities of
    all Gaussians, visible or not. (The release votes in every step.)"""

    def __post_init__(self) -> None:
        fractions = dict.fromkeys(("quantile", "interval", "until"), FRACTION)
        check(self, votes_per_interval=COUNT, **fractions)


def vote(
    opacities: Float[Tensor, "n"], scales: Float[Tensor, "n 3"], quantile: float
) -> Bool[Tensor, "n"]:
    """Return the Gaussians whose opacity and largest scale both lie below the `quantile` of all.

    `opacities` are those seen from one camera.
    """
    return below_quantile(opacities, quantile) & below_quantile(scales.amax(1), quantile)


def below_quantile(values: Float[Tensor, "n"], quantile: float) -> Bool[Tensor, "n"]:
    """Return which values are smaller than the quantile of all, which interpolates linearly.

    The comparison is strict: none of equal values is smaller.
    """
    # torch.quantile raises an error above 16 million values, and sorts them all
    if not len(values):
        return torch.zeros_like(values, dtype=torch.bool)
    place = quantile * (len(values) - 1)
    low, high = int(place), min(int(place) + 1, len(values) - 1)
    if values.is_cuda:  # there a sort takes a tenth of the time of kthvalue
        ordered = values.sort().values
        first, second = ordered[low], ordered[high]
    else:
        first, second = (values.kthvalue(rank + 1).values for rank in (low, high))
    return values < first + (second - first) * (place - low)


class VoteCounter:
    """The votes of one interval, and the schedule of votes and prunings in a run.

    Attributes:
        against: votes against each Gaussian in this interval, `[n]`.
        held: votes in this interval.
    """

    def __init__(self, config: VoteConfig, times: Times, count: int, device: torch.device) -> None:
        """Begin the first interval of a run with these `times`, with `count` Gaussians."""
        self.config, self.times = config, times
        self.against = torch.zeros(count, dtype=torch.int32, device=device)
        self.held = 0

    def votes_at(self, step: int) -> bool:
        """Return whether step `step`, counted from 1, holds a vote."""
        spacing = max(self.config.interval, TIME_MIN) / self.config.votes_per_interval
        return self.config.quantile > 0 and self._counts(step) and self.times.passes(step, spacing)

    def prunes_after(self, step: int) -> bool:
        """Return whether an interval ends with step `step`, counted from 1."""
        return self._counts(step) and self.times.passes(step, max(self.config.interval, TIME_MIN))

    def _counts(self, step: int) -> bool:
        return self.times.of(step - 1) < self.config.until - TIME_MIN

    def add(self, candidates: Bool[Tensor, "n"]) -> None:
        """Count one vote against `candidates`."""
        self.against += candidates
        self.held += 1

    def kept(self) -> Bool[Tensor, "n"]:
        """Return the Gaussians with at most `VOTE_SHARE` of the votes against them."""
        return self.against <= VOTE_SHARE * self.held

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
