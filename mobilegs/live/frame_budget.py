"""The share of training time that live frames may take, and their resolution."""

import math
import time
from collections.abc import Callable
from typing import Literal

TIME_SHARE = 0.1  # of the training time goes into frames in the long run
BUDGET_MAX = 1.0  # seconds of rendering that can be saved up
RESERVE = 0.5  # seconds of the budget kept for camera movements
FRAME_SECONDS = {"moving": 0.05, "resting": 0.25}  # that a frame may take
PIXELS_MIN = {"moving": 160 * 120, "resting": 320 * 240}
PIXELS_MAX = 1920 * 1200
FIRST_SPEED = 1e6  # pixels per second that the first frame is assumed to reach

Detail = Literal["moving", "resting", "paused"]


class FrameBudget:
    """A budget of rendering seconds that grows while the training runs.

    Urgent frames, for a camera that moved or a changed display mode, may use the whole budget.
    Frames that only follow the training leave `RESERVE`.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Start with a full budget. `clock` returns seconds."""
        self._clock = clock
        self._budget = BUDGET_MAX
        self._updated_at = clock()
        self._speeds: dict[Detail, float] = {"moving": FIRST_SPEED}  # pixels per second

    def allows(self, *, urgent: bool) -> bool:
        """Return True if a frame may be rendered now."""
        now = self._clock()
        self._budget = min(BUDGET_MAX, self._budget + TIME_SHARE * (now - self._updated_at))
        self._updated_at = now
        return self._budget > (0 if urgent else RESERVE)

    def spend(self, seconds: float) -> None:
        """Subtract the time that a frame took from the training."""
        self._budget -= seconds

    def record_speed(self, detail: Detail, pixels: int, seconds: float) -> None:
        """Record the time of a frame, from which the next resolution follows."""
        self._speeds[detail] = pixels / max(seconds, 1e-6)

    def size(self, detail: Detail, width: int, height: int) -> tuple[int, int]:
        """Return width and height of a frame for a canvas of `width` x `height` pixels.

        The frame has the aspect ratio of the canvas and at most its size.
        """
        pixels = PIXELS_MAX
        if detail != "paused":
            speed = self._speeds.get(detail, self._speeds["moving"])
            pixels = min(PIXELS_MAX, max(PIXELS_MIN[detail], FRAME_SECONDS[detail] * speed))
        scale = min(1.0, math.sqrt(pixels / (width * height)))
        return max(1, round(scale * width)), max(1, round(scale * height))
