"""Checks that cameras see a scene."""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.scene import Scene

SIDE = 64  # pixels, longer side of a test render
CAMERAS_MAX = 64  # number of cameras that are tested
COVERED_MIN = 0.01  # mean alpha below which a render shows nothing of the scene
POINTS = 10_000  # Gaussians from which distances are measured
IN_VIEW_MIN = 0.005  # share of a scene's Gaussians that are in view of a camera that fits
FAR = 30.0  # greatest distance of such a camera from the middle, in sizes of the scene


@torch.inference_mode()
def validate_visibility(
    scene: Scene, cameras: Sequence[Camera], described: str, remedy: str
) -> None:
    """Raise InputError if more than half of the cameras see nothing of the scene.

    The message calls the cameras `described` and ends with `remedy`. At most `CAMERAS_MAX`
    cameras, spread evenly, are rendered; an empty sequence passes.
    """
    some = cameras[:: max(1, -(-len(cameras) // CAMERAS_MAX))]
    blind = 0
    for camera in some:
        factor = min(1.0, SIDE / max(camera.width, camera.height))
        small = camera.scaled(factor).to(scene.gaussians.means.device)
        alpha = scene.render(small).alpha
        blind += float(alpha.mean()) < COVERED_MIN
    if blind > len(some) / 2:
        raise InputError(f"{blind} of {len(some)} {described} show nothing of this scene: {remedy}")


def depths_in_view(points: Float[Tensor, "n 3"], camera: Camera) -> Float[Tensor, "m"]:
    """Return the depths of the points that a camera sees, occluded ones included."""
    inside = points @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]
    inside = inside[inside[:, 2] > camera.near]
    x, y, _ = (inside @ camera.K.T / inside[:, 2:]).unbind(1)
    return inside[(x > 0) & (x < camera.width) & (y > 0) & (y < camera.height), 2]


def fit_scene(cameras: Sequence[Camera], means: Float[Tensor, "n 3"]) -> bool:
    """Return True if at least half of the cameras are near the scene and have a part of it in view.

    At most `CAMERAS_MAX` cameras and about `POINTS` Gaussians are tested, without rendering.
    """
    points = means[:: max(1, len(means) // POINTS)]
    middle = points.median(0).values
    size = (points - middle).abs().amax(1).quantile(0.9)
    some = cameras[:: max(1, -(-len(cameras) // CAMERAS_MAX))]
    good = 0
    for camera in some:
        near = bool((camera.position - middle).norm() <= FAR * size)
        good += near and len(depths_in_view(points, camera)) >= IN_VIEW_MIN * len(points)
    return 2 * good >= len(some)
