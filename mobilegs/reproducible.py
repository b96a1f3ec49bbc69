"""Operations that give the same bits with any number of threads, where those of torch do not.

Only those on a CPU depend on threads: on other devices they are the operations of torch.
"""

import torch
from jaxtyping import Float
from torch import Tensor
from torch.autograd.function import FunctionCtx

ROWS = 64  # that become columns of one sum, because threads divide its columns, not its terms
GROUP = 256  # rows of a product


def sigmoid(values: Float[Tensor, "..."]) -> Float[Tensor, "..."]:
    """Return `1 / (1 + exp(-x))`.

    `torch.sigmoid` is rounded otherwise for the last values of each thread's share.
    """
    if values.device.type != "cpu":
        return torch.sigmoid(values)
    return _Sigmoid.apply(values)  # pyright: ignore[reportReturnType]


class _Sigmoid(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, values: Tensor) -> Tensor:
        result = values.neg().exp_().add_(1).reciprocal_()
        ctx.save_for_backward(result)
        return result

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> Tensor:  # pyright: ignore[reportIncompatibleMethodOverride]
        [result] = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        return grad * (result * (1 - result))


def column_means(values: Float[Tensor, "n ..."]) -> Float[Tensor, "..."]:
    """Return the mean over rows of each column."""
    return _column_sums(values) / len(values)


def total(values: Float[Tensor, "..."]) -> Float[Tensor, ""]:
    """Return the sum of all values. `torch.sum` adds the shares of its threads."""
    return _column_sums(values.reshape(-1))


def _column_sums(values: Float[Tensor, "n ..."]) -> Float[Tensor, "..."]:
    if values.device.type != "cpu":
        return values.sum(0)
    many, columns = len(values) // ROWS * ROWS, values.shape[1:]
    parts = values[:many].reshape(-1, ROWS * columns.numel()).sum(0)
    return parts.view(ROWS, *columns).sum(0) + values[many:].sum(0)


def times(values: Float[Tensor, "..."], factor: Float[Tensor, ""]) -> Float[Tensor, "..."]:
    """Return `values * factor`; only the factor has a gradient."""
    return _Times.apply(values.detach(), factor)  # pyright: ignore[reportReturnType]


class _Times(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, values: Tensor, factor: Tensor) -> Tensor:
        ctx.save_for_backward(values)
        return values * factor

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[None, Tensor]:  # pyright: ignore[reportIncompatibleMethodOverride]
        [values] = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        return None, total(grad * values)


def product(
    values: Float[Tensor, "n a"],
    matrix: Float[Tensor, "a b"],
    added: Float[Tensor, "b"] | Float[Tensor, "n b"],
) -> Float[Tensor, "n b"]:
    """Return `values @ matrix + added` for many rows.

    Products of torch divide the rows among the threads, and their gradients the terms of
    each sum. Here groups of rows are multiplied apart, each by one thread.
    """
    if values.device.type != "cpu":
        return torch.addmm(added, values, matrix)
    return _Product.apply(values, matrix, added)  # pyright: ignore[reportReturnType]


class _Product(torch.autograd.Function):
    @staticmethod
    def forward(ctx: FunctionCtx, values: Tensor, matrix: Tensor, added: Tensor) -> Tensor:
        ctx.save_for_backward(values, matrix)
        ctx.columns = added.dim() == 1  # pyright: ignore[reportAttributeAccessIssue]
        return _product(values, matrix, added)

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[Tensor | None, ...]:  # pyright: ignore[reportIncompatibleMethodOverride]
        values, matrix = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        to_values, to_matrix, to_added = ctx.needs_input_grad  # pyright: ignore[reportAttributeAccessIssue]
        grad = grad.contiguous()
        of_values = _product(grad, matrix.T, grad.new_zeros(len(matrix))) if to_values else None
        of_matrix = _product_of_columns(values, grad) if to_matrix else None
        of_added = grad if to_added else None
        if to_added and ctx.columns:  # pyright: ignore[reportAttributeAccessIssue]
            of_added = _column_sums(grad)
        return of_values, of_matrix, of_added


def _product(values: Tensor, matrix: Tensor, added: Tensor) -> Tensor:
    result = values.new_empty(len(values), matrix.shape[1])
    whole = _whole_groups(values)
    rest = slice(whole, None)
    added = added.expand_as(result)
    if whole:
        groups = _groups(values[:whole])
        each = matrix.expand(len(groups), *matrix.shape)
        torch.baddbmm(_groups(added[:whole]), groups, each, out=_groups(result[:whole]))
    if whole < len(values):
        products = torch.bmm(_padded(values[rest]), matrix.expand(2, *matrix.shape))
        result[rest] = products.flatten(0, 1)[: len(values) - whole] + added[rest]
    return result


def _product_of_columns(first: Tensor, second: Tensor) -> Tensor:
    """Return `first.T @ second`."""
    whole = _whole_groups(first)
    pairs = [(_padded(first[whole:]), _padded(second[whole:]))]
    if whole:
        pairs.append((_groups(first[:whole]), _groups(second[:whole])))
    return sum((torch.bmm(a.transpose(1, 2), b).sum(0) for a, b in pairs), first.new_zeros(()))


def _whole_groups(values: Tensor) -> int:
    """Return the number of first rows in whole groups: two at least, a single one is divided."""
    groups = len(values) // GROUP
    return GROUP * groups if groups > 1 else 0


def _groups(values: Tensor) -> Tensor:
    return values.unflatten(0, (-1, GROUP))


def _padded(values: Tensor) -> Tensor:
    """Return the rows, fewer than two groups, with zeros after them, as two groups."""
    padded = values.new_zeros(2 * GROUP, values.shape[1])
    padded[: len(values)] = values
    return _groups(padded)
