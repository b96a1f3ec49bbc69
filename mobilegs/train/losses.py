"""What training minimises: distance to the photo, to the teacher's picture, to its depth."""

from functools import lru_cache

import torch
from jaxtyping import Bool, Float
from torch import Tensor
from torch.autograd.function import FunctionCtx

from mobilegs.evaluate.metrics import C1, C2, SIGMA, WINDOW
from mobilegs.train.ssim import CpuSsim

LEAST_DEPTH = 1e-8  # so that no depth at all has a logarithm, too


@lru_cache(maxsize=16)
def _blur_matrix(size: int, dtype: torch.dtype, device: torch.device) -> Float[Tensor, "s s"]:
    """The Gaussian window as a banded matrix: rows that reach over the edge meet zeros there.

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
    """Each map weighted by SSIM's window, zeros beyond the picture. It is its own adjoint."""
    _, height, width = maps.shape
    rows = _blur_matrix(height, maps.dtype, maps.device)
    columns = _blur_matrix(width, maps.dtype, maps.device)
    return rows @ (maps @ columns)


class _Ssim(torch.autograd.Function):
    """SSIM per pixel and channel; the adjoint blurs three maps instead of differentiating four."""

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


def ssim_map(
    image: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"]
) -> Float[Tensor, "h w 3"]:
    """Structural similarity (Wang et al. 2004) per pixel and channel, of values in [0, 1].

    Gaussian window of 11 px and sigma 1.5, zeros beyond the picture, as 3DGS trains it. Only
    `image` receives a gradient. Float32 on the CPU goes to the kernel.
    """
    if image.dtype == torch.float32 and image.device.type == "cpu":
        score = CpuSsim.apply(image, target)
        assert isinstance(score, Tensor)
        return score
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
    """`0.8 L1 + 0.2 (1 - SSIM)`, the mean over the pixels where `mask` is 1 (3DGS, Eq. 7).

    Pixels where the mask is 0 are shown to SSIM's window as the photo has them, so they neither
    add to the loss nor receive a gradient. A mask of zeros gives 0.
    """
    if mask is None:
        absolute = (image - photo).abs().mean()
        return (1 - ssim_weight) * absolute + ssim_weight * (1 - ssim_map(image, photo).mean())
    image = torch.where(mask[:, :, None] > 0, image, photo)
    weight = mask / (3 * mask.sum()).clamp_min(1)
    absolute = ((image - photo).abs().sum(2) * weight).sum()
    dissimilar = ((1 - ssim_map(image, photo)).sum(2) * weight).sum()
    return (1 - ssim_weight) * absolute + ssim_weight * dissimilar


def color_distillation_loss(
    image: Float[Tensor, "h w 3"],
    teacher: Float[Tensor, "h w 3"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """Mean absolute difference to the teacher's picture, over the pixels where `mask` is 1."""
    if mask is None:
        return (image - teacher).abs().mean()
    return ((image - teacher).abs().sum(2) * mask).sum() / (3 * mask.sum()).clamp_min(1)


def depth_distillation_loss(
    depth: Float[Tensor, "h w"],
    alpha: Float[Tensor, "h w"],
    teacher_depth: Float[Tensor, "h w"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """Variance of the log-depth error: `mean(e^2) - mean(e)^2`, `e = log D - log D_teacher`.

    It does not see a common factor of all depths (Eigen et al. 2014, with lambda 1). `depth` is
    alpha-weighted, as the renderers give it, `teacher_depth` already the mean depth of a pixel,
    0 where the teacher has none to offer. Only pixels count whose alpha exceeds 0.5 in both;
    without any the loss is 0.
    """
    counts = (alpha > 0.5) & (teacher_depth > 0) & (depth > 0)
    if mask is not None:
        counts = counts & (mask > 0)
    one = torch.ones_like(depth)
    mean_depth = torch.where(counts, depth, one) / torch.where(counts, alpha, one)
    error = mean_depth.log() - torch.where(counts, teacher_depth, one).log()
    return _variance(error, counts)


def raw_depth_loss(
    depth: Float[Tensor, "h w"],
    teacher_depth: Float[Tensor, "h w"],
    *,
    mask: Float[Tensor, "h w"] | None = None,
) -> Float[Tensor, ""]:
    """The same variance as the release has it: of all pixels, of depths as they are drawn.

    Both are sums of z over what a pixel shows, background included, not means. A depth of 0 counts
    as 1e-8, so a pixel that only one of the two reaches is worth more than all others.
    """
    error = (depth + LEAST_DEPTH).log() - (teacher_depth + LEAST_DEPTH).log()
    counts = torch.ones_like(depth, dtype=torch.bool) if mask is None else mask > 0
    return _variance(error, counts)


def _variance(error: Float[Tensor, "h w"], counts: Bool[Tensor, "h w"]) -> Float[Tensor, ""]:
    error = torch.where(counts, error, 0.0)
    number = counts.sum().clamp_min(1)
    return (error * error).sum() / number - (error.sum() / number) ** 2
