"""Order-independent blending and its weights w: the reference.

"Paper" is Mobile-GS (Du et al. 2026). Its equations here: the weight w, Eq. 3 (and Eq. 1 of
SortFreeGS), in `Weighting.weights`; the image from alpha, w and T, Eq. 2, in `render_sortfree`.

The same formulas elsewhere: `weight_of` in csrc/core.h for the CPU and CUDA kernels and in the
viewer's project.wgsl and project.glsl for the GPU renderers; the image in `sortfree_resolve` of
csrc/pairs.h and `resolve_sortfree` of resolve.wgsl and resolve.glsl.
"""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import ALPHA_MIN, pair_alphas, project
from mobilegs.render.rendered import Rendered

WEIGHTINGS = ("mobile_gs", "no_depth", "no_scale", "sort_free_gs", "two_pass")
WEIGHT_MIN = 1e-12  # a pixel whose weights sum to less shows the background
SURFACE_ALPHA = 0.5  # `two_pass`: from this alpha on, a Gaussian is a surface at a pixel
# `two_pass`: Gaussians up to this share of the depth behind a surface still count, so that
# neighbours on it blend: 0.05 gives 0.2 dB more than 0.02 on horns, nothing on lego; 0.1 no more
SURFACE_MARGIN = 0.05


@dataclass(frozen=True)
class Weighting:
    """The weights w of order-independent blending; part of a scene and of its file.

    Raises InputError for an unknown name or a value outside its range.
    """

    name: str = "mobile_gs"
    """`mobile_gs` is the paper's Eq. 3; `no_depth` and `no_scale` drop its second or third
    term (the paper's ablations). `sort_free_gs` is Eq. 1, with phi as the learned v. `two_pass`
    finds the nearest surface of each pixel first and then blends the Gaussians that are not behind
    it, each with weight 1, like GES (Ye et al. 2025)."""
    exponent_max: float = 4.0
    """Upper limit of `s_max / d` in the exponential, in (0, 80]. It keeps float16 renderers from
    overflow, and a large faint Gaussian from outweighing the whole image when a camera passes close
    to it: 8 shows such flashes between training views, 4 costs no quality."""
    sigma: float = 10.0
    """Depth in world units at which the weight of `sort_free_gs` reaches 0."""
    background_weight: float = 0.0
    """Weight of the background in the mean of `sort_free_gs`; 0 for all others."""
    alpha_min: float = ALPHA_MIN
    """Alpha at which an ellipse ends, in [0.0001, 0.1]. The area of the ellipses takes most of a
    frame's time, so a higher limit renders faster."""
    detached: bool = False
    """Cut the gradients of depth and scale through w, as in the paper's release. It changes no
    image, and files do not store it."""

    def __post_init__(self) -> None:
        if self.name not in WEIGHTINGS:
            raise InputError(f"unknown weighting '{self.name}': use one of {', '.join(WEIGHTINGS)}")
        if not 0 < self.exponent_max <= 80:
            raise InputError(f"exponent_max must lie in (0, 80], not {self.exponent_max}")
        if not 1e-4 <= self.alpha_min <= 0.1:
            raise InputError(f"alpha_min must lie in [0.0001, 0.1], not {self.alpha_min}")

    def weights(
        self, depths: Float[Tensor, "n"], s_max: Float[Tensor, "n"], phi: Float[Tensor, "n"]
    ) -> Float[Tensor, "n"]:
        """Return the weights w of Gaussians at depth d > 0, of largest scale s_max, with phi >= 0.

        d is the camera-space z, s_max the largest of the three scales, both in world units.

        Paper Eq. 3: `w = phi^2 + phi / d^2 + exp(s_max / d)`, the exponent clamped to
        `exponent_max`. Eq. 1 (SortFreeGS, Hou et al. 2024): `w = max(0, 1 - d / sigma) v`.
        """
        if self.detached:
            depths, s_max = depths.detach(), s_max.detach()
        if self.name == "two_pass":
            return torch.ones_like(depths)
        if self.name == "sort_free_gs":
            return (1 - depths / self.sigma).clamp_min(0) * phi
        w = phi * phi
        if self.name != "no_depth":
            w = w + phi / (depths * depths)
        if self.name != "no_scale":
            w = w + torch.exp((s_max / depths).clamp_max(self.exponent_max))
        return w


@torch.no_grad()
def surface_limits(
    alphas: Float[Tensor, "pixels n"], depths: Float[Tensor, "n"]
) -> Float[Tensor, "pixels 1"]:
    """Return the depth up to which Gaussians count at each pixel, infinite without a surface.

    The surface is the nearest Gaussian with an alpha of at least 0.5 there.
    """
    opaque = torch.where(alphas >= SURFACE_ALPHA, depths, math.inf)
    nearest = torch.nn.functional.pad(opaque, (0, 1), value=math.inf).amin(1, keepdim=True)
    return (1 + SURFACE_MARGIN) * nearest


def render_sortfree(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    lobes: Float[Tensor, "n m 2"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    background: Float[Tensor, "3"],
    weighting: Weighting = Weighting(),
) -> Rendered:
    """Blend in any order: `C = (1 - T) sum(c a w) / sum(a w) + T bg`, `T = prod(1 - a)` (Eq. 2).

    A pixel that no Gaussian touches shows the background. `depth` is the same mean of z instead of
    c. Gradients flow to depth and largest scale through w, unless it is detached. Shapes and units
    as in `mobilegs.render_sortfree`.

    With `sort_free_gs` the image is Eq. 1: `C = (bg w_bg + sum(c a w)) / (w_bg + sum(a w))`. With
    `two_pass`, only Gaussians up to the pixel's surface count where it has one: there T = 0 and
    `C = sum(c a) / sum(a)`. A Gaussian with a lobe that is not finite is left out.
    """
    valid = lobes.flatten(1).isfinite().all(1) & means.isfinite().all(1)
    valid &= (means.detach() != camera.position).any(1)  # without a viewing direction
    offsets = torch.where(valid[:, None], means - camera.position, 1.0)
    directions = torch.nn.functional.normalize(offsets, dim=1)
    opacities, phi = evaluate_lobes(torch.where(valid[:, None, None], lobes, 0.0), directions)
    projected = project(
        means, quats, scales, opacities, sh, camera=camera, alpha_min=weighting.alpha_min
    )
    projected = projected._replace(visible=projected.visible & valid)
    alphas = pair_alphas(projected, opacities, camera, weighting.alpha_min)  # [pixels, n]
    log_transmittance = torch.log1p(-alphas).sum(1, keepdim=True)
    transmittance = torch.exp(log_transmittance)  # T [pixels, 1]
    if weighting.name == "two_pass":
        limits = surface_limits(alphas, projected.depths)
        alphas = torch.where(projected.depths <= limits, alphas, 0.0)
        transmittance = torch.where(limits.isinf(), transmittance, 0.0)
    s_max = scales.max(dim=1).values if len(scales) else scales.sum(1)
    s_max = torch.where(projected.visible, s_max, 0.0)
    aw = alphas * torch.where(
        projected.visible, weighting.weights(projected.depths, s_max, phi), 0.0
    )
    total = aw.sum(1, keepdim=True)
    touched = total > WEIGHT_MIN
    safe = torch.where(touched, total, 1.0)
    color, depth = aw @ projected.colors, aw @ projected.depths
    if weighting.name == "sort_free_gs":
        behind = weighting.background_weight
        image = (behind * background + color) / torch.where(touched, total + behind, 1.0)
    else:
        image = (1 - transmittance) * color / safe + transmittance * background
    image = torch.where(touched, image, background.expand_as(image))
    depth = torch.where(touched, (1 - transmittance) * depth[:, None] / safe, 0.0)
    size = (camera.height, camera.width)
    return Rendered(
        image.reshape(*size, 3),
        (1 - transmittance).reshape(size),
        depth.reshape(size),
        projected.radii.amax(1) * projected.visible,
    )
