"""Where a viewer stands and looks, and the ways to move: orbit, look around, pan, dolly, fly.

What `web/viewer/pose.js`, `input.js` and `pick.js` do once more, so that a scene moves alike in a
window and in a browser; a test compares poses number by number. Axes are the world's as the scene
was captured, lengths its units, angles radians; the pointer moves over logical pixels, as on a
page. Events are rendercanvas'.
"""

import math
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.camera import Camera

POLE = 0.02  # radians that a view keeps from straight up or down
TRUST = 0.02  # in the mean upward direction of cameras
NEAREST = 1e-3  # of the starting distance, that a dolly may come close to its target
NEARBY = 12.0  # pixels around the pointer
FIELD = 50.0  # degrees of the picture's sides, where no training camera gives a field of view
TURN = 0.006  # radians a pixel
WHEEL = 0.0012  # of the distance, a unit of the wheel
SPEED = 0.9  # distances to the target in a second, when flying with keys
TURN_SPEED = 1.5  # radians in a second, when turning with keys
TAP = 0.03  # seconds that the shortest press counts
DOUBLE = (0.35, 20.0)  # seconds and pixels within which two clicks are one
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
COMMAND = {"Control", "Meta", "Alt"}  # with these, keys mean something else

Vector = Float[np.ndarray, "3"]


class Pose:
    """An eye at a place, turned to a target, with a sky that stays where it is.

    Attributes:
        eye: where the viewer stands.
        target: what an orbit goes around.
        up: direction of the sky, length 1.
        reach: distance of the target at the start, which sets the speed of flying.
    """

    def __init__(self, eye: Vector, target: Vector, up: Vector) -> None:
        self.eye = np.asarray(eye, np.float64)
        self.target = np.asarray(target, np.float64)
        self.up = unit(np.asarray(up, np.float64))
        self.reach = float(np.linalg.norm(self.target - self.eye)) or 1.0

    @classmethod
    def from_views(cls, views: Sequence[Camera], index: int = 0) -> "Pose":
        """The pose of training camera `index`, whose target is where all of them look."""
        mats = np.stack([view.viewmat.double().cpu().numpy() for view in views])
        axes, eyes = mats[:, :3, :3], _eyes(mats)  # rows of axes: right, down, forward
        eye, forward = eyes[index], axes[index, 2]
        distance = float((_meeting(eyes, axes[:, 2]) - eye) @ forward)
        # cameras that look outwards or in parallel meet nowhere: then a step ahead
        spread = float(np.linalg.norm(eyes - eye, axis=1).max()) or 1.0
        if not distance > NEAREST * spread:
            distance = spread
        return cls(eye, eye + forward * distance, _sky(axes))

    @classmethod
    def around(cls, centers: Float[np.ndarray, "n 3"]) -> "Pose":
        """For a scene that does not say how it was taken: from aside, at most of it."""
        places = [int(share * (len(centers) - 1)) for share in (0.15, 0.5, 0.85)]
        low, target, high = np.zeros((3, 3))
        if len(centers):
            low, target, high = np.partition(centers, places, axis=0)[places].astype(np.float64)
        size = float((high - low).max()) or 1.0
        return cls(target + 1.5 * size * np.array([0, -0.3, -1]), target, np.array([0.0, -1, 0]))

    @property
    def forward(self) -> Vector:
        """The direction of looking."""
        return unit(self.target - self.eye)

    @property
    def right(self) -> Vector:
        """The direction to the picture's right."""
        return unit(np.cross(self.forward, self.up))

    def copy(self) -> "Pose":
        """The same pose, moved independently."""
        made = Pose(self.eye, self.target, self.up)
        made.reach = self.reach
        return made

    def orbit(self, across: float, down: float) -> None:
        """Turn around the target."""
        self.eye = self.target + self._swung(across, down)

    def look(self, across: float, down: float) -> None:
        """Turn the head."""
        self.target = self.eye - self._swung(across, down)

    def move(self, right: float, down: float, forward: float) -> None:
        """Move eye and target along the picture's axes."""
        ahead, aside = self.forward, self.right
        step = right * aside + down * np.cross(ahead, aside) + forward * ahead
        self.eye = self.eye + step
        self.target = self.target + step

    def dolly(self, factor: float) -> None:
        """Go nearer or away: `factor` of the distance to the target."""
        back = self.eye - self.target
        distance = max(float(np.linalg.norm(back)) * factor, NEAREST * self.reach)
        self.eye = self.target + unit(back) * distance

    def focus(self, place: Vector) -> None:
        """Look at another place from where the eye is."""
        if np.linalg.norm(place - self.eye) > 0:
            self.target = np.asarray(place, np.float64)

    def viewmat(self) -> Float[np.ndarray, "4 4"]:
        """World to camera, OpenCV axes."""
        forward, right = self.forward, self.right
        made = np.eye(4)
        made[:3, :3] = right, np.cross(forward, right), forward
        made[:3, 3] = -made[:3, :3] @ self.eye
        return made

    def _swung(self, across: float, down: float) -> Vector:
        """From the target to the eye, after a turn that never goes over the top."""
        back = self.eye - self.target
        polar = float(np.arccos(np.clip(unit(back) @ self.up, -1, 1)))
        swing = float(np.clip(polar - down, POLE, np.pi - POLE)) - polar
        return turned(turned(back, self.right, swing), self.up, -across)


class Input:
    """Pointer, wheel and keys: what moves the pose.

    Attributes:
        pose: what is moved.
        mode: what dragging does, `orbit` or `fly` (turns the head).
    """

    def __init__(self, pose: Pose) -> None:
        self.pose = pose
        self.mode = "orbit"
        self._keys: set[str] = set()
        self._fast = False
        self._at: tuple[float, float] | None = None  # of the pointer, while a button is down
        self._clicked = (0.0, 0.0, -math.inf)  # place and time of the click before

    @property
    def busy(self) -> bool:
        """Whether keys are held down that go on moving."""
        return bool(self._keys)

    def advance(self, seconds: float) -> None:
        """Move by the keys that are down, for a time."""
        step = SPEED * self.pose.reach * seconds * (4 if self._fast else 1)
        for key in self._keys:
            if way := FLYING.get(key):
                self.pose.move(*(step * part for part in way))
            if turn := TURNING.get(key):
                self._turn(*(TURN_SPEED * seconds * part for part in turn))

    def press(self, event: dict) -> bool:
        """A button goes down; True for the second of a double click."""
        x, y, when = event["x"], event["y"], event["time_stamp"]
        last_x, last_y, last = self._clicked
        near = math.hypot(x - last_x, y - last_y) < DOUBLE[1]
        self._at, self._clicked = (x, y), (x, y, when)
        return near and when - last < DOUBLE[0]

    def release(self, event: dict) -> None:
        """A button goes up."""
        if not event["buttons"]:
            self._at = None

    def drag(self, event: dict, height: float) -> bool:
        """The pointer moves over a window of the given height; True if that moved the pose."""
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
        """Nearer or away."""
        amount = WHEEL * event["dy"]
        if self.mode == "orbit":
            self.pose.dolly(math.exp(amount))
        else:
            self.pose.move(0.0, 0.0, -amount * self.pose.reach)

    def key(self, event: dict, down: bool) -> bool:
        """A key goes down or up; True if it is one that moves."""
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


def camera_of(pose: Pose, view: Camera | None, width: int, height: int, near: float) -> Camera:
    """A camera of `width` x `height` pixels that shows about what training camera `view` shows.

    On a screen of another shape: between all of its field and only what fills the screen.
    """
    slope = np.tan(np.radians(FIELD / 2))
    by_width, by_height = width / (2 * slope), height / (2 * slope)
    if view is not None:
        by_width = width * float(view.K[0, 0]) / view.width
        by_height = height * float(view.K[1, 1]) / view.height
    focal = float(np.sqrt(by_width * by_height))
    k = torch.tensor([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    return Camera(torch.from_numpy(pose.viewmat()).float(), k, width, height, near)


def place_under(
    centers: Float[np.ndarray, "n 3"], camera: Camera, x: float, y: float
) -> Vector | None:
    """The nearest of `centers` that lies about under a pixel; None where there is none."""
    viewmat, k = camera.viewmat.double().numpy(), camera.K.double().numpy()
    seen = centers @ viewmat[:3, :3].T + viewmat[:3, 3]
    ahead = np.flatnonzero(seen[:, 2] > camera.near)
    seen = seen[ahead]
    offsets = seen @ k.T / seen[:, 2:] - (x, y, 1)
    close = np.flatnonzero(np.square(offsets).sum(1) <= NEARBY**2)
    if not len(close):
        return None
    return centers[ahead[close[seen[close, 2].argmin()]]]


def unit(a: Vector) -> Vector:
    """Of length 1; the x axis for a vector of length 0."""
    size = np.linalg.norm(a)
    return a / size if size > 0 else np.array([1.0, 0, 0])


def turned(a: Vector, axis: Vector, angle: float) -> Vector:
    """`a` around `axis` (length 1), counterclockwise where that points at the eye: Rodrigues."""
    c, s = np.cos(angle), np.sin(angle)
    return c * a + s * np.cross(axis, a) + (axis @ a) * (1 - c) * axis


def _eyes(mats: np.ndarray) -> np.ndarray:
    return -np.einsum("nij,ni->nj", mats[:, :3, :3], mats[:, :3, 3])


def _sky(axes: np.ndarray) -> Vector:
    """The direction of the sky, from cameras' axes `[n, 3, 3]`: people hold cameras level.

    So it is square to what is right of them. Where all look the same way, that leaves a choice,
    and their mean upward direction decides.
    """
    rights = axes[:, 0]
    mean = unit(-axes[:, 1].sum(0))
    up = mean
    # power iteration: what has most of `(1 + TRUST) - mean of r r^T + TRUST mean mean^T`
    for _ in range(200):
        level = rights.T @ (rights @ up) / len(rights)
        up = unit((1 + TRUST) * up - level + TRUST * (mean @ up) * mean)
    return up


def _meeting(eyes: np.ndarray, forwards: np.ndarray) -> Vector:
    """The place nearest to all lines of sight, by least squares."""
    # sum of (I - f f^T) (x - eye) = 0; a little of I itself where all look in parallel
    matrix = (1e-3 + len(eyes)) * np.eye(3) - forwards.T @ forwards
    along = forwards * (forwards * eyes).sum(1, keepdims=True)
    return np.linalg.solve(matrix, ((1 + 1e-3 / len(eyes)) * eyes - along).sum(0))
