"""What a frame costs: how often its pixels are painted, as something that training can lower."""

import math
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.project import rotation_matrices


def overdraw(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    log_scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    alpha_min: float,
) -> Float[Tensor, ""]:
    """Ellipses that lie over a pixel, in the mean: what a device has to paint, which sorts nothing.

    An ellipse ends where alpha falls to `alpha_min`. Its area is taken from the shadow that an
    ellipsoid with semi-axes s throws along the unit direction u, given in its own axes:
    `pi sqrt((s2 s3 u1)^2 + (s1 s3 u2)^2 + (s1 s2 u3)^2)` (the projected area of an ellipsoid,
    Vickers 1996), without the blur and without what perspective adds beside the picture's
    centre. No Gaussian counts more than the picture, and none behind the near plane counts.
    Gaussians are those that can touch the picture. Gradients reach `log_scales` alone: opacities
    that pay for their area fade, which costs the picture far more.
    """
    others = (t.detach() for t in (means, quats, opacities))
    return _Overdraw.apply(log_scales, *others, camera, alpha_min)  # pyright: ignore


class _Overdraw(torch.autograd.Function):
    """A shadow A = sqrt(f1^2 + f2^2 + f3^2), with s_k in two of the f, has A - f_k^2 / A as its
    derivative by the logarithm of s_k."""

    @staticmethod
    def forward(  # pyright: ignore[reportIncompatibleMethodOverride]
        ctx: Any,
        log_scales: Tensor,
        means: Tensor,
        quats: Tensor,
        opacities: Tensor,
        camera: Camera,
        alpha_min: float,
    ) -> Tensor:
        offsets = means - camera.position
        distances = offsets.norm(dim=1).clamp_min(camera.near)
        u = (offsets[:, None, :] @ rotation_matrices(quats))[:, 0] / distances[:, None]  # [n, 3]
        squares = (u * torch.exp(log_scales.sum(1, keepdim=True) - log_scales)).square()
        total = squares.sum(1)
        reach = 2 * torch.log((opacities / alpha_min).clamp_min(1))  # squared radius
        pixels = camera.width * camera.height
        scale = math.pi * float(camera.K[0, 0] * camera.K[1, 1]) / pixels
        shares = scale * reach * total.sqrt() / distances.square()  # of the picture
        shares = torch.where(offsets @ camera.viewmat[2, :3] > camera.near, shares, 0.0)
        least = torch.finfo(total.dtype).tiny
        slopes = (shares / total.clamp_min(least))[:, None] * (total[:, None] - squares)
        ctx.save_for_backward(torch.where((shares < 1)[:, None], slopes, 0.0))
        return shares.clamp_max(1).sum()

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None, None, None, None, None]:  # pyright: ignore
        (slopes,) = ctx.saved_tensors
        return grad * slopes, None, None, None, None, None
