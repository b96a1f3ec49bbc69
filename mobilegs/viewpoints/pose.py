"""The pose of a viewer, and the one in which a scene is shown first.

The same as pose.js of the web viewer; a test compares the numbers. World axes and units, angles in
radians.
"""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float

from mobilegs.camera import Camera
from mobilegs.render.scene import Scene
from mobilegs.up import AXES, USUAL, Axis, Vector, turn_from_usual, unit, up_of_cameras
from mobilegs.viewpoints.framing import Start, meeting_point, parsed_framing

POLE = 0.02  # smallest angle between the view and straight up or down, radians
NEAREST = 1e-3  # smallest distance to the target, in starting distances
FIELD = 50.0  # field of view in degrees, without a training camera
AROUND = (0.42, 0.42)  # box of the pose for a scene without cameras


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
    start = parsed_framing(scene.notes).start_for(*size)
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


def turned(a: Vector, axis: Vector, angle: float) -> Vector:
    """Rotate `a` about `axis` (length 1) by the right-hand rule, with Rodrigues' formula."""
    c, s = np.cos(angle), np.sin(angle)
    return c * a + s * np.cross(axis, a) + (axis @ a) * (1 - c) * axis


def _eyes(mats: np.ndarray) -> np.ndarray:
    return -np.einsum("nij,ni->nj", mats[:, :3, :3], mats[:, :3, 3])
