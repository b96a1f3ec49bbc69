"""Sorted alpha blending, as in 3DGS: the reference. It renders the teacher and plain scenes.

The kernels are csrc/cpu_sorted.h and csrc/cuda_sorted.h.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import CLASSIC, Footprint, Projected, pair_alphas, project
from mobilegs.render.rendered import Rendered

TRANSMITTANCE_MIN = 1e-4  # a pixel is finished once its transmittance is below this (3DGS)


class Blending(NamedTuple):
    """Blending weights of all Gaussians at all pixels.

    Attributes:
        order: indices of the Gaussians, front first, equal depths by index, `[n]`.
        weights: `a T` of each Gaussian in that order, `[pixels, n]`.
        transmittance: T in front of each of them and behind all, `[pixels, n + 1]`.
    """

    order: Int[Tensor, "n"]
    weights: Float[Tensor, "pixels n"]
    transmittance: Float[Tensor, "pixels m"]


def blend(projected: Projected, opacities: Float[Tensor, "n"], camera: Camera) -> Blending:
    """Return the weights `a_i T_i`, `T_i = prod(1 - a_j)` over j in front (3DGS, Eq. 3).

    Gaussians behind a transmittance of less than 1e-4 have weight 0.
    """
    order = torch.argsort(projected.depths, stable=True)
    size = (camera.height, camera.width)
    alphas = pair_alphas(projected, opacities, size)[:, order]  # [pixels, n]
    ones = alphas.new_ones(alphas.shape[0], 1)
    passed = torch.cumprod(1 - alphas, dim=1)
    before = torch.cat([ones, passed], dim=1)[:, :-1]
    alphas = torch.where(before >= TRANSMITTANCE_MIN, alphas, 0.0)
    passed = torch.cumprod(1 - alphas, dim=1)
    transmittance = torch.cat([ones, passed], dim=1)
    return Blending(order, alphas * transmittance[:, :-1], transmittance)


def render_sorted(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
    footprint: Footprint = CLASSIC,
) -> Rendered:
    """Blend front to back: `C = sum(c a T) + T_end bg` (3DGS, Eq. 3).

    Gaussians are ordered by the depth of their means. `depth` is `sum(z a T)`. Shapes and units as
    in `mobilegs.render_sorted`.
    """
    shapes = (means, quats, scales, opacities, sh)
    projected = project(*shapes, camera=camera, footprint=footprint)
    order, weights, transmittance = blend(projected, opacities, camera)
    image = weights @ projected.colors[order] + transmittance[:, -1:] * background
    depth = weights @ projected.depths[order]
    size = (camera.height, camera.width)
    return Rendered(
        image.reshape(*size, 3),
        (1 - transmittance[:, -1]).reshape(size),
        depth.reshape(size),
        projected.radii.amax(1) * projected.visible,
    )
