"""SSIM on the CPU (csrc/ssim.cpp), six times faster than the banded products of losses.py."""

import torch
from torch import Tensor

from mobilegs.csrc.binding import address, library


class CpuSsim(torch.autograd.Function):
    """SSIM per pixel and channel of two images `[h, w, 3]`; only the first gets a gradient."""

    @staticmethod
    def forward(ctx, image: Tensor, target: Tensor) -> Tensor:
        image, target = image.detach().contiguous(), target.detach().contiguous()
        height, width, _ = image.shape
        means, score = torch.empty(height, 4, 3 * width), torch.empty_like(image)
        pointers = [address(t) for t in (image, target, means, score)]
        library().mgs_ssim_forward(height, width, *pointers)
        ctx.save_for_backward(image, target, means)
        return score

    @staticmethod
    def backward(ctx, grad: Tensor) -> tuple[Tensor, None]:  # pyright: ignore
        image, target, means = ctx.saved_tensors
        height, width, _ = image.shape
        grad, out = grad.contiguous(), torch.empty_like(image)
        pointers = [address(t) for t in (image, target, means, grad, out)]
        library().mgs_ssim_backward(height, width, *pointers)
        return out, None
