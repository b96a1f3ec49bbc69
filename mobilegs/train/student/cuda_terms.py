"""The rate term before and after quantisation, by the kernels of csrc/cuda_terms.h.

The host reads nothing, so it never waits. The reference is `quantization.py`.
"""

import ctypes
import math
from collections.abc import Sequence
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.csrc.binding import address
from mobilegs.render.kernels import cuda
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import (
    CODE_LIMIT,
    PSEUDO_COUNT,
    STEP_RATIO,
    StepSizeQuantizer,
    UniformQuantizer,
)

# of csrc/cuda_terms.h
TENSORS_MAX = 6
PARTS, CHUNKS = 128, 32  # blocks of a tensor, and of a column whose codes are counted
PLACES = 2 * CODE_LIMIT + 5
ANGLES = 3


class _LearnedStep(ctypes.Structure):
    """Mirrors `LearnedStep` in csrc/terms.h field by field."""

    _fields_ = [
        ("log_offset", ctypes.c_void_p),
        *((name, ctypes.c_float) for name in ("initial", "least", "most")),
    ]

    @classmethod
    def of(cls, quantizer: StepSizeQuantizer) -> "_LearnedStep":
        """Return the step size of a quantiser."""
        log_offset, initial = quantizer.log_step_offset.data_ptr(), quantizer.initial_step_size
        return cls(log_offset, initial, *quantizer.step_size_range)


class _RateTensor(ctypes.Structure):
    """Mirrors `RateTensor` in csrc/cuda_terms.h field by field."""

    _fields_ = [
        *((name, ctypes.c_void_p) for name in ("values", "before", "gradients")),
        ("step", _LearnedStep),
        ("count", ctypes.c_int64),
        ("weight", ctypes.c_float),
        *((name, ctypes.c_int) for name in ("columns", "first")),
    ]


def supports(*tensors: Tensor) -> bool:
    """Return True if there are tensors, and kernels take them: contiguous float32 on a GPU."""
    return bool(tensors) and cuda.takes(*tensors) and all(t.is_contiguous() for t in tensors)


def add_early_rate_gradients(
    tensors: Sequence[Tensor], weights: Sequence[float], *, share: float, least: float
) -> None:
    """Add the gradients of the estimated rate term to `tensors`.

    `weights` are those of a bit of one row. The scale of the estimate is `share` standard
    deviations, at least `least`.
    """
    structs, columns = _structs(tensors, weights)
    _add_gradients(structs, tensors)
    parts = tensors[0].new_empty(columns * PARTS, 2, dtype=torch.float64)
    blocks = PARTS * len(tensors)
    _launch("mgs_early_rate_sums", blocks, structs, parts)
    scale = ctypes.c_float(share), ctypes.c_float(least)
    _launch("mgs_early_rate", blocks, structs, parts, *scale)


def add_rate_gradients(
    quantizers: Sequence[UniformQuantizer], tensors: Sequence[Tensor], bit_weight: float
) -> Sequence[Float[Tensor, ""]]:
    """Add the gradients of the rate term to `tensors`; return those of the log step sizes."""
    structs, columns = _structs(tensors, [bit_weight / len(values) for values in tensors])
    _add_gradients(structs, tensors)
    for struct, quantizer in zip(structs, quantizers, strict=False):
        struct.step = _LearnedStep.of(quantizer)
    counts = tensors[0].new_zeros(columns, PLACES, dtype=torch.int32)
    _launch("mgs_count_codes", CHUNKS * columns, structs, ctypes.c_int(columns), counts)
    parts = tensors[0].new_empty(columns * PARTS, 3, dtype=torch.float64)
    found = tensors[0].new_empty(len(tensors))
    pseudo = ctypes.c_float(PSEUDO_COUNT)
    _launch("mgs_rate", PARTS * len(tensors), structs, counts, pseudo, parts)
    _launch("mgs_rate_total", len(tensors), structs, parts, found)
    return found.unbind()


def log_step_gradient(
    quantizer: RotationQuantizer, values: Float[Tensor, "n 4"], bit_weight: float
) -> Float[Tensor, ""]:
    """Return `bit_weight * quantizer.log_step_gradient(values)`."""
    counts = values.new_zeros(2 * ANGLES, PLACES, dtype=torch.int32)
    count, step = ctypes.c_int64(len(values)), _LearnedStep.of(quantizer)
    ratio = ctypes.c_float(STEP_RATIO)
    _launch("mgs_count_angles", 2 * ANGLES * CHUNKS, values, count, step, ratio, counts)
    weight, found = bit_weight / (2 * math.log(STEP_RATIO)), values.new_empty(())
    _launch("mgs_angle_bits", 1, count, ctypes.c_float(weight), counts, found)
    return found


def _add_gradients(structs: ctypes.Array, tensors: Sequence[Tensor]) -> None:
    """Give the tensors gradients that kernels write, the sums with those that they have."""
    for struct, values in zip(structs, tensors, strict=False):
        if values.grad is None:
            values.grad = torch.empty_like(values)
        else:
            values.grad = values.grad.contiguous()
            struct.before = values.grad.data_ptr()
        struct.gradients = values.grad.data_ptr()


def _structs(tensors: Sequence[Tensor], weights: Sequence[float]) -> tuple[ctypes.Array, int]:
    """Return the struct `RateTensors`, and the number of columns of all tensors."""
    structs, first = (_RateTensor * TENSORS_MAX)(), 0
    for i, (values, weight) in enumerate(zip(tensors, weights, strict=True)):
        struct, columns = structs[i], math.prod(values.shape[1:])
        struct.values, struct.weight = values.data_ptr(), weight
        struct.count = len(values) if columns else 0
        struct.columns, struct.first = max(1, columns), first  # kernels divide by it
        first += struct.columns
    return structs, first


def _launch(name: str, blocks: int, *arguments: Any) -> None:
    """Start a kernel; tensors among its arguments become pointers."""
    kernels = cuda.kernels_for(next(a for a in arguments if isinstance(a, Tensor)))
    given = [address(a) if isinstance(a, Tensor) else a for a in arguments]
    with kernels.current():
        kernels.launch(name, blocks, cuda.THREADS, *given)
