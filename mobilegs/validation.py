"""Checks of the numbers and choices in configurations."""

import math
from dataclasses import dataclass
from typing import Any, get_args

from mobilegs.errors import InputError


@dataclass(frozen=True)
class Range:
    """Finite numbers from `low` to `high`; `above` excludes `low`, and `below` excludes `high`."""

    low: float | int = 0.0
    high: float | int = math.inf
    above: bool = False
    below: bool = False

    def __contains__(self, value: float | int) -> bool:
        first = value > self.low if self.above else value >= self.low
        last = value < self.high if self.below else value <= self.high
        return math.isfinite(value) and first and last

    def __str__(self) -> str:
        first = f"above {self.low:g}" if self.above else f"at least {self.low:g}"
        if self.high == math.inf:
            return first
        return f"{first} and {'below' if self.below else 'at most'} {self.high:g}"


COUNT = Range(1)
NOT_NEGATIVE = Range()
POSITIVE = Range(above=True)
FRACTION = Range(high=1)
SHARE = Range(high=1, above=True)  # a fraction that must not be 0
DEGREE = Range(high=3)


def check(config: Any, **ranges: Range) -> None:
    """Raise InputError unless the named fields of a dataclass are within their `ranges`."""
    for name, allowed in ranges.items():
        value = getattr(config, name)
        if value not in allowed:
            raise InputError(f"{name} must be {allowed}, not {value}")


def check_choice(what: str, value: str, choices: Any) -> None:
    """Raise InputError unless `value` is one of `choices`, a `Literal`; `what` names it."""
    known = get_args(choices)
    if value not in known:
        raise InputError(f"unknown {what} '{value}': use {' or '.join(known)}")
