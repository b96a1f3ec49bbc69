"""Numbers as the file stores them: rounded to half precision, with gradients that pass through."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn

HALF_MAX = 65504.0  # the largest finite half


def to_half(values: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
    """The nearest half (ties to even); what lies beyond the largest half becomes that one."""
    return values.clamp(-HALF_MAX, HALF_MAX).half()


class _RoundHalf(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, values: Tensor) -> Tensor:
        return to_half(values).to(values.dtype)

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> Tensor:
        return grads[0]


def round_half(values: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
    """`values` rounded to half precision, in their own dtype; the gradient is the identity's.

    Training that computes with rounded numbers (a straight-through estimator) ends with the
    very numbers that the file will hold.
    """
    return _RoundHalf.apply(values)  # pyright: ignore[reportReturnType]


def rounded_parameters(module: nn.Module) -> dict[str, Tensor]:
    """The parameters of `module` by name, rounded as stored.

    `torch.func.functional_call(module, rounded_parameters(module), inputs)` runs any module
    with the weights that its file will hold, and still trains the unrounded ones.
    """
    return {name: round_half(value) for name, value in module.named_parameters()}
