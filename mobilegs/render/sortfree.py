"""Order-independent blending and its weights w: the reference.

"Paper" is Mobile-GS (Du et al. 2026). Its equations here: the weight w, Eq. 3, in
`Weighting.weights`; the image from alpha, w and T, Eq. 2, and the image of Eq. 1, in
`render_sortfree`.

The same formulas elsewhere: `weight_of` in csrc/core.h for the CPU and CUDA kernels and in the
viewer's project.wgsl and project.glsl for the GPU renderers; the image in `sortfree_resolve` of
csrc/pairs.h and `resolve_sortfree` of resolve.wgsl and resolve.glsl.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.depth_pass import PASS_LEVEL, depth_moments, visibility
from mobilegs.render.levels import at_level, choose_levels, enlarge, level_sizes
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import (
    ALPHA_MIN,
    CLASSIC,
    Footprint,
    pair_alphas,
    project,
)
from mobilegs.render.rendered import Rendered
from mobilegs.validation import check_choice

# of kernels, shaders and files, which know them by their index
WeightingName = Literal["mobile_gs", "no_depth", "no_scale", "sort_free_gs", "depth_pass"]
WEIGHTINGS: tuple[WeightingName, ...] = get_args(WeightingName)
WEIGHT_MIN = 1e-12  # a pixel whose weights sum to less shows the background


@dataclass(frozen=True)
class Weighting:
    """The weights w of order-independent blending; part of a scene and of its file.

    Raises InputError for an unknown name or a value outside its range.
    """

    name: WeightingName = "mobile_gs"
    """`mobile_gs` is the paper's Eq. 3; `no_depth` and `no_scale` drop its second or third
    term (the paper's Table 5). `sort_free_gs` is the linear form of SortFreeGS,
    `max(0, 1 - d / sigma) v`, with phi as the learned v. `depth_pass` is `mobile_gs` times a
    factor that differs from pixel to pixel, by a depth pass of a quarter of the image's size
    (`render/depth_pass.py`). Training uses `depth_pass`, and `mobile_gs` for the paper's presets;
    the others open files of before and serve bench/paper."""
    exponent_max: float = 4.0
    """Upper limit of `s_max / d` in the exponential, in (0, 80] (see `WeightingConfig`)."""
    sigma: float = 10.0
    """Depth in world units at which the weight of `sort_free_gs` reaches 0. Infinite: w = phi. With
    `depth_pass`, a typical depth: renderers with float16 are most exact near it."""
    background_weight: float = 0.0
    """Weight of the background in the mean of `sort_free_gs`; 0 for all others."""
    alpha_min: float = ALPHA_MIN
    """Alpha at which an ellipse ends, in [0.0001, 0.1]; a higher one renders faster."""
    detached: bool = False
    """Cut the gradients of depth and scale through w, as in the paper's release. It changes no
    image, and files do not store it."""

    def __post_init__(self) -> None:
        check_choice("weighting", self.name, WeightingName)
        if not 0 < self.exponent_max <= 80:
            raise InputError(f"exponent_max must lie in (0, 80], not {self.exponent_max}")
        if not 1e-4 <= self.alpha_min <= 0.1:
            raise InputError(f"alpha_min must lie in [0.0001, 0.1], not {self.alpha_min}")

    @property
    def index(self) -> int:
        """The number by which kernels, shaders and files know the formula."""
        return WEIGHTINGS.index(self.name)

    def weights(
        self, depths: Float[Tensor, "n"], s_max: Float[Tensor, "n"], phi: Float[Tensor, "n"]
    ) -> Float[Tensor, "n"]:
        """Return the weights w of Gaussians at depth d > 0, of largest scale s_max, with phi >= 0.

        d is the camera-space z, s_max the largest of the three scales, both in world units.

        Paper Eq. 3: `w = phi^2 + phi / d^2 + exp(s_max / d)`, the exponent clamped to
        `exponent_max`. `sort_free_gs` (SortFreeGS, Hou et al. 2024): `w = max(0, 1 - d / sigma) v`.
        """
        if self.detached:
            depths, s_max = depths.detach(), s_max.detach()
        if self.name == "sort_free_gs":
            return (1 - depths / self.sigma).clamp_min(0) * phi
        w = phi * phi
        if self.name != "no_depth":
            w = w + phi / (depths * depths)
        if self.name != "no_scale":
            w = w + torch.exp((s_max / depths).clamp_max(self.exponent_max))
        return w


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
    footprint: Footprint = CLASSIC,
    level_sigma: float = 0.0,
) -> Rendered:
    """Blend in any order: `C = (1 - T) sum(c a w) / sum(a w) + T bg`, `T = prod(1 - a)` (Eq. 2).

    A pixel that no Gaussian touches shows the background. `depth` is the same mean of z instead of
    c. Gradients flow to depth and largest scale through w, unless it is detached. Shapes and units
    as in `mobilegs.render_sortfree`.

    With `sort_free_gs` the image is Eq. 1: `C = (bg w_bg + sum(c a w)) / (w_bg + sum(a w))`. With
    `depth_pass`, w is multiplied at each pixel by the `visibility` of the Gaussian's depth there,
    through which no gradient flows. A Gaussian with a lobe that is not finite is left out.

    With a `level_sigma` above 0, the sums of large Gaussians are added up in smaller targets
    (`render/levels.py`).
    """
    valid = lobes.flatten(1).isfinite().all(1) & means.isfinite().all(1)
    valid &= (means.detach() != camera.position).any(1)  # without a viewing direction
    offsets = torch.where(valid[:, None], means - camera.position, 1.0)
    directions = torch.nn.functional.normalize(offsets, dim=1)
    opacities, phi = evaluate_lobes(torch.where(valid[:, None, None], lobes, 0.0), directions)
    shapes = (means, quats, scales, opacities, sh)
    alpha_min = weighting.alpha_min
    projected = project(*shapes, camera=camera, alpha_min=alpha_min, footprint=footprint)
    projected = projected._replace(visible=projected.visible & valid)
    s_max = scales.max(dim=1).values if len(scales) else scales.sum(1)
    s_max = torch.where(projected.visible, s_max, 0.0)
    weights = torch.where(projected.visible, weighting.weights(projected.depths, s_max, phi), 0.0)
    sizes = level_sizes(camera.height, camera.width)
    levels = choose_levels(projected, weights, level_sigma)
    moments = None
    if weighting.name == "depth_pass":
        size, soft_edge = sizes[PASS_LEVEL], footprint.soft_edge
        moments = depth_moments(projected, opacities, size, alpha_min, soft_edge=soft_edge)
    sums, radii = None, projected.radii.amax(1) * projected.visible
    for level in reversed(range(len(sizes) if level_sigma else 1)):
        size, chosen = sizes[level], levels == level
        part, faded = at_level(projected, opacities, level, chosen, size=size, alpha_min=alpha_min)
        alphas = pair_alphas(part, faded, size, alpha_min, soft_edge=footprint.soft_edge)
        transmittance = torch.exp(torch.log1p(-alphas).sum(1, keepdim=True))
        aw = alphas * weights
        if moments is not None:
            aw = aw * visibility(moments, part.depths, level, size)
        color, depth = aw @ part.colors, aw @ part.depths[:, None]
        own = torch.cat([color, depth, aw.sum(1, keepdim=True), transmittance], dim=1)
        own = own.reshape(*size, -1)
        if sums is not None:
            above = enlarge(sums, size, to_image=level == 0)
            own = torch.cat([own[..., :-1] + above[..., :-1], own[..., -1:] * above[..., -1:]], 2)
        sums = own
        radii = torch.where(chosen, 2**level * part.radii.amax(1) * part.visible, radii)
    assert sums is not None
    color, depth, total, transmittance = sums.flatten(0, 1).split([3, 1, 1, 1], dim=1)
    touched = total > WEIGHT_MIN
    safe = torch.where(touched, total, 1.0)
    if weighting.name == "sort_free_gs":
        behind = weighting.background_weight
        image = (behind * background + color) / torch.where(touched, total + behind, 1.0)
    else:
        image = (1 - transmittance) * color / safe + transmittance * background
    image = torch.where(touched, image, background.expand_as(image))
    depth = torch.where(touched, (1 - transmittance) * depth / safe, 0.0)
    size = (camera.height, camera.width)
    return Rendered(
        image.reshape(*size, 3), (1 - transmittance).reshape(size), depth.reshape(size), radii
    )
