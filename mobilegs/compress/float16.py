"""Numbers as the file stores them: rounded to half precision, with gradients that pass through."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn

HALF_MAX = 65504.0  # the largest finite half
DIGITS = 11  # binary ones of a half, the one before the point included


def to_half(values: Float[Tensor, "..."], digits: int = DIGITS) -> Float[Tensor, "..."]:
    """The nearest half (ties to even); what lies beyond the largest half becomes that one.

    With fewer `digits` that of those that have no more binary digits.
    """
    if digits < DIGITS:
        share, exponent = torch.frexp(values)
        values = torch.ldexp((share * 2**digits).round(), exponent - digits)
    return values.clamp(-HALF_MAX, HALF_MAX).half()


class _RoundHalf(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, values: Tensor, digits: int) -> Tensor:
        return to_half(values, digits).to(values.dtype)

    @staticmethod
    def backward(ctx: Any, *grads: Tensor):  # pyright: ignore[reportIncompatibleMethodOverride]
        return grads[0], None


def round_half(values: Float[Tensor, "..."], digits: int = DIGITS) -> Float[Tensor, "..."]:
    """`values` rounded to half precision, in their own dtype; the gradient is the identity's.

    Training that computes with rounded numbers (a straight-through estimator) ends with the
    very numbers that the file will hold.
    """
    return _RoundHalf.apply(values, digits)  # pyright: ignore[reportReturnType]


def rounded_parameters(module: nn.Module) -> dict[str, Tensor]:
    """The parameters of `module` by name, rounded as stored.

    `torch.func.functional_call(module, rounded_parameters(module), inputs)` runs any module
    with the weights that its file will hold, and still trains the unrounded ones.
    """
    return {name: round_half(value) for name, value in module.named_parameters()}
