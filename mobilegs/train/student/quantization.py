"""Quantisation of what a student learned, with the rate term and rate control.

Two methods: `nvq` stores indices into learned codebooks (paper, section 3.5), `sq` integer
multiples of learned step sizes. In both, training goes on with the quantised values, and a
straight-through estimator passes gradients on to the values behind them.
"""

import ctypes
import math
from collections.abc import Mapping
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.csrc.binding import address
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.encode import Quantizer
from mobilegs.representation.appearance import LATENTS, ColorDecoder, LinearDecoder
from mobilegs.representation.codebooks import (
    Attribute,
    CodebookSizes,
    SubVectorCodebooks,
    apparent_size,
)
from mobilegs.representation.lobes import LobeDecoder
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import (
    PSEUDO_COUNT,
    STEP_RATIO,
    WEIGHT_SIGNIFICAND_BITS,
    StepSizes,
    UniformQuantizer,
)
from mobilegs.reproducible import column_means, total
from mobilegs.train.autograd_ops import straight_through
from mobilegs.train.student import cuda_terms
from mobilegs.train.student.decorrelate import decorrelate_appearance, decorrelate_lobes
from mobilegs.train.student.view_dependence import CODEBOOK_SIZE, SUBVECTOR_LENGTH

# rate control
UPDATE_MAX = 1.4  # largest factor of the quality in one update
QUALITY_RANGE = 0.125, 12.0  # for which there are step sizes
# the rate term before quantisation
QUANTISED = ("log_scales", "quats", "logit_opacities", "lobe_latents", "static", "view")
RATE_SCALE = 0.6  # standard deviations from the mean within which values cost almost no bits
SPREAD_MIN = 1e-6


def fit_codebooks(
    values: Mapping[Attribute, Tensor],
    sizes: CodebookSizes,
    generator: torch.Generator,
) -> dict[Attribute, Quantizer]:
    """Return codebooks for every attribute, by k-means."""
    weights = apparent_size(values["scale"]) if sizes.weight_by_size else None
    quantizers: dict[Attribute, Quantizer] = {}
    for name, value in values.items():
        size = CODEBOOK_SIZE if name == "lobes" else getattr(sizes, name)
        quantizers[name] = SubVectorCodebooks.fit(
            value,
            length=SUBVECTOR_LENGTH if name == "lobes" else sizes.cuts[name].length,
            size=min(size, len(value)),
            generator=generator,
            weights=weights if name == "scale" else None,
        )
    return quantizers


def fit_uniform_quantizers(
    values: Mapping[Attribute, Tensor], step_sizes: StepSizes
) -> dict[Attribute, Quantizer]:
    """Return uniform quantisers for every attribute of decorrelated `values`."""
    scales = UniformQuantizer.fit(values["scale"], step_size=step_sizes.scale)
    rotations = RotationQuantizer.fit(
        values["rotation"], scales=scales, step_size=step_sizes.rotation
    )
    quantizers: dict[Attribute, Quantizer] = {"scale": scales, "rotation": rotations}
    for name, value in values.items():
        if name not in quantizers:
            step_size = getattr(step_sizes, name)
            quantizers[name] = UniformQuantizer.fit(value, step_size=step_size)
    return quantizers


def restore_quantizer(
    name: Attribute,
    state: Mapping[str, Any],
    step_sizes: StepSizes | None,
    others: Mapping[Attribute, Quantizer],
) -> Quantizer:
    """Return the quantiser of an attribute from the model's `state`.

    With `step_sizes` it is uniform; that of rotations needs the one of scales in `others`.
    """
    indices = state["indices"][name]
    if step_sizes is None:
        return SubVectorCodebooks(state["shared"][f"{name}.centers"]["value"], indices)
    if name == "rotation":
        scales = others["scale"]
        assert isinstance(scales, UniformQuantizer)
        return RotationQuantizer(scales, step_sizes.rotation, indices)
    return UniformQuantizer(getattr(step_sizes, name), indices)


def quantized(quantizer: Quantizer, values: Tensor, rows: Tensor | None) -> Tensor:
    """Return the quantised values of `rows`, differentiable.

    Gradients reach `values`, the unquantised values of these rows, by the straight-through
    estimator, and the codebooks or the step size.
    """
    if isinstance(quantizer, SubVectorCodebooks):
        return quantizer(rows) + straight_through(values)
    return quantizer(rows, values) + straight_through(values)


@torch.no_grad()
def add_rate_gradients(
    quantizers: Mapping[Attribute, Quantizer], tensors: Mapping[str, Tensor], bit_weight: float
) -> None:
    """Add the gradients of the rate term to the values in `tensors` and to the log step sizes.

    The rate term is `bit_weight` times the bits per Gaussian, with the codes nearest to the values.
    Codebooks have none. For rotations only the step size has a gradient, and scales have none for
    the refinement bits of rotations.
    """
    uniform = {name: of for name, of in quantizers.items() if isinstance(of, UniformQuantizer)}
    values = [tensors[name] for name in uniform]
    if cuda_terms.supports(*values):
        found = cuda_terms.add_rate_gradients(list(uniform.values()), values, bit_weight)
    else:
        pairs = zip(uniform.values(), values, strict=True)
        found = [_add_rate_gradients(*pair, bit_weight) for pair in pairs]
    for quantizer, gradient in zip(uniform.values(), found, strict=True):
        _add_to(quantizer.log_step_offset, gradient)
    for name, quantizer in quantizers.items():
        if not isinstance(quantizer, RotationQuantizer):
            continue
        log_step = quantizer.log_step_offset
        if cuda_terms.supports(tensors[name]):
            gradient = cuda_terms.log_step_gradient(quantizer, tensors[name], bit_weight)
        else:
            bits = _log_step_gradient(quantizer, tensors[name])
            gradient = torch.full_like(log_step, bit_weight * bits)
        _add_to(log_step, gradient)


def _add_to(tensor: Tensor, grad: Tensor) -> None:
    tensor.grad = grad if tensor.grad is None else tensor.grad + grad


def _add_rate_gradients(quantizer: UniformQuantizer, values: Tensor, bit_weight: float) -> Tensor:
    """Add the rate term's gradients to `values`; return that of the log step size."""
    if binding.supports(values) and values.is_contiguous():
        slope = _run_rate(quantizer, values, bit_weight)
        return torch.full_like(quantizer.log_step_offset, slope)
    quantizer.reassign(values)
    grad = quantizer.bits_gradient(values) * (bit_weight / len(values))
    _add_to(values, grad)
    # a larger step size moves codes together, as if values moved towards their mean
    return -total(grad * (values - column_means(values)))


def _run_rate(quantizer: UniformQuantizer, values: Tensor, bit_weight: float) -> float:
    """Add the rate term's gradients to `values`; return that of the log step size."""
    if values.grad is None:
        values.grad = torch.zeros_like(values)
    values.grad = values.grad.contiguous()
    binding.validate(values.grad, *values.shape)
    run = binding.library().mgs_rate
    run.restype = ctypes.c_double
    return run(
        ctypes.c_int64(len(values)),
        math.prod(values.shape[1:]),
        address(values),
        *(ctypes.c_float(float(quantizer.step_size)), ctypes.c_float(bit_weight / len(values))),
        *(ctypes.c_float(PSEUDO_COUNT), address(values.grad)),
    )


def _log_step_gradient(quantizer: RotationQuantizer, values: Float[Tensor, "n 4"]) -> float:
    """Return `quantizer.log_step_gradient(values)`."""
    if not (binding.supports(values) and values.is_contiguous()):
        return quantizer.log_step_gradient(values)
    run = binding.library().mgs_angle_bits
    run.restype = ctypes.c_double
    numbers = ctypes.c_float(float(quantizer.step_size)), ctypes.c_float(STEP_RATIO)
    bits = run(ctypes.c_int64(len(values)), address(values), *numbers)
    return bits / (2 * math.log(STEP_RATIO))


@torch.no_grad()
def add_early_rate_gradients(tensors: Mapping[str, Tensor], bit_weight: float) -> None:
    """Add the gradients of an estimated rate term to values that are not quantised yet.

    The estimate is `bits(x) = log2(1 + (x / s)^2) / 2` for a distance x to the mean of the column:
    the code length if values were distributed as `1 / sqrt(1 + (x / s)^2)`. The scale s is a
    constant times the standard deviation of the column, without a gradient.
    """
    found = [tensors[name] for name in QUANTISED if name in tensors]
    weights = [bit_weight / math.log(2) / max(1, len(values)) for values in found]
    if cuda_terms.supports(*found):
        cuda_terms.add_early_rate_gradients(found, weights, share=RATE_SCALE, least=SPREAD_MIN)
        return
    for values, weight in zip(found, weights, strict=True):
        if binding.supports(values) and values.is_contiguous():
            if values.grad is None:
                values.grad = torch.zeros_like(values)
            binding.library().mgs_early_rate(
                ctypes.c_int64(len(values)),
                math.prod(values.shape[1:]),
                address(values),
                *(ctypes.c_float(number) for number in (weight, RATE_SCALE, SPREAD_MIN)),
                address(values.grad),
            )
            continue
        x = values - column_means(values)
        scale = (RATE_SCALE * column_means(x.square()).sqrt()).clamp_min(SPREAD_MIN)
        grad = x / (x.square() + scale.square()) * weight
        _add_to(values, grad)


def controlled_quality(quality: float, size: float, target: float, initial: float) -> float:
    """Return the quality with which a file of `size` bytes comes nearer to `target` bytes.

    A file's size grows with the quality to the power of 0.5 to 0.9. The result stays within
    `QUALITY_RANGE`, or within the range from there to the `initial` quality.
    """
    low, high = min(initial, QUALITY_RANGE[0]), max(initial, QUALITY_RANGE[1])
    change = max(1 / UPDATE_MAX, min(target / size, UPDATE_MAX))
    return max(low, min(quality * change, high))


def shorten_weights(*decoders: ColorDecoder | LobeDecoder | None) -> None:
    """Make networks compute with the shorter significands that files with `sq` store."""
    for decoder in decoders:
        if decoder is not None and not isinstance(decoder, LinearDecoder):
            decoder.significand_bits = WEIGHT_SIGNIFICAND_BITS


@torch.no_grad()
def decorrelate(
    values: Mapping[Attribute, Tensor],
    positions: Float[Tensor, "n 3"],
    decoder: ColorDecoder,
    lobe_decoder: LobeDecoder | None,
) -> dict[Attribute, Tensor]:
    """Return values with decorrelated latents; transform the decoders' weights inversely.

    From then on these weights have shorter significands. `positions` are normalised.
    """
    decorrelated = dict(values)
    static, of_view = values["appearance"].tensor_split([LATENTS], dim=1)
    if "lobes" in values:
        assert lobe_decoder is not None
        gaussians = Gaussians(
            positions,
            values["rotation"],
            values["scale"],
            values["opacity"][:, 0],
            decoder.decode(positions, static, of_view),
        )
        decorrelated["lobes"] = decorrelate_lobes(
            lobe_decoder, values["lobes"], gaussians, base=True
        )
    changed = decorrelate_appearance(decoder, positions, static, of_view)
    decorrelated["appearance"] = torch.cat(changed, dim=1)
    shorten_weights(decoder, lobe_decoder)
    return decorrelated
