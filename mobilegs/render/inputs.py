"""The arguments of one call of a renderer, and the check of their shapes."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.render.project import CLASSIC, Footprint
from mobilegs.render.sortfree import Weighting

WIDTHS = {"means": (3,), "quats": (4,), "scales": (3,), "opacities": ()}
LEVEL_SIGMA_MIN = 0.6  # below it, a Gaussian is narrower than the blur that enlarging adds


class RenderInputs(NamedTuple):
    """Gaussians as a renderer takes them.

    Attributes:
        means, quats, scales: as in `render_sorted`.
        opacities: of sorted blending, `[n]`, or None.
        colors: spherical harmonics, `[n, (degree + 1)^2, 3]`, or colours of d channels, `[n, d]`.
        lobes: of sort-free blending, `[n, m, 2]`, or None.
    """

    means: Float[Tensor, "n 3"]
    quats: Float[Tensor, "n 4"]
    scales: Float[Tensor, "n 3"]
    opacities: Float[Tensor, "n"] | None
    colors: Float[Tensor, "n k 3"] | Float[Tensor, "n d"]
    lobes: Float[Tensor, "n m 2"] | None


class MoreHarmonics(NamedTuple):
    """The harmonics of colours except the first, as training optimises them.

    Attributes:
        values: `[n, k, 3]`, contiguous; the first ones of a row are rendered if k is larger.
        gradients: to which the backward pass adds, of the same shape.
    """

    values: Float[Tensor, "n k 3"]
    gradients: Float[Tensor, "n k 3"]


class RenderSettings(NamedTuple):
    """Settings of a renderer, besides Gaussians, camera and background.

    Attributes:
        weighting: of sort-free blending.
        footprint: how a Gaussian covers pixels.
        level_sigma: smallest standard deviation, in pixels of its target, of a Gaussian that
            sort-free blending adds up in a smaller target (`render/levels.py`); 0: none is.
    """

    weighting: Weighting = Weighting()
    footprint: Footprint = CLASSIC
    level_sigma: float = 0.0


def validate_level_sigma(sigma: float) -> None:
    """Raise InputError unless it is 0 or in the range that levels support."""
    if sigma != 0 and not LEVEL_SIGMA_MIN <= sigma <= 100:
        raise InputError(f"level_sigma must be 0 or lie in [{LEVEL_SIGMA_MIN}, 100], not {sigma}")


def validate_settings(settings: RenderSettings, *, sortfree: bool) -> None:
    """Raise InputError for settings that a renderer does not support."""
    validate_level_sigma(settings.level_sigma)
    if settings.footprint.soft_edge and not sortfree:
        raise InputError("sorted blending has no soft edge: use a footprint without it")


def shape_of(value: object) -> str:
    """Return the shape of a tensor as text, or the type of what is none."""
    return str(list(value.shape)) if isinstance(value, Tensor) else f"of {type(value).__name__}"


def validate_gaussians(means: Tensor, **others: Tensor) -> None:
    """Raise InputError unless `means` and `others`, by the names in `WIDTHS`, belong together.

    They are dense tensors of floats of one type, on one device, with one row per Gaussian.
    """
    count = len(means) if isinstance(means, Tensor) and means.ndim else 0
    for name, tensor in {"means": means, **others}.items():
        shape = [count, *WIDTHS[name]]
        if not isinstance(tensor, Tensor) or list(tensor.shape) != shape:
            raise InputError(f"{name} have shape {shape_of(tensor)}: {shape} was expected")
        if (tensor.dtype, tensor.device) != (means.dtype, means.device):
            raise InputError(
                f"{name} are {tensor.dtype} on {tensor.device}, but the means are {means.dtype} on "
                f"{means.device}"
            )
        if not tensor.is_floating_point() or tensor.layout != torch.strided or tensor.is_meta:
            raise InputError(f"{name} must be a dense tensor of floats, with memory")


def colors_of(sh: Tensor | None, colors: Tensor | None, count: int) -> Tensor:
    """Return the one that is given of `sh` and `colors`, for `count` Gaussians.

    Raises InputError if it is not exactly one, or has another shape than in `RenderInputs`.
    """
    if sh is not None and colors is not None:
        raise InputError("both sh and colors are given: give one of them")
    if not isinstance(sh if colors is None else colors, Tensor | None):
        raise InputError("sh and colors are tensors: give one of them")
    if colors is not None:
        if colors.ndim != 2 or len(colors) != count or colors.shape[1] == 0:
            raise InputError(
                f"colors have shape {list(colors.shape)}: [n, d] was expected, for {count} "
                "Gaussians and any number d of channels"
            )
        return colors
    if sh is None:
        raise InputError("no colours are given: give sh [n, (degree + 1)^2, 3] or colors [n, d]")
    if sh.ndim != 3 or sh.shape[0] != count or sh.shape[1] not in (1, 4, 9, 16) or sh.shape[2] != 3:
        raise InputError(
            f"sh have shape {list(sh.shape)}: [n, k, 3] was expected, for {count} Gaussians and "
            "k = 1, 4, 9 or 16; give evaluated colours as colors=[n, d]"
        )
    return sh
