"""Losses of images on a GPU, by the kernels of csrc/cuda_loss.h; the reference is losses.py.

The host reads nothing back: sums over pixels and the divisions by their number stay on the GPU.
"""

import ctypes
import math

import torch
from torch import Tensor

from mobilegs.csrc.binding import address, validate
from mobilegs.render.kernels import cuda

PHOTO_THREADS = 192  # LOSS_THREADS of csrc/cuda_loss.h


class CudaPhotoLoss(torch.autograd.Function):
    """The photo loss and the mean squared difference, `losses.photo_loss_and_error`."""

    @staticmethod
    def forward(ctx, image: Tensor, photo: Tensor, mask: Tensor | None, ssim_weight: float):
        height, width, _ = image.shape
        held = [_plain(t, image.device, height, width, 3) for t in (image, photo)]
        held.append(_plain(mask, image.device, height, width))
        l1, dissimilarity = ctypes.c_float(1 - ssim_weight), ctypes.c_float(ssim_weight)
        size = ctypes.c_int(height), ctypes.c_int(width)
        blocks = math.ceil(height / cuda.TILE) * math.ceil(width / cuda.TILE)
        maps, sums = image.new_empty(3, *image.shape), image.new_empty(blocks, 4)
        results = loss, error, share = [image.new_empty(()) for _ in range(3)]
        kernels = cuda.kernels_for(image)
        with kernels.current():
            arguments = [*size, *map(address, held), dissimilarity, address(maps), address(sums)]
            kernels.launch("mgs_photo_terms", blocks, PHOTO_THREADS, *arguments)
            arguments = [ctypes.c_int(blocks), l1, dissimilarity, *map(address, (sums, *results))]
            kernels.launch("mgs_photo_finish", 1, cuda.THREADS, *arguments)
        ctx.save_for_backward(*held, maps, share)
        ctx.size, ctx.l1, ctx.blocks = size, l1, blocks
        ctx.mark_non_differentiable(error)
        return loss, error

    @staticmethod
    def backward(ctx, grad: Tensor, _: Tensor) -> tuple[Tensor, None, None, None]:  # pyright: ignore
        *held, maps, share = ctx.saved_tensors
        gradient, kernels = torch.empty_like(held[0]), cuda.kernels_for(maps)
        with kernels.current():
            arguments = [*map(address, held), ctx.l1, *map(address, (maps, share, grad, gradient))]
            kernels.launch("mgs_photo_gradient", ctx.blocks, PHOTO_THREADS, *ctx.size, *arguments)
        return gradient, None, None, None


class _Distilled(ctypes.Structure):
    """Images and the teacher's; mirrors `Distilled` in csrc/cuda_loss.h field by field."""

    _fields_ = [
        (name, ctypes.c_void_p)
        for name in ("image", "teacher", "depth", "alpha", "teacher_depth", "mask")
    ]


class CudaDistillation(torch.autograd.Function):
    """The weighted differences to a teacher, `losses.distillation_loss`.

    Images have one value or three per pixel. `depth`, `alpha` and `teacher_depth` are None where
    depths do not count.
    """

    @staticmethod
    def forward(
        ctx,
        image: Tensor,
        depth: Tensor | None,
        alpha: Tensor | None,
        teacher: Tensor,
        teacher_depth: Tensor | None,
        mask: Tensor | None,
        color_weight: float,
        depth_weight: float,
    ):
        size, channels = image.shape[:2], math.prod(image.shape[2:])
        held = [_plain(t, image.device, *image.shape) for t in (image, teacher)]
        held += [_plain(t, image.device, *size) for t in (depth, alpha, teacher_depth, mask)]
        pixels = math.prod(size)
        blocks = math.ceil(pixels / cuda.THREADS)
        sums, factors, loss = image.new_empty(blocks, 5), image.new_empty(3), image.new_empty(())
        ctx.counts = ctypes.c_int64(pixels), ctypes.c_int(channels)
        kernels = cuda.kernels_for(image)
        with kernels.current():
            arguments = [*ctx.counts, _distilled(held), address(sums)]
            kernels.launch("mgs_distill_terms", blocks, cuda.THREADS, *arguments)
            arguments = [ctypes.c_int(blocks), ctypes.c_int(channels)]
            arguments += [ctypes.c_float(weight) for weight in (color_weight, depth_weight)]
            arguments += [address(t) for t in (sums, loss, factors)]
            kernels.launch("mgs_distill_finish", 1, cuda.THREADS, *arguments)
        ctx.save_for_backward(*held, factors)
        ctx.blocks = blocks
        return loss

    @staticmethod
    def backward(ctx, grad: Tensor):  # pyright: ignore[reportIncompatibleMethodOverride]
        *held, factors = ctx.saved_tensors
        image, _, depth, alpha, *_ = held
        gradients = [None if t is None else torch.empty_like(t) for t in (image, depth, alpha)]
        kernels = cuda.kernels_for(image)
        with kernels.current():
            arguments = [*ctx.counts, _distilled(held), *map(address, (factors, grad, *gradients))]
            kernels.launch("mgs_distill_gradient", ctx.blocks, cuda.THREADS, *arguments)
        return *gradients, None, None, None, None, None


def _plain(tensor: Tensor | None, device: torch.device, *shape: int) -> Tensor | None:
    """Return a tensor as kernels read it; raises InputError for one that they must not read."""
    if tensor is None:
        return None
    validate(tensor, *shape, device=device)
    return tensor.detach().contiguous()


def _distilled(held: list[Tensor | None]) -> _Distilled:
    return _Distilled(*(None if t is None else t.data_ptr() for t in held))
