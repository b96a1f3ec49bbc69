"""The time of a stage by its steps, also where the number of steps changes on the way."""

from bisect import bisect_right
from typing import NamedTuple

ROUNDING = 1e-9  # of a time that should be a whole number of intervals


class _Part(NamedTuple):
    at: int
    """The first step of the part, steps done so far."""
    time: float
    """The time there."""
    steps: int
    """The number of steps in total from there on."""


class Times:
    """The time of each step of a stage, from 0 at the start to 1 after its last step.

    All schedules follow it. When the number of steps changes, the steps that are left divide the
    time that is left. So no schedule goes back: a learning rate that fell does not rise again.
    """

    def __init__(self, steps: int) -> None:
        self._parts = [_Part(0, 0.0, steps)]

    @property
    def steps(self) -> int:
        """Number of steps in total."""
        return self._parts[-1].steps

    def of(self, step: int) -> float:
        """Return the time after `step` steps, at most 1."""
        part = self._parts[max(0, bisect_right(self._parts, step, key=lambda p: p.at) - 1)]
        left = max(part.steps - part.at, 1)
        return min(1.0, part.time + (1 - part.time) * (step - part.at) / left)

    def set_steps(self, steps: int, at: int) -> None:
        """Change the number of steps in total, when `at` of them are done."""
        self._parts.append(_Part(at, self.of(at), max(steps, at + 1)))

    def passes(self, step: int, interval: float) -> bool:
        """Return whether step number `step`, from 1 on, ends an interval of this length."""
        before, after = (int(self.of(s) / interval + ROUNDING) for s in (step - 1, step))
        return after > before
