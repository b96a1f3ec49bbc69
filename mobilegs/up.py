"""The upward direction of a scene: axes by name, the direction that cameras share, and turns.

viewer/src/viewer/up.js has the same definitions; a test compares the numbers.
"""

import re
from typing import Literal

import numpy as np
from jaxtyping import Float

Axis = Literal["-y", "z", "y", "-z", "x", "-x"]
Vector = Float[np.ndarray, "3"]

# in the order in which viewers try them: COLMAP's, that of nerfstudio and Blender, OpenGL's
AXES: dict[Axis, Vector] = {
    "-y": np.array([0.0, -1, 0]),
    "z": np.array([0.0, 0, 1]),
    "y": np.array([0.0, 1, 0]),
    "-z": np.array([0.0, 0, -1]),
    "x": np.array([1.0, 0, 0]),
    "-x": np.array([-1.0, 0, 0]),
}
USUAL = AXES["-y"]  # of scenes whose file names no direction
TRUST = 0.02  # weight of the cameras' mean upward direction
SAME = 1e-3  # distance between unit vectors that have the same name
NUMBER = r"-?\d{1,9}(\.\d{1,9})?"


def unit(a: Vector) -> Vector:
    """Return `a` at length 1; the x axis for a vector of length 0."""
    size = np.linalg.norm(a)
    return a / size if size > 0 else np.array([1.0, 0, 0])


def up_of_cameras(viewmats: Float[np.ndarray, "n 4 4"]) -> Vector:
    """Return the upward direction that world-to-camera matrices share, length 1.

    People hold cameras level, so it is perpendicular to the cameras' right axes. If these are all
    parallel, the mean upward direction of the cameras decides.
    """
    rights, downs = viewmats[:, 0, :3], viewmats[:, 1, :3]
    up = mean = unit(-downs.sum(0))
    # power iteration: largest eigenvector of `(1 + TRUST) I - mean(r r^T) + TRUST mean mean^T`
    for _ in range(200):
        across = rights.T @ (rights @ up) / len(rights)
        up = unit((1 + TRUST) * up - across + TRUST * (mean @ up) * mean)
    return up


def turn_from_usual(up: Vector) -> Float[np.ndarray, "3 3"]:
    """Return the smallest rotation that takes `USUAL` to `up`, length 1.

    For the opposite of `USUAL` it is half a turn around x.
    """
    cosine = float(USUAL @ up)
    if cosine < 1e-9 - 1:
        return np.diag([1.0, -1, -1])
    x, y, z = np.cross(USUAL, up)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + cross + cross @ cross / (1 + cosine)


def written_up(up: Vector) -> str:
    """Return a direction as files hold it: three numbers, which `parsed_up` reads."""
    return " ".join(f"{number:.6f}" for number in up)


def parsed_up(text: object) -> Vector | None:
    """Return the direction of a text `X Y Z`, length 1; None for anything else."""
    words = text.split() if isinstance(text, str) else []
    if len(words) != 3 or not all(re.fullmatch(NUMBER, word) for word in words):
        return None
    given = np.array([float(word) for word in words])
    return unit(given) if given.any() else None


def nearest_axis(up: Vector) -> Axis:
    """Return the name of the axis nearest to `up`."""
    return max(AXES, key=lambda name: float(AXES[name] @ up))


def next_axis(now: Axis | None, own: Vector) -> Axis | None:
    """Return the next axis to point up, after `now`; None is the scene's `own` direction."""
    nearest = nearest_axis(own)
    steps: list[Axis | None] = [None, *(name for name in AXES if name != nearest)]
    return steps[(steps.index(None if now == nearest else now) + 1) % len(steps)]


def up_text(up: Vector) -> str:
    """Return a direction in words: the name of an axis, or three numbers."""
    name = nearest_axis(up)
    if np.linalg.norm(AXES[name] - up) < SAME:
        return name
    return f"({', '.join(f'{number:.2f}' for number in up.round(2) + 0.0)})"
