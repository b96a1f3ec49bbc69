"""The depth pass: how visible a Gaussian is at a pixel, without an order of depth.

A picture of a quarter of the image's size holds, at each of its pixels, the sum of the alphas of
all Gaussians and their first two moments in the logarithm of depth. The Gaussians of a pixel are
then thought of as one fog, even between `mu - 1.25 s` and `mu + 1.25 s`: what lies before it is
seen, what lies behind it is hidden by all of it, and between them the light falls exponentially.
All three are sums, so that the Gaussians may come in any order. The idea is that of moment-based
order-independent transparency (Muenstermann et al. 2018). This module is the reference. The same
formulas: `depth_splat` and `visibility` in csrc/depth_pass.h, splat.wgsl and splat.glsl.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.levels import at_level
from mobilegs.render.project import Projected, pair_alphas

PASS_LEVEL = 2  # the picture has the size of this level's target (`render/levels.py`)
PASS_BLUR = 2.25  # px^2 of the image, added to both variances: its pixels are 4 px wide
DEPTH_FLOOR = 0.02  # added to the standard deviation of the logarithm of depth
DEPTH_SLOPE = 0.4  # of the share of the fog that lies before a depth, per standard deviation
ALPHAS_MIN = 1e-6  # a sum of alphas below hides nothing
ALPHAS_MAX = 16.0  # a sum of alphas above counts as this: weights must stay in float16's range


@torch.no_grad()
def typical_depth(means: Float[Tensor, "n 3"], cameras: Sequence[Camera], near: float) -> float:
    """Return the median over cameras of the geometric mean of depths, world units; 1 without any.

    Viewers whose picture is float16 add up the logarithms of depths relative to it, which is the
    `sigma` of this weighting.
    """
    found = []
    for camera in cameras:
        row = camera.viewmat[2].to(means)
        depths = means @ row[:3] + row[3]
        ahead = depths[depths > near]
        if len(ahead):
            found.append(ahead.log().mean())
    return float(torch.stack(found).median().exp()) if found else 1.0


@torch.no_grad()
def depth_moments(
    projected: Projected,
    opacities: Float[Tensor, "n"],
    size: tuple[int, int],
    alpha_min: float,
    *,
    soft_edge: bool,
) -> Float[Tensor, "h w 3"]:
    """Return `sum(a)`, `sum(a u)` and `sum(a u^2)`, with u = ln z, in the target of `PASS_LEVEL`.

    `size` is the target's. Each Gaussian is blurred, and its opacity is multiplied by
    `sqrt(det S / det S')`, so that its sum over the picture stays.
    """
    chosen = torch.ones_like(projected.visible)
    coarse, faded = at_level(
        projected, opacities, PASS_LEVEL, chosen, size=size, alpha_min=alpha_min, spread=-PASS_BLUR
    )
    alphas = pair_alphas(coarse, faded, size, alpha_min, soft_edge=soft_edge)
    u = torch.log(torch.where(projected.visible, projected.depths, 1.0))
    return (alphas @ torch.stack([torch.ones_like(u), u, u * u], dim=1)).reshape(*size, 3)


@torch.no_grad()
def visibility(
    moments: Float[Tensor, "h w 3"],
    depths: Float[Tensor, "n"],
    level: int,
    size: tuple[int, int],
) -> Float[Tensor, "pixels n"]:
    """Return the factor of weights at depth z, in [exp(-8), exp(8)], at each pixel of a target.

    `exp(-min(b, 16) clamp(0.4 (ln z - mu) / (s + 0.02), -1/2, 1/2))`, with b the sum of alphas at
    the pixel, mu the mean and s the standard deviation of the logarithm of their depths. It is the
    share of light that the fog lets through, over the share that half of it does: a factor that all
    Gaussians of a pixel have cancels in the image, but levels add up sums of different pixels.
    Moments are interpolated bilinearly. `size` is that of the target of `level`. No gradient.
    """
    ratio, border = 2.0 ** (level - PASS_LEVEL), 1 if level else 0
    # centre of a pixel of the target, in pixels of the moments, whose centres are integers
    places = [
        (torch.arange(count, dtype=moments.dtype, device=moments.device) + 0.5 - border) * ratio
        + 0.5
        for count in size
    ]
    for axis, at in enumerate(places):
        at = at.clamp(0, moments.shape[axis] - 1)
        first = at.floor().long().clamp_max(moments.shape[axis] - 2)
        part = (at - first).reshape(-1, *[1] * (2 - axis))
        before, after = (moments.index_select(axis, first + k) for k in (0, 1))
        moments = before + part * (after - before)
    total, first, second = moments.reshape(-1, 3, 1).unbind(1)
    safe = total.clamp_min(ALPHAS_MIN)
    mean = first / safe
    deviation = (second / safe - mean * mean).clamp_min(0).sqrt()
    u = torch.log(torch.where(depths > 0, depths, 1.0))
    hidden = (DEPTH_SLOPE * (u - mean) / (deviation + DEPTH_FLOOR)).clamp(-0.5, 0.5)
    return torch.exp(-total.clamp_max(ALPHAS_MAX) * hidden)
