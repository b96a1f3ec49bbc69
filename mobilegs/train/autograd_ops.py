"""Operations with a backward pass of their own."""

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.autograd.function import FunctionCtx
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.reproducible import total
from mobilegs.spherical_harmonics import C0


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


def with_weighting_gradients(
    lobes: Float[Tensor, "n m 2"],
    means: Float[Tensor, "n 3"],
    camera: Camera,
    *,
    sigma: Float[Tensor, ""] | None = None,
    background_weight: Float[Tensor, ""] | None = None,
) -> Float[Tensor, "n m 2"]:
    """Return `lobes` unchanged; the backward pass also gives `sigma` and the weight gradients.

    This serves `sort_free_gs`: its image depends on both, but its renderers take them as constants.
    None for `sigma` stands for an infinite one, with which w = phi.
    """
    means = means.detach()
    directions = normalize(means - camera.position, dim=1)
    _, phi = evaluate_lobes(lobes.detach(), directions)
    depths = means @ camera.viewmat[2, :3] + camera.viewmat[2, 3]
    same = _WeightingGradients.apply(lobes, sigma, background_weight, depths, phi)
    assert isinstance(same, Tensor)
    return same


class _WeightingGradients(torch.autograd.Function):
    """The gradients of `with_weighting_gradients`.

    With `w = max(0, 1 - d / sigma) phi` (SortFreeGS), `dL/dw` follows from `dL/dphi` and gives
    `dL/dsigma`. The image does not change if all weights and the background's grow by one
    factor, so `b dL/db = -sum(phi dL/dphi)`.
    """

    @staticmethod
    def forward(
        ctx: FunctionCtx,
        lobes: Float[Tensor, "n m 2"],
        sigma: Float[Tensor, ""] | None,
        background_weight: Float[Tensor, ""] | None,
        depths: Float[Tensor, "n"],
        phi: Float[Tensor, "n"],
    ) -> Tensor:
        ctx.save_for_backward(sigma, background_weight, depths, phi)  # pyright: ignore[reportArgumentType]
        return lobes.view_as(lobes)

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[Tensor | None, ...]:  # pyright: ignore[reportIncompatibleMethodOverride]
        sigma, background_weight, depths, phi = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        by_phi = phi * grad[:, 0, 1] / C0  # phi dL/dphi: the constant lobe has the weight C0
        to_sigma = None
        if sigma is not None:
            depth_factor = 1 - depths / sigma
            counts = depth_factor > 0
            by_factor = torch.where(counts, by_phi / torch.where(counts, depth_factor, 1.0), 0.0)
            to_sigma = total(by_factor * depths) / sigma**2
        to_background = None if background_weight is None else -total(by_phi) / background_weight
        return grad, to_sigma, to_background, None, None
