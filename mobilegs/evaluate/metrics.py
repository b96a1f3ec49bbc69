"""PSNR and SSIM of an image against a photo. Higher is better.

Conventions of all reported metrics: renders are first rounded to 8 bits (`displayed_colors`), as on
a screen or in a PNG; a mean weights all images alike; masked pixels are left out, not blackened.
"""

import math

import torch
from jaxtyping import Bool, Float, UInt8
from torch import Tensor
from torch.nn.functional import conv2d

WINDOW = 11  # px; Wang et al. 2004, as 3DGS uses it
SIGMA = 1.5  # px
CLIPPED = 1 / 255  # distance to black or white from which on a channel tells its colour
RIDGE = 1e-6  # of a regression towards unchanged colours, per pixel
NEUTRAL = 12 / 255  # most difference of the channels of white, grey and black
DARK = 64 / 255  # mean of the channels below which a colour cast is not seen
NEUTRAL_PIXELS = 100  # least for an error
C1, C2 = 0.01**2, 0.03**2  # stabilisers of SSIM for values in [0, 1]


def to_bytes(image: Float[Tensor, "h w 3"]) -> UInt8[Tensor, "h w 3"]:
    """Clamp an image to [0, 1] and round it to 8 bits per channel; NaN becomes 0."""
    return (image.nan_to_num(0).clamp(0, 1) * 255).round().to(torch.uint8)


def displayed_colors(image: Float[Tensor, "h w 3"]) -> Float[Tensor, "h w 3"]:
    """Return the image as a screen shows it: in [0, 1], rounded to multiples of 1/255."""
    return to_bytes(image).to(image.dtype) / 255


def psnr(
    image: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None = None,
) -> float:
    """Return the peak signal-to-noise ratio in dB for values in [0, 1], over all channels.

    Only pixels where `mask` is True count. Equal images give infinity, an empty mask gives NaN.
    """
    squares = (image.double() - target.double()).square()
    error = float((squares if mask is None else squares[mask]).mean())
    return math.inf if error == 0 else -10 * math.log10(error)


def decibels(value: float) -> str:
    """Return a PSNR for people; that of an empty mask is NaN."""
    if math.isnan(value):
        return "all masked"
    return "no error" if math.isinf(value) else f"{value:.2f} dB"


def fitted_color(
    image: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None = None,
) -> Float[Tensor, "3 4"]:
    """Return the affine change of colours `(A | b)` that brings `image` nearest to `target`.

    `image @ A.T + b` has the least sum of squared differences over the pixels where `mask` is True
    and no channel of either image is clipped, that is below 1/255 or above 254/255. A weak pull to
    no change decides where colours vary too little. float64, values in [0, 1].
    """
    x, y = image.reshape(-1, 3).double(), target.reshape(-1, 3).double()
    used = ((torch.minimum(x, y) >= CLIPPED) & (torch.maximum(x, y) <= 1 - CLIPPED)).all(1)
    if mask is not None:
        used &= mask.reshape(-1)
    ones = torch.ones(int(used.sum()), 1, dtype=x.dtype, device=x.device)
    x, y = torch.cat([x[used], ones], dim=1), y[used]
    same = torch.eye(3, 4, dtype=x.dtype, device=x.device)
    ridge = RIDGE * max(len(x), 1) * torch.eye(4, dtype=x.dtype, device=x.device)
    return torch.linalg.solve(x.T @ x + ridge, x.T @ y + ridge @ same.T).T


def color_corrected_psnr(
    image: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None = None,
) -> float:
    """Return the PSNR of the image after the change of colours of `fitted_color`, in dB.

    It does not count the exposure and white balance of a photo. Rounded to 8 bits, as all metrics.
    """
    change = fitted_color(image, target, mask).to(image.dtype)
    return psnr(displayed_colors(image @ change[:, :3].T + change[:, 3]), target, mask)


def neutral_rms(
    image: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None = None,
) -> float | None:
    """Return the RMS error of colour where the photo is white or grey, in units of 1/255.

    Colour is a channel's distance from the mean of the three, so errors of brightness do not count.
    None if the photo has fewer than 100 such pixels where `mask` is True.
    """
    neutral = (target.amax(-1) - target.amin(-1) <= NEUTRAL) & (target.mean(-1) >= DARK)
    if mask is not None:
        neutral &= mask
    if neutral.sum() < NEUTRAL_PIXELS:
        return None
    error = (image - target)[neutral].double()
    return 255 * float((error - error.mean(-1, keepdim=True)).square().mean().sqrt())


def ssim_map(
    image: Float[Tensor, "h w 3"], target: Float[Tensor, "h w 3"]
) -> Float[Tensor, "h w 3"]:
    """Return the structural similarity per pixel and channel, in [-1, 1]; differentiable.

    This is SSIM (Wang et al. 2004) as in 3DGS: a Gaussian window of 11 pixels and sigma 1.5 with
    zero padding, for values in [0, 1].
    """
    x, y = image.permute(2, 0, 1), target.permute(2, 0, 1)
    stacked = torch.cat([x, y, x * x, y * y, x * y])  # [15, h, w]
    offsets = torch.arange(WINDOW, dtype=image.dtype, device=image.device) - WINDOW // 2
    falloff = torch.exp(offsets.square() / (-2 * SIGMA**2))
    window = (falloff / falloff.sum()).expand(len(stacked), 1, WINDOW).contiguous()
    pad, groups = WINDOW // 2, len(stacked)
    # two passes of one channel each: 13x faster on a CPU than the maps as a batch
    rows = conv2d(stacked[None], window[..., None], padding=(pad, 0), groups=groups)
    means = conv2d(rows, window[:, :, None], padding=(0, pad), groups=groups)[0]
    mx, my, mxx, myy, mxy = means.view(5, 3, *image.shape[:2])
    variance_x, variance_y, covariance = mxx - mx * mx, myy - my * my, mxy - mx * my
    luminance = (2 * mx * my + C1) / (mx * mx + my * my + C1)
    structure = (2 * covariance + C2) / (variance_x + variance_y + C2)
    return (luminance * structure).permute(1, 2, 0)


def ssim(
    image: Float[Tensor, "h w 3"],
    target: Float[Tensor, "h w 3"],
    mask: Bool[Tensor, "h w"] | None = None,
) -> float:
    """Return the mean of `ssim_map` over the pixels where `mask` is True, or over all."""
    similarity = ssim_map(image, target)
    return float((similarity if mask is None else similarity[mask]).mean())
