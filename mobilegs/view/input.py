"""Input that moves the pose of a window: orbit, look around, pan, dolly, fly.

The same as input.js and pick.js of the web viewer, so that a window and a browser move alike; a
test compares the numbers. Angles are in radians, pointer positions in logical pixels, events those
of rendercanvas.
"""

import math

import numpy as np
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.up import Vector
from mobilegs.viewpoints.pose import Pose

NEARBY = 12.0  # pixels around the pointer
TURN = 0.006  # radians per pixel
WHEEL = 0.0012  # change of the log distance per unit of the wheel
SPEED = 0.9  # starting distances per second, when flying with keys
TURN_SPEED = 1.5  # radians per second, when turning with keys
TAP = 0.03  # seconds for which the shortest key press counts
DOUBLE = (0.35, 20.0)  # seconds and pixels within which two clicks are a double click
FLYING = {
    "w": (0.0, 0.0, 1.0),
    "s": (0.0, 0.0, -1.0),
    "a": (-1.0, 0.0, 0.0),
    "d": (1.0, 0.0, 0.0),
    "q": (0.0, 1.0, 0.0),
    "e": (0.0, -1.0, 0.0),
}
TURNING = {
    "arrowleft": (-1.0, 0.0),
    "arrowright": (1.0, 0.0),
    "arrowup": (0.0, -1.0),
    "arrowdown": (0.0, 1.0),
}
COMMAND = {"Control", "Meta", "Alt"}  # with these, keys do not move


class Input:
    """Pointer, wheel and keys, which move a pose.

    Attributes:
        pose: the pose.
        mode: `orbit` to turn around the target by dragging, `fly` to turn the viewing direction.
    """

    def __init__(self, pose: Pose) -> None:
        self.pose = pose
        self.mode = "orbit"
        self._keys: set[str] = set()
        self._fast = False
        self._at: tuple[float, float] | None = None  # the pointer, while a button is down
        self._clicked = (0.0, 0.0, -math.inf)  # position and time of the last click

    @property
    def busy(self) -> bool:
        """True while keys that move the pose are held down."""
        return bool(self._keys)

    def advance(self, seconds: float) -> None:
        """Move by the keys that are held down."""
        step = SPEED * self.pose.reach * seconds * (4 if self._fast else 1)
        for key in self._keys:
            if direction := FLYING.get(key):
                self.pose.move(*(step * part for part in direction))
            if turn := TURNING.get(key):
                self._turn(*(TURN_SPEED * seconds * part for part in turn))

    def press(self, event: dict) -> bool:
        """Handle a button press. Returns True for the second click of a double click."""
        x, y, when = event["x"], event["y"], event["time_stamp"]
        last_x, last_y, last = self._clicked
        near = math.hypot(x - last_x, y - last_y) < DOUBLE[1]
        self._at, self._clicked = (x, y), (x, y, when)
        return near and when - last < DOUBLE[0]

    def release(self, event: dict) -> None:
        """Handle the release of a button."""
        if not event["buttons"]:
            self._at = None

    def drag(self, event: dict, height: float) -> bool:
        """Handle pointer motion in a window of the given height. Returns True if the pose moved."""
        if self._at is None:
            return False
        dx, dy = event["x"] - self._at[0], event["y"] - self._at[1]
        self._at = event["x"], event["y"]
        if {2, 3} & set(event["buttons"]) or {"Shift", "Control"} & set(event["modifiers"]):
            away = float(np.linalg.norm(self.pose.target - self.pose.eye)) / max(height, 1)
            self.pose.move(-dx * away, -dy * away, 0.0)
        else:
            self._turn(TURN * dx, TURN * dy)
        return True

    def wheel(self, event: dict) -> None:
        """Handle the wheel: move towards the target or away."""
        amount = WHEEL * event["dy"]
        if self.mode == "orbit":
            self.pose.dolly(math.exp(amount))
        else:
            self.pose.move(0.0, 0.0, -amount * self.pose.reach)

    def key(self, event: dict, down: bool) -> bool:
        """Handle a key press or release. Returns True if the key moves the pose."""
        key, modifiers = event["key"].lower(), set(event["modifiers"])
        self._fast = "Shift" in modifiers
        if key not in FLYING and key not in TURNING:
            return False
        if down and modifiers & COMMAND:
            return False
        if down and key not in self._keys:
            self._keys.add(key)
            self.advance(TAP)  # a key may be up again before the next frame
        if not down:
            self._keys.discard(key)
        return True

    def _turn(self, across: float, down: float) -> None:
        if self.mode == "orbit":
            self.pose.orbit(across, down)
        else:
            self.pose.look(across, down)


def point_under(
    means: Float[np.ndarray, "n 3"], camera: Camera, x: float, y: float
) -> Vector | None:
    """Return the nearest of `means` within 12 pixels of (x, y), or None."""
    viewmat, k = camera.viewmat.double().numpy(), camera.K.double().numpy()
    points = means @ viewmat[:3, :3].T + viewmat[:3, 3]
    ahead = np.flatnonzero(points[:, 2] > camera.near)
    points = points[ahead]
    offsets = points @ k.T / points[:, 2:] - (x, y, 1)
    close = np.flatnonzero(np.square(offsets).sum(1) <= NEARBY**2)
    if not len(close):
        return None
    return means[ahead[close[points[close, 2].argmin()]]]
