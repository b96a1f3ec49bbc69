"""LOD levels: an order of the Gaussians in which every prefix of levels is a coarser scene."""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.mgs.quantized_scene import LOD_LEVELS_MAX, QuantizedScene
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0

LOD_RATIO = 4  # each level multiplies the number of Gaussians by this
FIRST_LEVEL_MIN = 10_000  # Gaussians in the first level that `lod_levels_for` plans
CAMERAS_MAX = 64  # cameras that contributions are measured from


def lod_levels_for(count: int) -> int:
    """Return how many LOD levels leave 10,000 of `count` Gaussians to the first, 1 to 8."""
    levels = 1
    while levels < LOD_LEVELS_MAX and count >= FIRST_LEVEL_MIN * LOD_RATIO**levels:
        levels += 1
    return levels


def with_lod_levels(scene: QuantizedScene, count: int, cameras: list[Camera]) -> QuantizedScene:
    """Return the scene in `count` LOD levels (1 to 8), the most visible Gaussians first.

    With k levels the first holds one of 4^(k - 1) Gaussians, and each further level multiplies
    their number by four. Visibility is the sum of blending weights in the pictures of `cameras` (64
    of them at most), which are rendered on the device of the first camera. Raises InputError if
    `count` is out of range or exceeds the number of Gaussians.
    """
    if not 1 <= count <= min(LOD_LEVELS_MAX, len(scene)):
        raise InputError(
            f"{len(scene)} Gaussians cannot be split into {count} LOD levels: "
            f"1 to {LOD_LEVELS_MAX} are possible"
        )
    if count == 1:
        return replace(scene, lod_sizes=()).sorted()
    every = -(-len(cameras) // CAMERAS_MAX)
    decoded = scene.decode(cameras[0].viewmat.device)
    weights = pixel_contributions(decoded, cameras[::every])
    order = weights.argsort(descending=True, stable=True).cpu()
    ends = [max(len(scene) // LOD_RATIO ** (count - i), i) for i in range(1, count + 1)]
    sizes = [end - start for start, end in zip([0, *ends], ends, strict=False)]
    return replace(scene.select(order), lod_sizes=tuple(sizes)).sorted()


def pixel_contributions(scene: Scene, cameras: list[Camera]) -> Float[Tensor, "n"]:
    """Return the sum of each Gaussian's blending weights over all pixels of all `cameras`.

    A pixel's colour is a weighted mean of colours, so these sums are the gradient of the sum of
    all pixels with respect to the colours.
    """
    sh = scene.gaussians.sh.detach()
    # gray is not clamped; a view network takes the colours as input
    sh = torch.zeros_like(sh[:, :1]) if scene.network is None else sh.clone()
    sh.requires_grad_()
    shown = replace(scene, gaussians=replace(scene.gaussians, sh=sh))
    for camera in cameras:
        shown.render(camera).image.sum().backward()
    assert sh.grad is not None
    return sh.grad[:, 0].mean(1) / C0
