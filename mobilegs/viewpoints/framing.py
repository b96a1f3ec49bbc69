"""The first view of a scene, and the limits of a visitor's camera, as a file's notes hold them.

viewer/src/viewer/framing.js has the same definitions; a test compares the numbers.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.up import Vector, turn_from_usual

NUMBER = r"-?\d{1,12}(\.\d{1,12})?"
SECTORS = 24  # of limits
FREE = "none"  # the note `limits` of a scene without limits
BOX_SHARE = 0.75  # of a camera's picture: screens of another shape show more than the box
# degrees of azimuth and elevation by which a turn may go beyond several cameras, or beyond one
BESIDE, BESIDE_ONE, ABOVE = 25.0, 180 / SECTORS, 10.0


@dataclass(frozen=True)
class Start:
    """A first view.

    Attributes:
        eye: position, `[3]`, world units.
        target: point in the middle of the picture and centre of orbits, `[3]`.
        box: tangents of half the width and half the height of the part that must be in the
            picture, whatever the shape of the screen.
    """

    eye: Vector
    target: Vector
    box: tuple[float, float]

    @classmethod
    def from_camera(cls, camera: Camera, depth: float) -> "Start":
        """Return the view of a camera; the target is at a depth, in world units."""
        viewmat = camera.viewmat.double().cpu().numpy()
        eye = -viewmat[:3, :3].T @ viewmat[:3, 3]
        across, down = (
            BOX_SHARE * side / (2 * float(camera.K[axis, axis]))
            for axis, side in enumerate((camera.width, camera.height))
        )
        return cls(eye, eye + depth * viewmat[2, :3], (across, down))

    @property
    def text(self) -> str:
        """The note: eye, target and box as eight numbers."""
        return written([*self.eye, *self.target, *self.box])


@dataclass(frozen=True)
class Limits:
    """Limits of the camera of a visitor, around the point that training cameras look at.

    Elevations are angles of the direction from the target to the camera over the horizontal
    plane, in degrees; sector i of n has azimuths from 360 i / n to 360 (i + 1) / n degrees
    (`azimuth_of`).

    Attributes:
        pivot: that point, `[3]`, world units.
        pan: greatest distance of the target of an orbit from the pivot.
        nearest, farthest: distance of the camera to its target.
        elevations: least and greatest elevation in each of 24 sectors, `[24, 2]`; a sector whose
            least is above its greatest is closed.
    """

    pivot: Vector
    pan: float
    nearest: float
    farthest: float
    elevations: Float[np.ndarray, "24 2"]

    @classmethod
    def around(cls, eyes: Float[np.ndarray, "n 3"], pivot: Vector, up: Vector) -> "Limits":
        """Return limits that keep near the directions from `pivot` to some eyes.

        At least one of the eyes is not at the pivot.
        """
        away = (eyes - pivot)[(eyes != pivot).any(1)]
        distances = np.linalg.norm(away, axis=1)
        angles = [azimuth_of(each, up) for each in away / distances[:, None]]
        reach = BESIDE if len(eyes) > 1 else BESIDE_ONE
        elevations = np.tile([90.0, -90.0], (SECTORS, 1))
        for sector in range(SECTORS):
            middle = 360 * (sector + 0.5) / SECTORS
            near = [high for side, high in angles if abs(azimuth_between(middle, side)) <= reach]
            if near:
                elevations[sector] = max(-90, min(near) - ABOVE), min(90, max(near) + ABOVE)
        return cls(pivot, 0.0, float(distances.min()), float(distances.max()), elevations)

    @property
    def text(self) -> str:
        """The note: pivot, pan, nearest and farthest as six numbers, then the elevations."""
        ends = written([*self.pivot, self.pan, self.nearest, self.farthest])
        return f"{ends} {' '.join(f'{angle:.0f}' for angle in self.elevations.flatten())}"

    @property
    def open(self) -> list[bool]:
        """The sectors that are open."""
        return [bool(low <= high) for low, high in self.elevations]

    def ends_around(self, azimuth: float) -> tuple[float, float] | None:
        """Return the ends of the open sectors around an azimuth; None if all are open.

        The first is at most the azimuth, the second at least; beyond 0 and 360 they go on. Of an
        azimuth in a closed sector, both are the nearest azimuth that is allowed.
        """
        if all(self.open):
            return None
        nearest, _, _ = self.range_at(azimuth)
        width = 360 / SECTORS
        sector = math.floor(azimuth / width) % SECTORS
        if not self.open[sector]:
            return nearest, nearest
        low = high = math.floor(azimuth / width)
        while self.open[(low - 1) % SECTORS]:
            low -= 1
        while self.open[(high + 1) % SECTORS]:
            high += 1
        return low * width, (high + 1) * width

    def range_at(self, azimuth: float) -> tuple[float, float, float]:
        """Return the nearest azimuth that is allowed, and its least and greatest elevation.

        All are in degrees. Elevations change linearly between the middles of open sectors.
        """
        place = azimuth / 360 * SECTORS - 0.5
        first = math.floor(place)
        share = place - first
        pair = first % SECTORS, (first + 1) % SECTORS
        nearer = pair[round(share)] if share != 0.5 else pair[1]
        if not self.open[nearer]:
            steps = (
                (abs(azimuth_between(azimuth, edge)), sector, edge)
                for sector in range(SECTORS)
                if self.open[sector]
                for edge in (360 * sector / SECTORS, 360 * (sector + 1) / SECTORS)
            )
            _, sector, azimuth = min(steps)
            low, high = self.elevations[sector]
        elif self.open[pair[0]] and self.open[pair[1]]:
            low, high = (1 - share) * self.elevations[pair[0]] + share * self.elevations[pair[1]]
        else:
            low, high = self.elevations[nearer]
        return azimuth, float(low), float(high)


@dataclass(frozen=True)
class Framing:
    """First views and limits that a file's notes tell, each None if they do not.

    Attributes:
        start: the first view on screens that are at least as wide as high.
        portrait: that on screens that are higher than wide, instead of `start`.
        limits: limits of the visitor's camera.
        portrait_limits: those on screens that are higher than wide, instead of `limits`.
        free: whether the notes say that there are none.
    """

    start: Start | None = None
    portrait: Start | None = None
    limits: Limits | None = None
    portrait_limits: Limits | None = None
    free: bool = False

    def start_for(self, width: int, height: int) -> Start | None:
        """Return the first view on a screen of this shape."""
        return self.portrait if width < height and self.portrait else self.start

    def limits_for(self, width: int, height: int) -> Limits | None:
        """Return the limits on a screen of this shape."""
        return self.portrait_limits if width < height and self.portrait_limits else self.limits

    @property
    def notes(self) -> dict[str, str]:
        """The notes of a file, by name."""
        parts = {
            "start": self.start,
            "start_portrait": self.portrait,
            "limits": self.limits,
            "limits_portrait": self.portrait_limits,
        }
        notes = {name: value.text for name, value in parts.items() if value is not None}
        return notes | ({"limits": FREE} if self.free else {})


def parsed_framing(notes: Mapping[str, object]) -> Framing:
    """Return what notes tell of first views and limits. Notes of another form tell nothing."""
    return Framing(
        start=parsed_start(notes.get("start")),
        portrait=parsed_start(notes.get("start_portrait")),
        limits=_parsed_limits(notes.get("limits")),
        portrait_limits=_parsed_limits(notes.get("limits_portrait")),
        free=notes.get("limits") == FREE,
    )


def parsed_start(text: object) -> Start | None:
    """Return the first view of a note; None for anything else."""
    numbers = _numbers(text, 8)
    if numbers is None:
        return None
    eye, target, box = numbers[:3], numbers[3:6], numbers[6:]
    if np.array_equal(eye, target) or not ((box > 0) & (box < 1e3)).all():
        return None
    return Start(eye, target, (float(box[0]), float(box[1])))


def _parsed_limits(text: object) -> Limits | None:
    numbers = _numbers(text, 6 + 2 * SECTORS)
    if numbers is None:
        return None
    pan, nearest, farthest = map(float, numbers[3:6])
    elevations = numbers[6:].reshape(-1, 2)
    if not (pan >= 0 and 0 < nearest <= farthest and np.abs(elevations).max() <= 90):
        return None
    limits = Limits(numbers[:3], pan, nearest, farthest, elevations)
    return limits if any(limits.open) else None


def azimuth_of(direction: Vector, up: Vector) -> tuple[float, float]:
    """Return azimuth (0 to 360) and elevation of a direction of length 1, in degrees.

    The azimuth is 0 along the x axis, and 90 along the z axis, of a scene whose -y axis points
    up; other scenes are turned (`turn_from_usual`).
    """
    x, _, z = turn_from_usual(up).T @ direction
    elevation = math.degrees(math.asin(min(1.0, max(-1.0, float(up @ direction)))))
    return math.degrees(math.atan2(z, x)) % 360, elevation


def direction_of(azimuth: float, elevation: float, up: Vector) -> Vector:
    """Return the direction of length 1 with this azimuth and elevation, in degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    usual = np.array([math.cos(a) * math.cos(e), -math.sin(e), math.sin(a) * math.cos(e)])
    return turn_from_usual(up) @ usual


def azimuth_between(azimuth: float, other: float) -> float:
    """Return the turn from one azimuth to another, -180 to 180 degrees."""
    return (other - azimuth + 180) % 360 - 180


def meeting_point(eyes: Float[np.ndarray, "n 3"], forwards: Float[np.ndarray, "n 3"]) -> Vector:
    """Return the point nearest to all lines of sight, by least squares, `[3]`.

    `forwards` are viewing directions of length 1.
    """
    # sum of (I - f f^T) (x - eye) = 0; a small multiple of I for parallel lines
    matrix = (1e-3 + len(eyes)) * np.eye(3) - forwards.T @ forwards
    along = forwards * (forwards * eyes).sum(1, keepdims=True)
    return np.linalg.solve(matrix, ((1 + 1e-3 / len(eyes)) * eyes - along).sum(0))


def _numbers(text: object, count: int) -> np.ndarray | None:
    words = text.split() if isinstance(text, str) else []
    if len(words) != count or not all(re.fullmatch(NUMBER, word) for word in words):
        return None
    return np.array([float(word) for word in words])


def written(numbers: Sequence[float | int]) -> str:
    """Return numbers as text, with six significant digits, 12 decimals and no exponents."""
    rounded = (round(float(x), 12) for x in numbers)
    words = (np.format_float_positional(x, 6, fractional=False, trim="-") for x in rounded)
    return " ".join(words)
