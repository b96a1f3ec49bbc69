"""Overdraw: the mean number of fragments per pixel, as a differentiable loss term."""

import math
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.device import host_values
from mobilegs.render.levels import LEVELS
from mobilegs.render.project import BLUR, rotation_matrices

ROUND = 1e-6  # least squared root of an ellipse, in squared halves: rounder ones are circles
MEAN_OF_4 = 3 / math.log(4)  # of 4^u over u in [0, 1)


def overdraw(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    log_scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    alpha_min: float,
    level_sigma: float = 0.0,
    blur: float = BLUR,
) -> Float[Tensor, ""]:
    """Return the mean number of fragments per pixel, which decides the time of an unsorted frame.

    An ellipse ends where alpha falls to `alpha_min`. Its area is the projection of an ellipsoid
    with semi-axes s along the unit direction u, given in its own axes,
    `pi sqrt((s2 s3 u1)^2 + (s1 s3 u2)^2 + (s1 s2 u3)^2)` (Vickers 1996). The low-pass filter and
    the perspective distortion outside of the image centre are left out. A Gaussian counts at most
    the area of the image, and 0 behind the near plane.

    With a `level_sigma` k, a Gaussian that is drawn at level l (`render/levels.py`) counts 4^-l of
    its area, with l as a continuous number: `k^2 / variance` times the mean of 4^u over u in
    [0, 1), at most 1 and at least 1/64, where the variance is that along the ellipse's shorter axis
    in px^2, `blur` included. So an ellipse costs less the rounder it is. Weights w are left out.

    Pass the Gaussians that can touch the image. Gradients reach only `log_scales`: with a gradient
    on their area, opacities fade, which loses far more quality.
    """
    means, quats, opacities = (t.detach() for t in (means, quats, opacities))
    areas: Tensor = _Areas.apply(log_scales, means, quats, opacities, camera, alpha_min)  # pyright: ignore
    if level_sigma:
        variances = _shorter_variances(log_scales, means, quats, camera) + blur
        areas = areas * (MEAN_OF_4 * level_sigma**2 / variances).clamp(4.0 ** (1 - LEVELS), 1)
    return areas.sum()


def _shorter_variances(
    log_scales: Float[Tensor, "n 3"],
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    camera: Camera,
) -> Float[Tensor, "n"]:
    """Return the variances along the ellipses' shorter axes in px^2, without blur."""
    offsets = means - camera.position
    distances = offsets.norm(dim=1).clamp_min(camera.near)
    u = (offsets[:, None, :] @ rotation_matrices(quats))[:, 0] / distances[:, None]
    squares = torch.exp(2 * log_scales)
    product = (u.square() * torch.exp(2 * (log_scales.sum(1, keepdim=True) - log_scales))).sum(1)
    half = 0.5 * (squares * (1 - u.square())).sum(1)  # of the sum of both variances
    tiny = torch.finfo(half.dtype).tiny
    # the difference of nearly equal numbers is noise in float32
    root = (half.square() - product).clamp_min(ROUND * half.square() + tiny).sqrt()
    return product / (half + root) * _focal_squared(camera) / distances.square()


def _focal_squared(camera: Camera) -> float:
    k = host_values(camera.K)
    return k[0] * k[4]


class _Areas(torch.autograd.Function):
    """The areas A = sqrt(f1^2 + f2^2 + f3^2), in which s_k occurs in two of the f.

    So the derivative of A by log s_k is A - f_k^2 / A.
    """

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
        squared_radii = 2 * torch.log((opacities / alpha_min).clamp_min(1))  # in scales
        pixels = camera.width * camera.height
        scale = math.pi * _focal_squared(camera) / pixels
        areas = scale * squared_radii * total.sqrt() / distances.square()  # the image is 1
        areas = torch.where(offsets @ camera.viewmat[2, :3] > camera.near, areas, 0.0)
        tiny = torch.finfo(total.dtype).tiny
        gradients = (areas / total.clamp_min(tiny))[:, None] * (total[:, None] - squares)
        ctx.save_for_backward(torch.where((areas < 1)[:, None], gradients, 0.0))
        return areas.clamp_max(1)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None, None, None, None, None]:  # pyright: ignore
        (gradients,) = ctx.saved_tensors
        return grad[:, None] * gradients, None, None, None, None, None
