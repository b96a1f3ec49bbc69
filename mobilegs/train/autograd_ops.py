"""Operations with a backward pass of their own."""

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.autograd.function import FunctionCtx


def straight_through(values: Tensor) -> Tensor:
    """Return zeros with the gradient of `values`: a straight-through estimator for quantisation.

    `quantised + straight_through(values)` has the value of `quantised` and trains `values`.
    """
    return values - values.detach()


def take_rows(tensor: Float[Tensor, "n ..."], rows: Int[Tensor, "m"]) -> Float[Tensor, "m ..."]:
    """Return `tensor[rows]` for distinct rows; the backward pass copies instead of adding."""
    return _TakeRows.apply(tensor, rows)  # pyright: ignore[reportReturnType]


class _TakeRows(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, tensor: Tensor, rows: Tensor) -> Tensor:
        ctx.shape = tensor.shape  # pyright: ignore[reportAttributeAccessIssue]
        ctx.save_for_backward(rows)
        return tensor.index_select(0, rows)

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[Tensor, None]:  # pyright: ignore[reportIncompatibleMethodOverride]
        [rows] = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        full = grad.new_zeros(ctx.shape)  # pyright: ignore[reportAttributeAccessIssue]
        return full.index_copy_(0, rows, grad), None
