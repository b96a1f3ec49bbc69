"""The CPU kernels: csrc/cpu.cpp, built with the package for several instruction sets."""

import ctypes
from functools import cache

import torch
from torch import Tensor

from mobilegs.csrc import binding
from mobilegs.csrc.binding import address
from mobilegs.render.contributions import Contributions, count_wins
from mobilegs.render.kernels.kernel_view import SPLAT_BYTES, KernelView, validate_inputs


class _Pointers(ctypes.Structure):
    def __init__(self, tensors: list[Tensor | None]) -> None:
        super().__init__(*[None if t is None else t.data_ptr() for t in tensors])


class Inputs(_Pointers):
    """Pointers to what a renderer reads, in the order of `Inputs` in csrc/cpu_common.h."""

    _fields_ = [(f"p{i}", ctypes.c_void_p) for i in range(7)]


class Gradients(_Pointers):
    """Pointers to the gradients of all `Inputs`, and to the screen gradients."""

    _fields_ = [(f"p{i}", ctypes.c_void_p) for i in range(8)]


@cache
def library(build: str | None = None) -> ctypes.CDLL:
    """Load a build of the kernels, by default the newest that this CPU runs.

    Raises ImportError if they are missing or of another version.
    """
    loaded = binding.library(build)
    if (loaded.mgs_view_bytes(), loaded.mgs_splat_bytes()) != (
        ctypes.sizeof(KernelView),
        SPLAT_BYTES,
    ):
        raise ImportError(
            "the C++ library belongs to another version of mobilegs: reinstall mobilegs"
        )
    return loaded


class _Bins:
    """The tile lists of one sorted image, freed with the last reference."""

    def __init__(self, native: ctypes.CDLL, pointer: int) -> None:
        self.native, self.pointer = native, pointer

    def __del__(self) -> None:
        self.native.mgs_bins_free(ctypes.c_void_p(self.pointer))


class CpuRaster(torch.autograd.Function):
    """Both renderers on the CPU: sorted with `opacities`, sort-free with `lobes`; one is None."""

    @staticmethod
    def forward(ctx, view, screen_grads, more, depth, means, quats, scales, opacities, sh, lobes):
        native, count = library(), len(means)
        inputs = [means, quats, scales, opacities, sh, lobes]
        validate_inputs(view, inputs, screen_grads, more)
        inputs = [None if t is None else t.detach().contiguous() for t in inputs]
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
            sums = torch.empty(view.pixels * (5 + depth + 3 * view.depth_pass + (view.levels > 1)))
            run = native.mgs_sortfree_forward
        outputs = [address(t) for t in (splats, radii, sums, image, alpha, depths)]
        read = [*inputs, more and more.values]
        bins = run(ctypes.byref(view), count, ctypes.byref(Inputs(read)), *outputs)
        ctx.bins = _Bins(native, bins) if lobes is None else None
        ctx.view, ctx.depth, ctx.screen_grads, ctx.more = view, depth, screen_grads, more
        ctx.save_for_backward(*inputs, splats, sums)
        ctx.mark_non_differentiable(radii)
        ctx.set_materialize_grads(False)
        return image, alpha, depths, radii

    @staticmethod
    def backward(ctx, *grads):
        *inputs, splats, sums = ctx.saved_tensors
        view, native, count = ctx.view, library(), len(inputs[0])
        shape = (view.height, view.width)
        g_image = torch.zeros(*shape, 3) if grads[0] is None else grads[0].contiguous()
        g_alpha = torch.zeros(shape) if grads[1] is None else grads[1].contiguous()
        g_depth = None
        if ctx.depth:
            g_depth = torch.zeros(shape) if grads[2] is None else grads[2].contiguous()
        out = [None if t is None else torch.empty_like(t) for t in inputs]
        pixels = [address(t) for t in (sums, g_image, g_alpha, g_depth)]
        more, more_grads = ctx.more or (None, None)
        args = [ctypes.byref(view), count, ctypes.byref(Inputs([*inputs, more])), address(splats)]
        filled = ctypes.byref(Gradients([*out, more_grads, ctx.screen_grads]))
        if ctx.bins is None:
            native.mgs_sortfree_backward(*args, *pixels, filled)
        else:
            bins = ctypes.c_void_p(ctx.bins.pointer)
            native.mgs_sorted_backward(*args, bins, *pixels, filled)
        return None, None, None, None, *out


def project_radii(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Tensor:
    """Return radii in pixels, 0 for Gaussians that the image cannot show, `[n]`."""
    validate_inputs(view, [means, quats, scales, opacities, sh, None], None)
    inputs = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    splats = torch.empty(len(means), SPLAT_BYTES, dtype=torch.uint8)
    radii = torch.empty(len(means))
    library().mgs_project(
        ctypes.byref(view),
        len(means),
        ctypes.byref(Inputs([*inputs, None, None])),
        address(splats),
        address(radii),
    )
    return radii


def measure_contributions(
    view: KernelView, means: Tensor, quats: Tensor, scales: Tensor, opacities: Tensor, sh: Tensor
) -> Contributions:
    """Return how much each Gaussian contributes to a sorted image; `sh` does not matter."""
    validate_inputs(view, [means, quats, scales, opacities, sh, None], None)
    inputs = [t.detach().contiguous() for t in (means, quats, scales, opacities, sh)]
    count, shape = len(means), (view.height, view.width)
    splats, radii = torch.empty(count, SPLAT_BYTES, dtype=torch.uint8), torch.empty(count)
    weights, touched = torch.empty(count), torch.empty(count, dtype=torch.int32)
    winner, alpha = torch.empty(shape, dtype=torch.int32), torch.empty(shape)
    outputs = [address(t) for t in (splats, radii, weights, touched, winner, alpha)]
    pointers = ctypes.byref(Inputs([*inputs, None, None]))
    library().mgs_contributions(ctypes.byref(view), count, pointers, *outputs)
    return Contributions(weights, touched, count_wins(winner, count), winner, alpha)
