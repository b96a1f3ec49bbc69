"""How fine positions have to be: as fine as the training cameras can tell."""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.mgs.positions import Frame
from mobilegs.mgs.quantized_scene import EXPONENT_MAX

CAMERAS_MAX = 64  # that are asked


@torch.no_grad()
def frame_for(means: Float[Tensor, "n 3"], cameras: list[Camera], error: float) -> Frame:
    """The coarsest frame that moves Gaussians by at most `error` pixels (root mean square).

    What counts is where each is in the pictures of the `cameras` that see it. Gaussians that none
    sees do not count. The finest frame if none is fine enough.
    """
    frame, magnified = Frame.around(means), pixels_per_unit(means, cameras)
    for exponent in range(EXPONENT_MAX, -1, -1):
        frame = replace(frame, exponent=exponent)
        moved = (frame.world(frame.store(means)) - means).norm(dim=1)
        # of the three directions of an error two lie in the picture
        pixels = (2 / 3) ** 0.5 * moved * magnified
        if (pixels.square().sum() / (magnified > 0).sum().clamp_min(1)).sqrt() <= error:
            break
    return frame


def pixels_per_unit(means: Float[Tensor, "n 3"], cameras: list[Camera]) -> Float[Tensor, "n"]:
    """How many pixels a world unit covers at each mean, in the cameras that see it; 0 if none does.

    The root of the mean of the squares, over 64 cameras at most.
    """
    total, times = torch.zeros_like(means[:, 0]), torch.zeros_like(means[:, 0])
    for camera in cameras[:: -(-len(cameras) // CAMERAS_MAX)]:
        viewmat, K = camera.viewmat.to(means), camera.K.to(means)
        points = means @ viewmat[:3, :3].T + viewmat[:3, 3]
        x, y, z = points.unbind(1)
        u, v = K[0, 0] * x / z + K[0, 2], K[1, 1] * y / z + K[1, 2]
        seen = (z > camera.near) & (u > 0) & (v > 0) & (u < camera.width) & (v < camera.height)
        squares = (K[0, 0] * K[1, 1]).abs() / z.square()
        total += torch.where(seen, squares, 0)
        times += seen
    return (total / times.clamp_min(1)).sqrt()
