"""The CPU kernels: cpu.cpp, built with the package for several instruction sets."""

import ctypes
from functools import cache

import torch
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.csrc.binding import address
from mobilegs.render.contributions import Contributions, pixels_won
from mobilegs.render.kernels.kernel_view import SPLAT_BYTES, KernelView, refuse_strays


class _Pointers(ctypes.Structure):
    def __init__(self, tensors: list[Tensor | None]) -> None:
        super().__init__(*[None if t is None else t.data_ptr() for t in tensors])


class Inputs(_Pointers):
    """Pointers to means, quats, scales, opacities, sh and phi (None when sorted)."""

    _fields_ = [(f"p{i}", ctypes.c_void_p) for i in range(6)]


class Gradients(_Pointers):
    """Pointers to what the backward pass fills: as Inputs, and the screen gradients."""

    _fields_ = [(f"p{i}", ctypes.c_void_p) for i in range(7)]


@cache
def library(level: str | None = None) -> ctypes.CDLL:
    """Load the kernels of `level` (default: the best for this CPU) and check their struct sizes."""
    loaded = binding.library(level)
    if (loaded.mgs_view_bytes(), loaded.mgs_splat_bytes()) != (
        ctypes.sizeof(KernelView),
        SPLAT_BYTES,
    ):
        raise ImportError("the C++ library is of another version than the package: reinstall it")
    return loaded


class _Bins:
    """Owns the tile lists of one sorted picture until its backward pass is done."""

    def __init__(self, native: ctypes.CDLL, pointer: int) -> None:
        self.native, self.pointer = native, pointer

    def __del__(self) -> None:
        self.native.mgs_bins_free(ctypes.c_void_p(self.pointer))


class CpuRaster(torch.autograd.Function):
    """Both renderers on the CPU: opacities or `lobes`, the other is None."""

    @staticmethod
    def forward(ctx, view, screen_grads, depth, means, quats, scales, opacities, sh, lobes):
        native, count = library(), len(means)
        held = [means, quats, scales, opacities, sh, lobes]
        refuse_strays(view, held, screen_grads)
        held = [None if t is None else t.detach().contiguous() for t in held]
        shape = (view.height, view.width)
        image, alpha = torch.empty(*shape, 3), torch.empty(shape)
        depths = torch.empty(shape) if depth else None
        splats = torch.empty(count, SPLAT_BYTES, dtype=torch.uint8)
        radii = torch.empty(count)
        padded = [(side + 15) // 16 * 16 for side in shape]
        if lobes is None:
            sums = torch.empty(padded[0] * padded[1] * (4 + depth))
            run = native.mgs_sorted_forward
        else:
            sums = torch.empty(shape[0] * shape[1] * (5 + depth + view.two_pass))
            run = native.mgs_sortfree_forward
        outputs = [address(t) for t in (splats, radii, sums, image, alpha, depths)]
        bins = run(ctypes.byref(view), count, ctypes.byref(Inputs(held)), *outputs)
        ctx.bins = _Bins(native, bins) if lobes is None else None
        ctx.view, ctx.depth, ctx.screen_grads = view, depth, screen_grads
        ctx.save_for_backward(*held, splats, sums)
        ctx.mark_non_differentiable(radii)
        ctx.set_materialize_grads(False)
        return image, alpha, depths, radii

    @staticmethod
    def backward(ctx, *grads):
        *held, splats, sums = ctx.saved_tensors
        view, native, count = ctx.view, library(), len(held[0])
        shape = (view.height, view.width)
        g_image = torch.zeros(*shape, 3) if grads[0] is None else grads[0].contiguous()
        g_alpha = torch.zeros(shape) if grads[1] is None else grads[1].contiguous()
        g_depth = None
        if ctx.depth:
            g_depth = torch.zeros(shape) if grads[2] is None else grads[2].contiguous()
        out = [None if t is None else torch.empty_like(t) for t in held]
        given = [address(t) for t in (sums, g_image, g_alpha, g_depth)]
        args = [ctypes.byref(view), count, ctypes.byref(Inputs(held)), address(splats)]
        filled = ctypes.byref(Gradients([*out, ctx.screen_grads]))
        if ctx.bins is None:
            native.mgs_sortfree_backward(*args, *given, filled)
        else:
            bins = ctypes.c_void_p(ctx.bins.pointer)
            native.mgs_sorted_backward(*args, bins, *given, filled)
        return None, None, None, *out


def project_radii(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Tensor:
    """Radii in pixels, 0 for what the picture cannot show."""
    refuse_strays(view, [means, quats, scales, opacities, sh, None], None)
    held = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    splats = torch.empty(len(means), SPLAT_BYTES, dtype=torch.uint8)
    radii = torch.empty(len(means))
    library().mgs_project(
        ctypes.byref(view),
        len(means),
        ctypes.byref(Inputs([*held, None])),
        address(splats),
        address(radii),
    )
    return radii


def measure_contributions(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Contributions:
    """What each Gaussian gives to a sorted picture; the colours do not matter."""
    refuse_strays(view, [means, quats, scales, opacities, sh, None], None)
    held = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    count, shape = len(means), (view.height, view.width)
    splats, radii = torch.empty(count, SPLAT_BYTES, dtype=torch.uint8), torch.empty(count)
    weights, touched = torch.empty(count), torch.empty(count, dtype=torch.int32)
    winner, alpha = torch.empty(shape, dtype=torch.int32), torch.empty(shape)
    outputs = [address(t) for t in (splats, radii, weights, touched, winner, alpha)]
    inputs = ctypes.byref(Inputs([*held, None]))
    library().mgs_contributions(ctypes.byref(view), count, inputs, *outputs)
    return Contributions(weights, touched, pixels_won(winner, count), winner, alpha)
