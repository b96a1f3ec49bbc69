"""Rounding to float16, as files store weights, with straight-through gradients."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

FLOAT16_MAX = 65504.0  # the largest finite number
SIGNIFICAND_BITS = 11  # of float16, the implicit one included


def to_float16(
    values: Float[Tensor, "..."], significand_bits: int = SIGNIFICAND_BITS
) -> Float[Tensor, "..."]:
    """Return the nearest float16 number (ties to even), clamped to the largest finite one.

    With fewer `significand_bits`, the nearest number that has no more than those.
    """
    if significand_bits < SIGNIFICAND_BITS:
        fraction, exponent = torch.frexp(values)
        rounded = (fraction * 2**significand_bits).round()
        values = torch.ldexp(rounded, exponent - significand_bits)
    return values.clamp(-FLOAT16_MAX, FLOAT16_MAX).half()


class _RoundFloat16(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, values: Tensor, significand_bits: int) -> Tensor:
        return to_float16(values, significand_bits).to(values.dtype)

    @staticmethod
    def backward(ctx: Any, *grads: Tensor):  # pyright: ignore[reportIncompatibleMethodOverride]
        return grads[0], None


def round_float16(
    values: Float[Tensor, "..."], significand_bits: int = SIGNIFICAND_BITS
) -> Float[Tensor, "..."]:
    """Round `values` to float16, in their own dtype; the gradient is the identity's.

    With this straight-through estimator, training computes with the numbers that a file holds.
    """
    return _RoundFloat16.apply(values, significand_bits)  # pyright: ignore[reportReturnType]
