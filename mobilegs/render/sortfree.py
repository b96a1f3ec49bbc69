"""Order-independent blending and its weights w: the reference.

"Paper" is Mobile-GS (Du et al. 2026). Its equations here: the weight w, Eq. 3, in
`Weighting.weights`; the weight of Eq. 1, in `exponential_weights`; the image from alpha, w and T,
Eq. 2, and the image of Eq. 1, in `render_sortfree`.

The same formulas elsewhere, except for `exponential_weights`, which only PyTorch evaluates:
`weight_of` in csrc/core.h for the CPU and CUDA kernels and in the viewer's project.wgsl and
project.glsl for the GPU renderers; the image in `sortfree_resolve` of csrc/pairs.h and
`resolve_sortfree` of resolve.wgsl and resolve.glsl.
"""

import math
from dataclasses import dataclass, replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.render.levels import at_level, choose_levels, enlarge, level_sizes
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import (
    ALPHA_MIN,
    CLASSIC,
    Footprint,
    Projected,
    pair_alphas,
    project,
)
from mobilegs.render.rendered import Rendered
from mobilegs.spherical_harmonics import C0

# of kernels, shaders and files, which know them by their index
WEIGHTINGS = ("mobile_gs", "no_depth", "no_scale", "sort_free_gs", "two_pass")
EXPONENTIAL = "exponential"  # has parameters per Gaussian: rendered through `exponential_lobes`
LOG_MAX = 80.0  # exp(-exp(80)) is 0 in every precision
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
    term (the paper's ablations). `sort_free_gs` is the linear form of SortFreeGS,
    `max(0, 1 - d / sigma) v`, with phi as the learned v. `exponential` is the paper's Eq. 1 as
    printed, `exp(-sigma d^beta)`, with sigma and beta of each Gaussian; files, kernels and viewers
    do not have it. `two_pass`, a stand-in for GES, finds the nearest surface of each pixel first
    and then blends the Gaussians that are not behind it, each with weight 1."""
    exponent_max: float = 4.0
    """Upper limit of `s_max / d` in the exponential, in (0, 80]. It keeps float16 renderers from
    overflow, and a large faint Gaussian from outweighing the whole image when a camera passes close
    to it: 8 shows such flashes between training views, 4 costs no quality."""
    sigma: float = 10.0
    """Depth in world units at which the weight of `sort_free_gs` reaches 0. Infinite: w = phi."""
    background_weight: float = 0.0
    """Weight of the background in the mean of `sort_free_gs` and `exponential`; 0 for all
    others."""
    alpha_min: float = ALPHA_MIN
    """Alpha at which an ellipse ends, in [0.0001, 0.1]. The area of the ellipses takes most of a
    frame's time, so a higher limit renders faster."""
    detached: bool = False
    """Cut the gradients of depth and scale through w, as in the paper's release. It changes no
    image, and files do not store it."""

    def __post_init__(self) -> None:
        names = (*WEIGHTINGS, EXPONENTIAL)
        if self.name not in names:
            raise InputError(f"unknown weighting '{self.name}': use one of {', '.join(names)}")
        if not 0 < self.exponent_max <= 80:
            raise InputError(f"exponent_max must lie in (0, 80], not {self.exponent_max}")
        if not 1e-4 <= self.alpha_min <= 0.1:
            raise InputError(f"alpha_min must lie in [0.0001, 0.1], not {self.alpha_min}")

    @property
    def index(self) -> int:
        """The number by which kernels and shaders know the formula.

        Raises InputError for `exponential`, which has parameters per Gaussian.
        """
        if self.name == EXPONENTIAL:
            raise InputError(
                "renderers have no formula for the weighting 'exponential': render a Scene with "
                "its attenuation, or what mobilegs.render.sortfree.exponential_lobes returns"
            )
        return WEIGHTINGS.index(self.name)

    def weights(
        self, depths: Float[Tensor, "n"], s_max: Float[Tensor, "n"], phi: Float[Tensor, "n"]
    ) -> Float[Tensor, "n"]:
        """Return the weights w of Gaussians at depth d > 0, of largest scale s_max, with phi >= 0.

        d is the camera-space z, s_max the largest of the three scales, both in world units.

        Paper Eq. 3: `w = phi^2 + phi / d^2 + exp(s_max / d)`, the exponent clamped to
        `exponent_max`. `sort_free_gs` (SortFreeGS, Hou et al. 2024): `w = max(0, 1 - d / sigma) v`.
        Raises InputError for `exponential`: see `exponential_weights`.
        """
        _ = self.index  # raises InputError
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


def exponential_weights(
    depths: Float[Tensor, "n"], attenuation: Float[Tensor, "n 2"]
) -> Float[Tensor, "n"]:
    """Return the weights of the paper's Eq. 1 as printed, `w = exp(-sigma d^beta)`, in [0, 1].

    `attenuation` holds `log(sigma)` and `log(beta)` of each Gaussian, so both stay above 0. d is
    the camera-space z in world units. w = 1 at d <= 0, where nothing is rendered. Gradients flow to
    both arguments and are finite at every depth.
    """
    log_sigma, log_beta = attenuation.unbind(1)
    log_depths = depths.clamp_min(torch.finfo(depths.dtype).tiny).log()
    exponents = (log_sigma + log_beta.exp() * log_depths).clamp_max(LOG_MAX).exp()
    return torch.exp(-exponents)


def exponential_lobes(
    lobes: Float[Tensor, "n m 2"],
    means: Float[Tensor, "n 3"],
    attenuation: Float[Tensor, "n 2"],
    weighting: Weighting,
    *,
    camera: Camera,
) -> tuple[Float[Tensor, "n m 2"], Weighting]:
    """Return lobes and a weighting with which any renderer renders `exponential` from `camera`.

    The lobes keep their opacity; their phi is `exponential_weights`, the same in every direction.
    The weighting is `sort_free_gs` with an infinite sigma, where w = phi, and has the background
    weight of `weighting`. Gradients flow to lobes, means and attenuation; not to means if
    `weighting` is detached.
    """
    if weighting.detached:
        means = means.detach()
    depths = means @ camera.viewmat[2, :3] + camera.viewmat[2, 3]
    constant = exponential_weights(depths, attenuation)[:, None] / C0
    raw_phi = torch.nn.functional.pad(constant, (0, lobes.shape[1] - 1))
    given = replace(weighting, name="sort_free_gs", sigma=math.inf)
    return torch.stack([lobes[..., 0], raw_phi], dim=2), given


@torch.no_grad()
def surface_limits(
    alphas: Float[Tensor, "pixels n"], depths: Float[Tensor, "n"]
) -> Float[Tensor, "pixels 1"]:
    """Return the depth up to which Gaussians count at each pixel, infinite without a surface.

    The surface is the nearest Gaussian with an alpha of at least 0.5 there. It stands in for the
    depth image of GES (Gaussian-enhanced surfels, Ye et al. 2025), from which it differs:

    | | GES | here |
    |---|---|---|
    | surface | opaque 2D surfels, a set of their own | the scene's Gaussians where alpha >= 0.5 |
    | first pass | depth and colour image of the surfels | the depth only |
    | second pass | Gaussians that pass the depth test | Gaussians up to 5 % behind the surface |
    | colour | the surfels' colours, with the Gaussians added | mean of the Gaussians by alpha |
    | training | surfels turn opaque, then Gaussians are added | one set, distilled |
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
    footprint: Footprint = CLASSIC,
    level_sigma: float = 0.0,
) -> Rendered:
    """Blend in any order: `C = (1 - T) sum(c a w) / sum(a w) + T bg`, `T = prod(1 - a)` (Eq. 2).

    A pixel that no Gaussian touches shows the background. `depth` is the same mean of z instead of
    c. Gradients flow to depth and largest scale through w, unless it is detached. Shapes and units
    as in `mobilegs.render_sortfree`.

    With `sort_free_gs` the image is Eq. 1: `C = (bg w_bg + sum(c a w)) / (w_bg + sum(a w))`; with
    what `exponential_lobes` returns, its weights are those of Eq. 1, too. With `two_pass`, only
    Gaussians up to the pixel's surface (`surface_limits`) count where it has one: there T = 0 and
    `C = sum(c a) / sum(a)`. A Gaussian with a lobe that is not finite is left out.

    With a `level_sigma` above 0, the sums of large Gaussians are added up in smaller targets
    (`render/levels.py`), for every weighting but `two_pass`.
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
    sums, radii = None, projected.radii.amax(1) * projected.visible
    for level in reversed(range(len(sizes) if level_sigma else 1)):
        size, chosen = sizes[level], levels == level
        part, faded = at_level(projected, opacities, level, chosen, size=size, alpha_min=alpha_min)
        alphas = pair_alphas(part, faded, size, alpha_min, soft_edge=footprint.soft_edge)
        own = _sums(alphas, part, weights, two_pass=weighting.name == "two_pass")
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


def _sums(
    alphas: Float[Tensor, "pixels n"],
    projected: Projected,
    weights: Float[Tensor, "n"],
    *,
    two_pass: bool,
) -> Float[Tensor, "pixels 6"]:
    """Return `sum(c a w)`, `sum(z a w)`, `sum(a w)` and T of each pixel."""
    transmittance = torch.exp(torch.log1p(-alphas).sum(1, keepdim=True))
    if two_pass:
        limits = surface_limits(alphas, projected.depths)
        alphas = torch.where(projected.depths <= limits, alphas, 0.0)
        transmittance = torch.where(limits.isinf(), transmittance, 0.0)
    aw = alphas * weights
    color, depth = aw @ projected.colors, aw @ projected.depths[:, None]
    return torch.cat([color, depth, aw.sum(1, keepdim=True), transmittance], dim=1)
