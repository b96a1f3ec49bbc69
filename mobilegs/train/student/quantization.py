"""What a student learned, as codes: indices into codebooks, or multiples of steps."""

import math
from collections.abc import Mapping
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.compress.appearance import LATENTS, ColorDecoder, LinearDecoder
from mobilegs.compress.codebooks import (
    CUTS,
    Attribute,
    CodebookSizes,
    SubVectorCodebooks,
    apparent_size,
)
from mobilegs.compress.lobes import LobeDecoder
from mobilegs.compress.rotations import RotationCodes
from mobilegs.compress.uniform_quantizer import WEIGHT_DIGITS, ScalarCodes, ScalarSteps
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.encode import Codes
from mobilegs.train.autograd_ops import pass_through
from mobilegs.train.student.decorrelate import decorrelate_appearance, decorrelate_lobes
from mobilegs.train.student.view_dependence import ViewDependence

DAMPED = 0.7  # share of the way to the size asked for that is gone at once
FARTHEST = 0.3  # that steps grow at once, as a logarithm
GROWTH_MAX = math.log(8)
TO_CODE = ("log_scales", "quats", "logit_opacities", "lobe_latents", "static", "view")
SMALL = 0.6  # standard deviations from the mean within which a number hardly takes bits
SPREAD_MIN = 1e-6


def vector_codes(
    values: Mapping[Attribute, Tensor],
    view: ViewDependence,
    sizes: CodebookSizes,
    generator: torch.Generator,
) -> dict[Attribute, Codes]:
    """Codebooks by k-means of every attribute."""
    found: dict[Attribute, Codes] = {}
    for name, value in values.items():
        size = view.size if name == "lobes" else getattr(sizes, name)
        found[name] = SubVectorCodebooks.fit(
            value,
            length=view.length if name == "lobes" else CUTS[name].length,
            size=min(size, len(value)),
            generator=generator,
            weights=apparent_size(values["scale"]) if name == "scale" else None,
        )
    return found


def scalar_codes(values: Mapping[Attribute, Tensor], steps: ScalarSteps) -> dict[Attribute, Codes]:
    """The nearest multiples of the steps, of what `decorrelated` gave."""
    scales = ScalarCodes.fit(values["scale"], step=steps.scale)
    found: dict[Attribute, Codes] = {}
    for name, value in values.items():
        step = getattr(steps, name)
        if name == "rotation":
            found[name] = RotationCodes.fit(value, scales=scales, step=step)
        else:
            found[name] = scales if name == "scale" else ScalarCodes.fit(value, step=step)
    return found


def restored_codes(
    name: Attribute,
    state: Mapping[str, Any],
    steps: ScalarSteps | None,
    others: Mapping[Attribute, Codes],
) -> Codes:
    """Codes as they were in the model's `state`; of steps those of the scales come first."""
    indices = state["indices"][name]
    if steps is None:
        return SubVectorCodebooks(state["shared"][f"{name}.centers"]["value"], indices)
    if name == "rotation":
        scales = others["scale"]
        assert isinstance(scales, ScalarCodes)
        return RotationCodes(scales, steps.rotation, indices)
    return ScalarCodes(getattr(steps, name), indices)


def learning(codes: Codes, values: Tensor, rows: Tensor | None) -> Tensor:
    """What the codes of `rows` stand for; gradients reach `values`, what they ought to stand for.

    They reach codebooks or the step, too.
    """
    coded = codes(rows) if isinstance(codes, SubVectorCodebooks) else codes(rows, values)
    return coded + pass_through(values)


@torch.no_grad()
def pay(codes: Codes, values: Tensor, price: float) -> None:
    """Add to the gradients of `values` and of the step what a bit per Gaussian costs.

    Of rotations only the step pays, and no scale for the finer bits of angles that it causes.
    """
    if isinstance(codes, SubVectorCodebooks):
        return
    due: dict[Tensor, Tensor] = {}
    if isinstance(codes, ScalarCodes):
        due[values] = codes.slopes(values) * (price / len(values))
        # a larger step brings the codes together: as if the values came nearer to their mean
        due[codes.growth] = -(due[values] * (values - values.mean(0))).sum()
    else:
        due[codes.growth] = torch.full_like(codes.growth, price * codes.bits_by_growth(values))
    for tensor, grad in due.items():
        tensor.grad = grad if tensor.grad is None else tensor.grad + grad


@torch.no_grad()
def pay_ahead(tensors: Mapping[str, Tensor], price: float) -> None:
    """Add to the gradients of what has no codes yet what a bit per Gaussian costs.

    A number counts `log2(1 + (x / small)^2) / 2` bits more than the mean of its column, `x` away
    from it, does: what it would take if far ones were about as frequent as they are. `small` is in
    proportion to the column's standard deviation, and not followed by the gradient.
    """
    for values in (tensors[name] for name in TO_CODE if name in tensors):
        x = values - values.mean(0)
        small = (SMALL * x.square().mean(0).sqrt()).clamp_min(SPREAD_MIN)
        due = x / (x.square() + small.square()) * (price / math.log(2) / len(values))
        values.grad = due if values.grad is None else values.grad + due


@torch.no_grad()
def steer(
    codebooks: Mapping[Attribute, Codes], wanted: Mapping[str, Tensor], size: int, target: float
) -> None:
    """Change all steps by the same factor, so that a file of `size` bytes comes near `target`.

    `wanted` is what the codes ought to stand for; they must be chosen anew after that. Steps stay
    within eighths and eight times what they were at first: beyond, a picture falls apart.
    """
    steps = {
        name: codes
        for name, codes in codebooks.items()
        if not isinstance(codes, SubVectorCodebooks)
    }
    slope = sum(
        codes.bits_by_growth(wanted[name]) * len(wanted[name]) / 8 for name, codes in steps.items()
    )
    by = DAMPED * (target - size) / min(slope, -1e-3 * size)
    for codes in steps.values():
        codes.growth.add_(max(-FARTHEST, min(by, FARTHEST))).clamp_(-GROWTH_MAX, GROWTH_MAX)


def shorten_weights(*decoders: ColorDecoder | LobeDecoder | None) -> None:
    """From now on networks compute with weights of fewer digits, as files with steps hold them."""
    for decoder in decoders:
        if decoder is not None and not isinstance(decoder, LinearDecoder):
            decoder.digits = WEIGHT_DIGITS


@torch.no_grad()
def decorrelated(
    values: Mapping[Attribute, Tensor],
    positions: Float[Tensor, "n 3"],
    decoder: ColorDecoder,
    lobe_decoder: LobeDecoder | None,
    view: ViewDependence,
) -> dict[Attribute, Tensor]:
    """The values with latents in other coordinates, which the decoders' weights undo.

    These have fewer digits from then on. `positions` are the normalised ones.
    """
    found = dict(values)
    static, of_view = values["appearance"].tensor_split([LATENTS], dim=1)
    if "lobes" in values:
        assert lobe_decoder is not None
        none = values["scale"].new_zeros(len(static))
        shown = Gaussians(
            positions,
            values["rotation"],
            values["scale"],
            values["opacity"][:, 0] if "opacity" in values else none,
            decoder.decode(positions, static, of_view),
        )
        found["lobes"] = decorrelate_lobes(lobe_decoder, values["lobes"], shown, base=view.base)
    changed = decorrelate_appearance(decoder, positions, static, of_view)
    found["appearance"] = torch.cat(changed, dim=1)
    shorten_weights(decoder, lobe_decoder)
    return found
