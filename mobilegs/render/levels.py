"""Levels: targets of a half, a quarter and an eighth of the image's size for large Gaussians.

Sort-free blending adds, so its sums can be split into groups, and each group be added up in a
target of its own size. A Gaussian that is smooth in the pixels of a coarse target is drawn there,
and covers a quarter, a sixteenth or a sixty-fourth of the pixels. Each target is enlarged twice and
added to the next finer one. This module is the reference. The same formulas: `level_of` and
`project` in csrc/core.h for the CPU and CUDA kernels, and the viewer's WGSL and GLSL shaders.

| level l | side of a pixel h | size of the target |
|---|---|---|
| 0 | 1 px | the image |
| 1 | 2 px | `n // 2 + 2` along a side of n |
| 2, 3 | 4, 8 px | `(n - 1) // 2 + 2` along a side of n of the level before |

Targets from level 1 on begin one of their pixels before the image, so that the image's border has
neighbours on both sides.
"""

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor

from mobilegs.render.project import Projected, box_touches

LEVELS = 4
WEIGHT_UNIT = 10.0  # weight w above which a Gaussian needs more pixels


def usual_level_sigma(*, soft_edge: bool) -> float:
    """Return the `level_sigma` with which viewers draw a scene.

    The image has 55 dB and more to the one with all Gaussians at full size, and about 50 dB with
    a depth pass, whose students train with levels. Without a soft edge,
    ellipses end in a step, which coarse targets show. Same value: `usualLevelSigma` in
    viewer/src/render/levels.js.
    """
    return 1.0 if soft_edge else 1.4


def level_sizes(height: int, width: int) -> list[tuple[int, int]]:
    """Return height and width of the targets of all levels, level 0 first."""
    sizes = [(height, width)]
    for level in range(1, LEVELS):
        shorter = 0 if level == 1 else 1
        rows, columns = sizes[-1]
        sizes.append(((rows - shorter) // 2 + 2, (columns - shorter) // 2 + 2))
    return sizes


def level_places(height: int, width: int) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Return the first row and column of each level in one image that holds all, and its size.

    Level 0 comes first, and the others one below the other on its right: GPUs draw all levels into
    one texture.
    """
    _, *coarse = level_sizes(height, width)
    places, row = [(0, 0)], 0
    for rows, _ in coarse:
        places.append((row, width))
        row += rows
    return places, (max(height, row), width + coarse[0][1])


@torch.no_grad()
def choose_levels(
    projected: Projected, weights: Float[Tensor, "n"], level_sigma: float
) -> Int[Tensor, "n"]:
    """Return the level of each Gaussian.

    It is the largest l with `sigma >= level_sigma 2^l max(1, w / 10)^(1/4)`, where sigma is the
    smaller standard deviation of the ellipse in pixels. A heavy Gaussian needs more pixels, because
    its errors outweigh lighter neighbours. `level_sigma` 0: level 0 for all.
    """
    if level_sigma == 0:
        return torch.zeros_like(weights, dtype=torch.int64)
    var_x, cov, var_y = projected.covs.unbind(1)
    larger = 0.5 * (var_x + var_y) + (0.25 * (var_x - var_y) ** 2 + cov * cov).sqrt()
    # the smaller eigenvalue from the determinant: the difference would cancel
    needed = level_sigma**2 * (weights / WEIGHT_UNIT).clamp_min(1).sqrt()
    share = projected.dets / larger / needed
    bounds = share.new_tensor([4**level for level in range(1, LEVELS)])
    return torch.bucketize(share, bounds, right=True)


def at_level(
    projected: Projected,
    opacities: Float[Tensor, "n"],
    level: int,
    chosen: Bool[Tensor, "n"],
    *,
    size: tuple[int, int],
    alpha_min: float,
    spread: float | None = None,
) -> tuple[Projected, Float[Tensor, "n"]]:
    """Return the `chosen` Gaussians and their opacities in the pixels of a level's target.

    Enlarging twice convolves with a B-spline: from level l to 0 it adds the variance
    `(4^l - 1) / 4` px^2. The covariance is S less that, and the opacity is multiplied by
    `sqrt(det S / det S')`, so that the enlarged Gaussian is the original one. `size` is the
    target's, `spread` another variance to take away, in px^2. All others are not visible.
    """
    side = 2**level
    taken = 0.25 * (side * side - 1) if spread is None else spread
    var_x, cov, var_y = projected.covs.unbind(1)
    shown = chosen & projected.visible
    # the others may be narrower than that
    var_x, var_y = (torch.where(shown, v - taken, 1.0) / side**2 for v in (var_x, var_y))
    cov = torch.where(shown, cov, 0.0) / side**2
    det = projected.dets - taken * (projected.covs[:, 0] + projected.covs[:, 2]) + taken**2
    det = torch.where(shown, det, 1.0) / side**4
    opacities = opacities * (torch.where(shown, projected.dets, 1.0) / det).sqrt() / side**2
    means2d = projected.means2d / side + (1 if level else 0)
    with torch.no_grad():
        reach = 2 * torch.log((opacities / alpha_min).clamp_min(1))
        radii = torch.stack([reach * var_x, reach * var_y], dim=1).sqrt()
        radii = torch.where(shown[:, None], radii, 0.0)
        shown = shown & box_touches(means2d, radii, size)
    return projected._replace(
        means2d=means2d,
        conics=torch.stack([var_y, -cov, var_x], dim=1) / det[:, None],
        radii=radii,
        visible=shown,
    ), opacities


def enlarge(
    coarse: Float[Tensor, "h w c"], size: tuple[int, int], *, to_image: bool
) -> Float[Tensor, "..."]:
    """Return a target enlarged twice, with `size` (height, width) of the next finer level.

    Bilinear: each pixel is 3/4 of the pixel that it lies in and 1/4 of its neighbour, along both
    axes. `to_image`: the finer level is 0, which begins at the image's corner.
    """
    for axis, count in enumerate(size):
        at = torch.arange(count, device=coarse.device) - (0 if to_image else 1)
        nearest = torch.div(at, 2, rounding_mode="floor") + 1
        neighbour = nearest + 2 * (at % 2) - 1
        coarse = 0.75 * coarse.index_select(axis, nearest) + 0.25 * coarse.index_select(
            axis, neighbour
        )
    return coarse
