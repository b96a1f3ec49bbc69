"""Training losses against photos, the teacher's images and the teacher's depths."""

import ctypes
import math
from functools import lru_cache

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.autograd.function import FunctionCtx

from mobilegs.csrc.binding import address, library, supports, validate
from mobilegs.evaluate.metrics import C1, C2, SIGMA, WINDOW
from mobilegs.render.kernels import cuda
from mobilegs.reproducible import total
from mobilegs.train.cuda_losses import CudaDistillation, CudaPhotoLoss

MIN_DEPTH = 1e-8  # gives pixels without depth a logarithm


@lru_cache(maxsize=16)
def _blur_matrix(size: int, dtype: torch.dtype, device: torch.device) -> Float[Tensor, "s s"]:
    """Return the Gaussian window as a banded matrix, with zero padding at the edges.

    Two dense products are some ten times faster on a CPU than depthwise convolutions of
    11 taps, forward and backward, at the sizes training uses.
    """
    reach = WINDOW // 2
    taps = torch.arange(-reach, reach + 1, dtype=dtype, device=device)
    taps = torch.exp(-(taps**2) / (2 * SIGMA**2))
    taps = taps / taps.sum()
    place = torch.arange(size, device=device)
    offset = place[:, None] - place
    return torch.where(offset.abs() <= reach, taps[(offset + reach).clamp(0, WINDOW - 1)], 0.0)


def _blur(maps: Float[Tensor, "c h w"]) -> Float[Tensor, "c h w"]:
    """Blur each map with SSIM's window, zero-padded. The operation is its own adjoint."""
    _, height, width = maps.shape
    rows = _blur_matrix(height, maps.dtype, maps.device)
    columns = _blur_matrix(width, maps.dtype, maps.device)
    return rows @ (maps @ columns)


class _Ssim(torch.autograd.Function):
    """SSIM per pixel and channel. Its backward pass blurs three maps instead of four."""

    @staticmethod
    def forward(ctx: FunctionCtx, x: Tensor, y: Tensor) -> Tensor:  # [3, h, w] each
        mean_x, mean_y, squares, product = _blur(torch.cat([x, y, x * x + y * y, x * y])).chunk(4)
        luminance = 2 * mean_x * mean_y + C1
        contrast = 2 * (product - mean_x * mean_y) + C2
        below_l = mean_x * mean_x + mean_y * mean_y + C1
        below_c = squares - mean_x * mean_x - mean_y * mean_y + C2
        score = luminance * contrast / (below_l * below_c)
        ctx.save_for_backward(x, y, mean_x, mean_y, luminance, contrast, below_l, below_c, score)
        return score

    @staticmethod
    def backward(ctx: FunctionCtx, grad: Tensor) -> tuple[Tensor, None]:  # pyright: ignore[reportIncompatibleMethodOverride]
        x, y, mean_x, mean_y, luminance, contrast, below_l, below_c, score = ctx.saved_tensors  # pyright: ignore[reportAttributeAccessIssue]
        below = below_l * below_c
        to_product = grad * 2 * luminance / below
        to_squares = -grad * score / below_c
        to_mean = (
            grad * 2 * mean_y * contrast / below
            - grad * score * 2 * mean_x / below_l
            - to_product * mean_y
            - to_squares * 2 * mean_x
        )
        mean, squares, product = _blur(torch.cat([to_mean, to_squares, to_product])).chunk(3)
        return mean + 2 * x * squares + y * product, None


class _CpuPhotoLoss(torch.autograd.Function):
    """The photo loss, the squared error and the gradient, by one call of csrc/ssim.cpp."""

    @staticmethod
    def forward(ctx, image: Tensor, photo: Tensor, mask: Tensor | None, ssim_weight: float):
        height, width, _ = image.shape
        validate(image, height, width, 3)
        validate(photo, height, width, 3)
        if mask is not None:
            validate(mask, height, width)
            mask = mask.contiguous()
        image, photo = image.detach().contiguous(), photo.contiguous()
        numbers = 3 * (height * width if mask is None else float(total(mask)))
        count, squared = max(numbers, 1), ctypes.c_double()
        gradient, scratch = torch.empty_like(image), torch.empty(3, *image.shape)
        run = library().mgs_photo_loss
        run.restype = ctypes.c_double
        weights = [ctypes.c_float(w / count) for w in (1 - ssim_weight, ssim_weight)]
        images = [address(t) for t in (image, photo, mask)]
        loss = run(
            *(height, width, *images, *weights),
            *(address(scratch), address(gradient), ctypes.byref(squared)),
        )
        ctx.save_for_backward(gradient)
        error = torch.tensor(squared.value / numbers if numbers else math.nan, dtype=torch.float32)
        ctx.mark_non_differentiable(error)
        return torch.tensor(loss, dtype=torch.float32), error

    @staticmethod
    def backward(ctx, grad: Tensor, _: Tensor) -> tuple[Tensor, None, None, None]:  # pyright: ignore
        [gradient] = ctx.saved_tensors
        return gradient * grad, None, None, None


def ssim_map(
    image: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"]
) -> Float[Tensor, "h w 3"]:
    """Return SSIM (Wang et al. 2004) per pixel and channel, for values in [0, 1].

    The window is a Gaussian of 11 px and sigma 1.5 with zero padding, as in 3DGS. Only `image`
    receives a gradient.
    """
    score = _Ssim.apply(image.permute(2, 0, 1), target.detach().permute(2, 0, 1))
    assert isinstance(score, Tensor)
    return score.permute(1, 2, 0)


def photo_loss(
    image: Float[Tensor, "h w 3"],
    photo: Float[Tensor, "h w 3"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
    ssim_weight: float = 0.2,
) -> Float[Tensor, ""]:
    """Return `(1 - w) L1 + w (1 - SSIM)`, averaged over pixels where `mask` is 1 (3DGS, Eq. 7).

    `w` is `ssim_weight`; values are in [0, 1]. Where the mask is 0, SSIM's window sees the photo's
    own pixels, so these neither add to the loss nor receive a gradient. A mask of zeros gives 0.
    Only `image` receives a gradient. Float32 uses the compiled kernels of the CPU or the GPU.
    """
    if kernel := _photo_kernel(image):
        return kernel.apply(image, photo, mask, ssim_weight)[0]  # pyright: ignore
    if mask is None:
        absolute = (image - photo).abs().mean()
        return (1 - ssim_weight) * absolute + ssim_weight * (1 - ssim_map(image, photo).mean())
    image = torch.where(mask[:, :, None] > 0, image, photo)
    weight = mask / (3 * total(mask)).clamp_min(1)
    absolute = ((image - photo).abs().sum(2) * weight).sum()
    dissimilar = ((1 - ssim_map(image, photo)).sum(2) * weight).sum()
    return (1 - ssim_weight) * absolute + ssim_weight * dissimilar


def photo_loss_and_error(
    image: Float[Tensor, "h w 3"],
    photo: Float[Tensor, "h w 3"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
    ssim_weight: float = 0.2,
) -> tuple[Float[Tensor, ""], Float[Tensor, ""]]:
    """Return `photo_loss` and the mean squared difference, averaged over the mask as well.

    The squared difference has no gradient; it is NaN for a mask of zeros.
    """
    if kernel := _photo_kernel(image):
        return kernel.apply(image, photo, mask, ssim_weight)  # pyright: ignore
    loss = photo_loss(image, photo, mask=mask, ssim_weight=ssim_weight)
    error = (image.detach() - photo).square().mean(2)
    return loss, error.mean() if mask is None else (error * mask).sum() / mask.sum()


def _photo_kernel(image: Tensor) -> type[torch.autograd.Function] | None:
    if cuda.takes(image):
        return CudaPhotoLoss
    return _CpuPhotoLoss if supports(image) else None


def color_distillation_loss(
    image: Float[Tensor, "h w 3"],
    teacher: Float[Tensor, "h w 3"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """Return the mean absolute difference to the teacher's image where `mask` is 1.

    This is Mobile-GS's distillation of colours. Values are in [0, 1]. A mask of zeros gives 0.
    """
    if mask is None:
        return (image - teacher).abs().mean()
    return ((image - teacher).abs().sum(2) * mask).sum() / (3 * total(mask)).clamp_min(1)


def front_loss(coverage: Float[Tensor, "h w"], target: Float[Tensor, "h w"]) -> Float[Tensor, ""]:
    """Return the mean absolute difference between two coverages before one plane, in [0, 1]."""
    if cuda.takes(coverage):
        return CudaDistillation.apply(coverage, None, None, target, None, None, 1.0, 0.0)  # pyright: ignore
    return (coverage - target).abs().mean()


def depth_distillation_loss(
    depth: Float[Tensor, "h w"],
    alpha: Float[Tensor, "h w"],
    teacher_depth: Float[Tensor, "h w"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """Return the variance of the log-depth error, `mean(e^2) - mean(e)^2`, at least 0.

    `e = log D - log D_teacher`, so a common factor of all depths does not count (Eigen et al. 2014
    with lambda 1). Depths are z of camera space in world units: `depth` is alpha-weighted, as the
    renderers return it, `teacher_depth` is the mean depth of a pixel, 0 where the teacher has none.
    A pixel counts where `alpha > 0.5` and `teacher_depth > 0`. Without such pixels the loss is 0.
    """
    counts = (alpha > 0.5) & (teacher_depth > 0) & (depth > 0)
    if mask is not None:
        counts = counts & (mask > 0)
    one = torch.ones_like(depth)
    mean_depth = torch.where(counts, depth, one) / torch.where(counts, alpha, one)
    error = mean_depth.log() - torch.where(counts, teacher_depth, one).log()
    return _variance(error, counts)


def distillation_loss(
    image: Float[Tensor, "h w 3"],
    depth: Float[Tensor, "h w"] | None,
    alpha: Float[Tensor, "h w"],
    teacher: Float[Tensor, "h w 3"],
    teacher_depth: Float[Tensor, "h w"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
    color_weight: float,
    depth_weight: float,
) -> Float[Tensor, ""]:
    """Return the weighted sum of `color_distillation_loss` and `depth_distillation_loss`.

    Depths do not count if `depth` is None. Float32 on a GPU uses kernels.
    """
    if cuda.takes(image):
        depths = (None, None, None) if depth is None else (depth, alpha, teacher_depth)
        weights = color_weight, depth_weight
        return CudaDistillation.apply(image, *depths[:2], teacher, depths[2], mask, *weights)  # pyright: ignore
    loss = color_weight * color_distillation_loss(image, teacher, mask=mask)
    if depth is None:
        return loss
    distance = depth_distillation_loss(depth, alpha, teacher_depth, mask=mask)
    return loss + depth_weight * distance


def raw_depth_loss(
    depth: Float[Tensor, "h w"],
    teacher_depth: Float[Tensor, "h w"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """Return the log-depth variance as Mobile-GS's release computes it: over all pixels.

    Both depths are alpha-weighted sums, not means. A depth of 0 counts as 1e-8, so a pixel that
    only one of the two covers outweighs all others.
    """
    error = (depth + MIN_DEPTH).log() - (teacher_depth + MIN_DEPTH).log()
    counts = torch.ones_like(depth, dtype=torch.bool) if mask is None else mask > 0
    return _variance(error, counts)


def _variance(error: Float[Tensor, "h w"], counts: Bool[Tensor, "h w"]) -> Float[Tensor, ""]:
    error = torch.where(counts, error, 0.0)
    number = counts.sum().clamp_min(1)
    return total(error * error) / number - (total(error) / number) ** 2
