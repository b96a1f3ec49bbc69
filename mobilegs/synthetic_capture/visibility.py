"""Whether cameras look at a scene at all."""

from collections.abc import Sequence

import torch

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.scene import Scene

SIDE = 64  # pixels, the longer one
LOOKS = 64  # cameras that are asked, at most
COVERED = 0.01  # of a picture, at least: else it shows nothing of the scene


@torch.inference_mode()
def refuse_blind(scene: Scene, cameras: Sequence[Camera], whose: str, instead: str) -> None:
    """Raise InputError if most of the cameras see nothing of the scene.

    `whose` says which cameras these are, `instead` what to give in their place.
    """
    some = cameras[:: max(1, -(-len(cameras) // LOOKS))]  # there may be none
    blind = 0
    for camera in some:
        factor = min(1.0, SIDE / max(camera.width, camera.height))
        small = camera.resized(*(max(1, round(factor * s)) for s in (camera.width, camera.height)))
        alpha = scene.render(small.to(scene.gaussians.means.device)).alpha
        blind += float(alpha.mean()) < COVERED
    if blind > len(some) / 2:
        raise InputError(f"{blind} of {len(some)} {whose} show nothing of this scene: {instead}")
