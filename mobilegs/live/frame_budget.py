"""How much of the time may go into pictures of a training, and how many pixels these have."""

import math
import time
from collections.abc import Callable
from typing import Literal

SHARE = 0.1  # of the time while training goes on, in the long run
SAVED = 1.0  # seconds of drawing that a time without pictures saves up at most
KEPT = 0.5  # seconds of these that wait for the camera to move
GOAL = {"moving": 0.05, "resting": 0.25}  # seconds that a picture should take
LEAST = {"moving": 160 * 120, "resting": 320 * 240}  # pixels
MOST = 1920 * 1200
SPEED = 1e6  # pixels a second that the first picture is expected to be drawn with

Detail = Literal["moving", "resting", "paused"]


class Pace:
    """Seconds of drawing are saved up while training goes on, and spent on pictures.

    One that somebody waits for, because the camera moves or something else is to be shown, is
    drawn as long as anything is saved; one that only follows the training, when there is
    plenty. `clock` gives seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._saved = SAVED
        self._at = clock()
        self._speeds: dict[Detail, float] = {"moving": SPEED}

    def allows(self, *, urgent: bool) -> bool:
        """Whether a picture may be drawn now."""
        now = self._clock()
        self._saved = min(SAVED, self._saved + SHARE * (now - self._at))
        self._at = now
        return self._saved > (0 if urgent else KEPT)

    def spend(self, seconds: float) -> None:
        """Take note of time that a picture took from the training."""
        self._saved -= seconds

    def learn(self, detail: Detail, pixels: int, seconds: float) -> None:
        """Take note of how long a picture took: those to come have the pixels that fit the goal."""
        self._speeds[detail] = pixels / max(seconds, 1e-6)

    def size(self, detail: Detail, width: int, height: int) -> tuple[int, int]:
        """Width and height of a picture for a canvas of this size, of the same shape."""
        pixels = MOST
        if detail != "paused":
            speed = self._speeds.get(detail, self._speeds["moving"])
            pixels = min(MOST, max(LEAST[detail], GOAL[detail] * speed))
        scale = min(1.0, math.sqrt(pixels / (width * height)))
        return max(1, round(scale * width)), max(1, round(scale * height))
