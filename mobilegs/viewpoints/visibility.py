"""Checks that cameras see a scene."""

from collections.abc import Sequence

import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.scene import Scene

SIDE = 64  # pixels, longer side of a test render
CAMERAS_MAX = 64  # number of cameras that are tested
COVERED_MIN = 0.01  # mean alpha below which a render shows nothing of the scene


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
