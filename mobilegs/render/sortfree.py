"""The definition of order-independent blending, and the weights that take the order's place."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.lobes import seen_along
from mobilegs.render.project import ALPHA_MIN, pair_alphas, project
from mobilegs.render.rendered import Rendered

WEIGHTINGS = ("mobile_gs", "no_depth", "no_scale", "sort_free_gs", "two_pass")
WEIGHT_MIN = 1e-12  # a pixel whose weights sum to less shows the background
SURFACE_ALPHA = 0.5  # of `two_pass`: from this alpha on a Gaussian is a surface at a pixel
# how far behind a surface, as a share of its depth, Gaussians still count, so that neighbours on it
# blend: 0.05 is worth 0.2 dB more than 0.02 on horns, nothing on lego; 0.1 is not worth more
SURFACE_MARGIN = 0.05


@dataclass(frozen=True)
class Weighting:
    """How much a Gaussian counts in the order-free mean; part of the scene's file."""

    name: str = "mobile_gs"
    """`mobile_gs` is the paper's Eq. 3; `no_depth` and `no_scale` drop its second or third
    term (the paper's ablations); `sort_free_gs` is Eq. 1, with phi as the learned v. `two_pass`
    looks for surfaces first and then adds up what is not behind them, each with the weight 1,
    in the manner of GES (Ye et al. 2025)."""
    exponent_max: float = 4.0
    """Ceiling of `s_max / d` in the exponential. Half-float renderers must not overflow, and a
    large faint Gaussian that no camera was near must not outweigh the whole picture when one
    passes it by: with 8 such flashes are seen between training views, 4 costs no quality."""
    sigma: float = 10.0
    """Depth, in world units, at which a Gaussian of `sort_free_gs` stops counting."""
    background_weight: float = 0.0
    """Weight of the background in the mean of `sort_free_gs`; 0 for all others."""
    alpha_min: float = ALPHA_MIN
    """Where a Gaussian adds less to a pixel, it adds nothing: an ellipse ends there. What a frame
    costs is mostly the area of ellipses, and 1/255 is more than a scene trained so needs."""
    detached: bool = False
    """Whether depth and scale learn nothing through w, as in the paper's release, where those
    gradients are lost. It changes no picture, and files do not hold it."""

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
        """Weights w from depth (> 0), largest scale and phi (>= 0), all in world units.

        Paper Eq. 3: `w = phi^2 + phi / d^2 + exp(s_max / d)`, the exponent clamped; Eq. 1
        (SortFreeGS, Hou et al. 2024): `w = max(0, 1 - d / sigma) v`.
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
    """Depth up to which Gaussians count at each pixel, infinite where there is no surface.

    A surface is the nearest Gaussian whose alpha there is at least a half.
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
    """Blend in any order: `C = (1 - T) sum(c a w) / sum(a w) + T bg`, `T = prod(1 - a)`.

    Paper Eq. 2; a pixel that nothing touches shows the background. `lobes` hold the opacity's
    logit and phi before its ReLU as spherical harmonics of degree 0 to 3 (`lobes.py`). Gradients
    reach depth and the largest scale through w, unless it is detached. `depth` is the same mean
    with z in the place of c, so that depth / alpha is the weighted mean depth. With
    `sort_free_gs` the picture is Eq. 1: `C = (bg w_bg + sum(c a w)) / (w_bg + sum(a w))`. With
    `two_pass` only Gaussians up to the pixel's surface count, where it has one; there T = 0, and
    `C = sum(c a) / sum(a)`. A Gaussian with a lobe that is not finite is not drawn.
    """
    fine = lobes.flatten(1).isfinite().all(1) & means.isfinite().all(1)
    fine &= (means.detach() != camera.position).any(1)  # no direction leads into the eye
    offsets = torch.where(fine[:, None], means - camera.position, 1.0)
    directions = torch.nn.functional.normalize(offsets, dim=1)
    opacities, phi = seen_along(torch.where(fine[:, None, None], lobes, 0.0), directions)
    least = weighting.alpha_min
    projected = project(means, quats, scales, opacities, sh, camera=camera, alpha_min=least)
    projected = projected._replace(visible=projected.visible & fine)
    alphas = pair_alphas(projected, opacities, camera, least)  # [pixels, n]
    log_passed = torch.log1p(-alphas).sum(1, keepdim=True)
    light = torch.exp(log_passed)  # [pixels, 1], T
    if weighting.name == "two_pass":
        limits = surface_limits(alphas, projected.depths)
        alphas = torch.where(projected.depths <= limits, alphas, 0.0)
        light = torch.where(limits.isinf(), light, 0.0)
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
        image = (1 - light) * color / safe + light * background
    image = torch.where(touched, image, background.expand_as(image))
    depth = torch.where(touched, (1 - light) * depth[:, None] / safe, 0.0)
    size = (camera.height, camera.width)
    return Rendered(
        image.reshape(*size, 3),
        (1 - light).reshape(size),
        depth.reshape(size),
        projected.radii.amax(1) * projected.visible,
    )
