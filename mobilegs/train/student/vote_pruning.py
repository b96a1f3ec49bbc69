"""Pruning by votes (paper section 3.4): what is small and faint from most sides goes."""

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.validation import COUNT, FRACTION, check

CRITERIA = ("both", "opacity", "scale")


@dataclass(frozen=True)
class VoteConfig:
    """When a Gaussian is voted out."""

    by: str = "both"
    """What must lie below the quantile: opacity and largest scale (the paper's), or one of them."""
    quantile: float = 0.2
    """A vote goes against a Gaussian that lies below this quantile of all Gaussians in what `by`
    says (paper: 0.2). 0 never prunes."""
    share: float = 0.6
    """Removed are those with more than this share of the interval's votes against them."""
    interval: float = 1 / 30
    """Fraction of the run between two prunings (paper: 1000 of 30,000)."""
    until: float = 0.8
    """Fraction of the run at which the last pruning happens (paper: 24,000 of 30,000)."""
    votes_per_interval: int = 12
    """How many steps of an interval hold a vote, evenly spaced: a vote asks the network about
    every Gaussian, seen or not. (The release votes in every step.)"""

    def __post_init__(self) -> None:
        if self.by not in CRITERIA:
            raise InputError(f"votes look at {', '.join(CRITERIA)}, not at '{self.by}'")
        fractions = dict.fromkeys(("quantile", "share", "interval", "until"), FRACTION)
        check(self, votes_per_interval=COUNT, **fractions)


def vote(
    opacities: Float[Tensor, "n"],
    scales: Float[Tensor, "n 3"],
    *,
    quantile: float,
    by: str = "both",
) -> Bool[Tensor, "n"]:
    """Candidates: opacity and largest scale (or one of them) below the `quantile` of all.

    `opacities` are those seen from one camera. Quantiles interpolate linearly; comparison is
    strict, so equal values are never voted against.
    """
    if not len(opacities):
        return torch.zeros_like(opacities, dtype=torch.bool)
    largest = scales.amax(1)
    faint = opacities < _quantile(opacities, quantile)
    small = largest < _quantile(largest, quantile)
    return {"both": faint & small, "opacity": faint, "scale": small}[by]


def _quantile(values: Float[Tensor, "n"], q: float) -> Float[Tensor, ""]:
    # torch.quantile refuses more than 16 million values and sorts them all
    place = q * (len(values) - 1)
    low = int(place)
    first = values.kthvalue(low + 1).values
    if low + 1 >= len(values):
        return first
    return first + (values.kthvalue(low + 2).values - first) * (place - low)


class Ballot:
    """The votes of one interval, and the schedule of votes and prunings over a run."""

    def __init__(self, config: VoteConfig, steps: int, count: int, device: torch.device) -> None:
        """`steps` is the length of the whole run, `count` the number of Gaussians."""
        self.config = config
        self.interval = max(1, round(config.interval * steps))
        self.until = round(config.until * steps)
        self.spacing = max(1, self.interval // config.votes_per_interval)
        self.against = torch.zeros(count, dtype=torch.int32, device=device)
        self.held = 0

    def votes_in(self, step: int) -> bool:
        """Whether step number `step` (counted from 1) holds a vote."""
        return self.config.quantile > 0 and step <= self.until and step % self.spacing == 0

    def prunes_after(self, step: int) -> bool:
        """Whether Gaussians may be removed after step number `step` (counted from 1)."""
        return step <= self.until and step % self.interval == 0

    def cast(self, candidates: Bool[Tensor, "n"]) -> None:
        """Count one vote."""
        self.against += candidates
        self.held += 1

    def verdict(self) -> Bool[Tensor, "n"]:
        """Which Gaussians stay: no more than `share` of the votes held are against them."""
        return self.against <= self.config.share * self.held

    def clear(self, count: int) -> None:
        """Start the next interval, with `count` Gaussians."""
        self.against = torch.zeros(count, dtype=torch.int32, device=self.against.device)
        self.held = 0

    def state(self) -> dict:
        """The votes so far."""
        return {"against": self.against, "held": self.held}

    def restore(self, state: dict) -> None:
        """Take back what `state()` gave."""
        self.against = state["against"].to(self.against.device)
        self.held = state["held"]
