"""The viewer's pose and its input: orbit, look around, pan, dolly, fly.

The same as pose.js, input.js and pick.js of the web viewer, so that a window and a browser move
alike; a test compares the numbers. World axes and units, angles in radians, pointer positions in
logical pixels, events of rendercanvas.
"""

import math
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.framing import Start, meeting_point
from mobilegs.render.scene import Scene
from mobilegs.up import AXES, USUAL, Axis, Vector, turn_from_usual, unit, up_of_cameras

POLE = 0.02  # smallest angle between the view and straight up or down, radians
NEAREST = 1e-3  # smallest distance to the target, in starting distances
NEARBY = 12.0  # pixels around the pointer
FIELD = 50.0  # field of view in degrees, without a training camera
AROUND = (0.42, 0.42)  # box of the pose for a scene without cameras
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


class Pose:
    """Position and direction of the viewer, with a fixed upward direction.

    Attributes:
        eye: position, `[3]`.
        target: the centre of an orbit, `[3]`.
        up: upward direction of length 1, `[3]`.
        reach: starting distance of the target, which sets the speed of flying.
        box: tangents of half the width and height that must be in the picture (`framing.Start`);
            None for the field of view of a training camera.
    """

    def __init__(self, eye: Vector, target: Vector, up: Vector) -> None:
        self.eye = np.asarray(eye, np.float64)
        self.target = np.asarray(target, np.float64)
        self.up = unit(np.asarray(up, np.float64))
        self.reach = float(np.linalg.norm(self.target - self.eye)) or 1.0
        self.box: tuple[float, float] | None = None

    @classmethod
    def from_start(cls, start: Start, up: Vector) -> "Pose":
        """Return the pose of a first view that a file notes."""
        made = cls(start.eye, start.target, up)
        made.box = start.box
        return made

    @classmethod
    def from_views(
        cls, views: Sequence[Camera], index: int = 0, up: Vector | None = None
    ) -> "Pose":
        """Return the pose of training camera `index`; its target is the point that all look at.

        Without `up`, the views tell it.
        """
        mats = np.stack([view.viewmat.double().cpu().numpy() for view in views])
        axes, eyes = mats[:, :3, :3], _eyes(mats)  # rows of axes: right, down, forward
        eye, forward = eyes[index], axes[index, 2]
        distance = float((meeting_point(eyes, axes[:, 2]) - eye) @ forward)
        # cameras that look outwards or in parallel have no common target: take one ahead
        spread = float(np.linalg.norm(eyes - eye, axis=1).max()) or 1.0
        if not distance > NEAREST * spread:
            distance = spread
        return cls(eye, eye + forward * distance, up_of_cameras(mats) if up is None else up)

    @classmethod
    def around(cls, means: Float[np.ndarray, "n 3"], up: Vector = USUAL) -> "Pose":
        """Return a pose from the side for a scene without cameras, with most means in view."""
        places = [int(share * (len(means) - 1)) for share in (0.15, 0.5, 0.85)]
        low, target, high = np.zeros((3, 3))
        if len(means):
            low, target, high = np.partition(means, places, axis=0)[places].astype(np.float64)
        size = float((high - low).max()) or 1.0
        away = turn_from_usual(up) @ np.array([0, -0.3, -1])
        made = cls(target + 1.5 * size * away, target, up)
        made.box = AROUND
        return made

    @property
    def forward(self) -> Vector:
        """The viewing direction, length 1."""
        return unit(self.target - self.eye)

    @property
    def right(self) -> Vector:
        """The direction to the right of the image, length 1."""
        return unit(np.cross(self.forward, self.up))

    def copy(self) -> "Pose":
        """Return an independent copy."""
        made = Pose(self.eye, self.target, self.up)
        made.reach, made.box = self.reach, self.box
        return made

    def orbit(self, across: float, down: float) -> None:
        """Turn around the target, by angles in radians."""
        self.eye = self.target + self._swung(across, down)

    def look(self, across: float, down: float) -> None:
        """Turn the viewing direction, by angles in radians."""
        self.target = self.eye - self._swung(across, down)

    def move(self, right: float, down: float, forward: float) -> None:
        """Move eye and target along the image's axes, in world units."""
        ahead, aside = self.forward, self.right
        step = right * aside + down * np.cross(ahead, aside) + forward * ahead
        self.eye = self.eye + step
        self.target = self.target + step

    def dolly(self, factor: float) -> None:
        """Multiply the distance to the target by `factor`."""
        back = self.eye - self.target
        distance = max(float(np.linalg.norm(back)) * factor, NEAREST * self.reach)
        self.eye = self.target + unit(back) * distance

    def focus(self, place: Vector) -> None:
        """Turn to another target, from the same position."""
        if np.linalg.norm(place - self.eye) > 0:
            self.target = np.asarray(place, np.float64)

    def viewmat(self) -> Float[np.ndarray, "4 4"]:
        """Return the world-to-camera matrix, OpenCV axes, `[4, 4]`."""
        forward, right = self.forward, self.right
        made = np.eye(4)
        made[:3, :3] = right, np.cross(forward, right), forward
        made[:3, 3] = -made[:3, :3] @ self.eye
        return made

    def _swung(self, across: float, down: float) -> Vector:
        """Return the vector from target to eye after a turn, which stops before the poles."""
        back = self.eye - self.target
        polar = float(np.arccos(np.clip(unit(back) @ self.up, -1, 1)))
        swing = float(np.clip(polar - down, POLE, np.pi - POLE)) - polar
        return turned(turned(back, self.right, swing), self.up, -across)


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


def first_pose(
    scene: Scene,
    views: Sequence[Camera],
    up: Axis | None = None,
    *,
    size: tuple[int, int] = (1, 1),
) -> Pose:
    """Return the pose in which viewers of `size` (width, height) show a scene first.

    That is the one that the file notes, or the first of its training `views`, or a pose from the
    side. If `up` is given, it replaces the scene's upward direction, and a pose from the side is
    shown.
    """
    start = None if scene.framing is None else scene.framing.start_for(*size)
    if up is None and start is not None:
        return Pose.from_start(start, USUAL if scene.up is None else scene.up)
    if views and up is None:
        return Pose.from_views(views, up=scene.up)
    means = scene.gaussians.means[scene.gaussians.means.isfinite().all(1)]
    direction = scene.up if up is None else AXES[up]
    return Pose.around(means.cpu().numpy(), USUAL if direction is None else direction)


def camera_of(pose: Pose, view: Camera | None, width: int, height: int, near: float) -> Camera:
    """Return a camera of `width` x `height` pixels that shows the pose's `box`.

    Without a box it has about the field of view of `view`: if the aspect ratio differs, the focal
    length is the geometric mean of the two that match the width and the height. Without a view
    either, the field of view is 50 degrees.
    """
    slope = np.tan(np.radians(FIELD / 2))
    by_width, by_height = width / (2 * slope), height / (2 * slope)
    if view is not None:
        by_width = width * float(view.K[0, 0]) / view.width
        by_height = height * float(view.K[1, 1]) / view.height
    focal = float(np.sqrt(by_width * by_height))
    if pose.box is not None:
        focal = min(width / (2 * pose.box[0]), height / (2 * pose.box[1]))
    k = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    return Camera(torch.from_numpy(pose.viewmat()).float(), k, width, height, near)


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


def turned(a: Vector, axis: Vector, angle: float) -> Vector:
    """Rotate `a` about `axis` (length 1) by the right-hand rule, with Rodrigues' formula."""
    c, s = np.cos(angle), np.sin(angle)
    return c * a + s * np.cross(axis, a) + (axis @ a) * (1 - c) * axis


def _eyes(mats: np.ndarray) -> np.ndarray:
    return -np.einsum("nij,ni->nj", mats[:, :3, :3], mats[:, :3, 3])
