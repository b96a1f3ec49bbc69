"""Scenes that were not trained together, composited per pixel by depth: the reference.

The weights of a sort-free scene are learned: they keep out of the sums what the scene itself hides.
Nothing teaches them another scene, so sums over two scenes show both. Here each scene is a layer:
its own image, and where along the ray its light comes from. Places along the ray are proximities,
`1 / sqrt(z)`: sums of them and of their squares fit into float16 at all depths. The same formulas
are in viewer/src/three/webgl_texts.js and webgpu_texts.js.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render import render_sortfree
from mobilegs.render.scene import Scene

# Half of a slab's extent, in standard deviations of the proximity. Outlines have two depths, which
# make the deviation large: with more, slabs overlap whose surfaces are apart.
EXTENT = 0.4
TRANSMITTANCE_MIN = 1e-4  # of a layer, so that its density is finite
THIN = 1e-4  # least half of a slab's extent, in its proximity


class Layer(NamedTuple):
    """A scene in one image.

    Attributes:
        color: premultiplied sRGB without a background, `[h, w, 3]`.
        transmittance: share of the light behind it that is left, in [0, 1], `[h, w]`.
        proximity: mean of 1 / sqrt(z) over the sums of a pixel, z in world units, `[h, w]`.
        spread: standard deviation of 1 / sqrt(z) over the same sums, `[h, w]`.
    """

    color: Float[Tensor, "h w 3"]
    transmittance: Float[Tensor, "h w"]
    proximity: Float[Tensor, "h w"]
    spread: Float[Tensor, "h w"]


def layer_of(scene: Scene, camera: Camera, unit: float = 1.0) -> Layer:
    """Render a sort-free scene as a layer.

    Args:
        scene: with lobes.
        camera: in the units and axes of the scene.
        unit: length of the scene's unit in the world.
    """
    assert scene.lobes is not None, "a layer needs a sort-free scene"
    gaussians = scene.gaussians
    drawn = replace(scene, background=torch.zeros_like(scene.background)).render(camera)
    proximity = (unit * camera.depths(gaussians.means).clamp_min(camera.near)).rsqrt()
    moments = render_sortfree(
        gaussians.means,
        gaussians.quats,
        gaussians.log_scales.exp(),
        scene.lobes,
        None,
        colors=torch.stack([proximity, proximity**2, torch.ones_like(proximity)], dim=1),
        camera=camera,
        background=torch.zeros_like(scene.background),
        weighting=scene.weighting,
        footprint=scene.footprint,
    )
    first, second, covered = moments.image.unbind(2)
    mean = first / covered.clamp_min(TRANSMITTANCE_MIN)
    square = second / covered.clamp_min(TRANSMITTANCE_MIN)
    return Layer(drawn.image, 1 - drawn.alpha, mean, (square - mean * mean).clamp_min(0).sqrt())


def composite(layers: Sequence[Layer]) -> tuple[Float[Tensor, "h w 3"], Float[Tensor, "h w"]]:
    """Return the premultiplied colours and the transmittance of layers in one image.

    A layer is a slab of constant density and colour along the ray. It lies between the mean
    proximity plus and minus `EXTENT` times the spread. Its optical depth is `-log T`. The result is
    the exact volume rendering of all slabs: where they do not overlap, it is "over" in the order of
    their depths; where they coincide, it is their mean by optical depth. It does not depend on the
    order of the layers, and it is continuous in all depths. One layer is returned as it is.
    """
    if len(layers) == 1:
        return layers[0].color, layers[0].transmittance
    near = torch.stack([one.proximity * (1 + THIN) + EXTENT * one.spread for one in layers])
    far = torch.stack([one.proximity * (1 - THIN) - EXTENT * one.spread for one in layers])
    transmittance = torch.stack([one.transmittance for one in layers])
    depths = -transmittance.clamp_min(TRANSMITTANCE_MIN).log()  # optical
    colors = torch.stack([one.color for one in layers])
    colors = colors / (1 - transmittance).clamp_min(TRANSMITTANCE_MIN)[..., None]
    extents = (near - far).clamp_min(1e-12)
    edges = torch.cat([near, far]).sort(0, descending=True).values
    image, left = torch.zeros_like(layers[0].color), torch.ones_like(layers[0].transmittance)
    for top, bottom in pairwise(edges):
        overlap = (torch.minimum(top, near) - torch.maximum(bottom, far)).clamp_min(0)
        parts = depths * overlap / extents
        total = parts.sum(0)
        color = (parts[..., None] * colors).sum(0) / total.clamp_min(1e-12)[..., None]
        image = image + (left * -torch.expm1(-total))[..., None] * color
        left = left * torch.exp(-total)
    return image, left
