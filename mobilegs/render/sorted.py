"""The definition of sorted alpha blending: the teacher's picture, and the honest baseline."""

from typing import NamedTuple

import torch
from jaxtyping import Float, Int
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import Projected, pair_alphas, project
from mobilegs.render.rendered import Rendered

TRANSMITTANCE_MIN = 1e-4  # a pixel is finished once less light than this passes


class Blending(NamedTuple):
    """How the light of each pixel is shared.

    Attributes:
        order: indices of the Gaussians, front first, equal depths by index, `[n]`.
        shares: `a T` of each Gaussian in that order, `[pixels, n]`.
        light: what is left before each of them and behind all, `[pixels, n + 1]`.
    """

    order: Int[Tensor, "n"]
    shares: Float[Tensor, "pixels n"]
    light: Float[Tensor, "pixels m"]


def blend(projected: Projected, opacities: Float[Tensor, "n"], camera: Camera) -> Blending:
    """Share out the light of every pixel, front to back, until less than 1e-4 of it is left."""
    order = torch.argsort(projected.depths, stable=True)
    alphas = pair_alphas(projected, opacities, camera)[:, order]  # [pixels, n]
    ones = alphas.new_ones(alphas.shape[0], 1)
    passed = torch.cumprod(1 - alphas, dim=1)
    before = torch.cat([ones, passed], dim=1)[:, :-1]
    alphas = torch.where(before >= TRANSMITTANCE_MIN, alphas, 0.0)
    passed = torch.cumprod(1 - alphas, dim=1)
    light = torch.cat([ones, passed], dim=1)
    return Blending(order, alphas * light[:, :-1], light)


def render_sorted(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
) -> Rendered:
    """Blend front to back: `C = sum(c a T) + T_end bg`, with T the product of 1 - a before.

    Gaussians are ordered by the depth of their centres, equal depths by index; one that meets
    less than 1e-4 of the light is not drawn. `depth` is `sum(z a T)`, so that depth / alpha is
    the mean depth. Source: 3DGS (Kerbl et al. 2023), Eq. 3.
    """
    projected = project(means, quats, scales, opacities, sh, camera=camera)
    order, shares, light = blend(projected, opacities, camera)
    image = shares @ projected.colors[order] + light[:, -1:] * background
    depth = shares @ projected.depths[order]
    size = (camera.height, camera.width)
    return Rendered(
        image.reshape(*size, 3),
        (1 - light[:, -1]).reshape(size),
        depth.reshape(size),
        projected.radii.amax(1) * projected.visible,
    )
