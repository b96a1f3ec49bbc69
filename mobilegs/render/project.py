"""Projection of 3D Gaussians to ellipses in the image, and their alpha: the reference.

Plain differentiable PyTorch. Source: EWA splatting (Zwicker et al. 2001) as in 3DGS (Kerbl et al.
2023, Eq. 5); the compensated opacity is that of Mip-Splatting (Yu et al. 2024, Eq. 10). The same
formulas: `geometry_of` and `project` in csrc/core.h, `row_of` and `pair_alpha` in csrc/pairs.h,
`ellipse_of` and `look_at` in the viewer's WGSL and GLSL shaders.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.device import host_values
from mobilegs.errors import InputError
from mobilegs.spherical_harmonics import sh_colors

BLUR = 0.3  # px^2 added to both variances, so that no splat is thinner than a pixel (3DGS)
BLUR_MAX = 4.0  # px^2
ALPHA_MIN = 1 / 255  # alphas below are dropped (3DGS); a scene may set a higher limit
ALPHA_MAX = 0.99  # alphas are clamped to this (3DGS)
JACOBIAN_MARGIN = 0.3  # the linearisation point stays within 1.3 times the half field of view


@dataclass(frozen=True)
class SortedFootprint:
    """Blur of Gaussians on the image. Raises InputError for a blur outside its range."""

    blur: float = BLUR
    """Variance added along x and y, in px^2, in (0, 4] (gsplat's `eps2d`)."""
    antialiased: bool = False
    """Multiply the opacity by `sqrt(det S0 / det S)`, with S0 the covariance before the blur and S
    the one after it (Mip-Splatting, Eq. 10; gsplat's `rasterize_mode="antialiased"`). A Gaussian
    smaller than a pixel then covers as much as before the blur, so that a scene keeps its look in
    images of any size."""

    def __post_init__(self) -> None:
        if not 0 < self.blur <= BLUR_MAX:
            raise InputError(f"blur must lie in (0, {BLUR_MAX:g}] px^2, not {self.blur}")


@dataclass(frozen=True)
class Footprint(SortedFootprint):
    """Blur and edge of Gaussians on the image; part of a scene and of its file."""

    soft_edge: bool = False
    """Subtract alpha_min from every alpha, so that alpha falls to 0 at the ellipse's edge and does
    not end in a step. Sort-free blending only."""

    def drawn(self, blend: str) -> "Footprint":
        """Return the footprint as a blending draws it: `sorted` has no soft edge."""
        return replace(self, soft_edge=self.soft_edge and blend != "sorted")


CLASSIC = Footprint()  # that of 3DGS


class Projected(NamedTuple):
    """Gaussians as one camera sees them; names as in gsplat.

    Attributes:
        means2d: projected means in pixels, `[n, 2]`.
        conics: inverse 2D covariances `(A, B, C)` in 1 / px^2, `[n, 3]`: a Gaussian's falloff
            at offset (x, y) is `exp(-(A x^2 + 2 B x y + C y^2) / 2)`.
        compensations: factor of alpha, 1 unless the footprint is antialiased, `[n]`.
        depths: camera-space z of the means, `[n]`.
        colors: colours towards the camera, at least 0, `[n, 3]`.
        radii: half width and height, in pixels, of the box around the ellipse on which alpha
            equals alpha_min, `[n, 2]`; no gradient.
        visible: True where the Gaussian can touch the image, `[n]`. False, with gradient 0, for
            those behind the near plane, outside the image or too faint (opacity <= alpha_min, or
            a compensation of 0), and for those with a value that is not finite or a quaternion of
            length 0.
        covs: the 2D covariances, blur included, `(var_x, cov, var_y)` in px^2, `[n, 3]`.
        dets: their determinants in px^4, `[n]`.
    """

    means2d: Float[Tensor, "n 2"]
    conics: Float[Tensor, "n 3"]
    compensations: Float[Tensor, "n"]
    depths: Float[Tensor, "n"]
    colors: Float[Tensor, "n 3"]
    radii: Float[Tensor, "n 2"]
    visible: Bool[Tensor, "n"]
    covs: Float[Tensor, "n 3"]
    dets: Float[Tensor, "n"]


def rotation_matrices(quats: Float[Tensor, "n 4"]) -> Float[Tensor, "n 3 3"]:
    """Return the rotation matrices of quaternions wxyz of any length but 0."""
    w, x, y, z = torch.nn.functional.normalize(quats, dim=-1).unbind(-1)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, dim=-1) for row in rows], dim=-2)


def jacobian_limits(camera: Camera) -> tuple[float, float, float, float]:
    """Return the range of x/z and y/z in the Jacobian, as (x low, x high, y low, y high).

    Far outside the image the affine approximation diverges; 3DGS clamps the ray to 1.3 times half
    the field of view. This form also holds for a principal point off the centre.
    """
    fx, _, cx, _, fy, cy, *_ = host_values(camera.K)
    margin_x = JACOBIAN_MARGIN * 0.5 * camera.width / fx
    margin_y = JACOBIAN_MARGIN * 0.5 * camera.height / fy
    return (
        -cx / fx - margin_x,
        (camera.width - cx) / fx + margin_x,
        -cy / fy - margin_y,
        (camera.height - cy) / fy + margin_y,
    )


def project(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    sh: Float[Tensor, "n k 3"],
    *,
    camera: Camera,
    alpha_min: float = ALPHA_MIN,
    footprint: Footprint = CLASSIC,
) -> Projected:
    """Project activated Gaussians (scales in world units, opacities in [0, 1]) into `camera`.

    `S = J W Sigma W^T J^T + blur I` (3DGS, Eq. 5), as sums of products of its square root.
    `alpha_min` is the alpha at which the ellipse ends, before the compensation.
    """
    rotation, translation = camera.viewmat[:3, :3], camera.viewmat[:3, 3]
    focal = camera.K.diagonal()[:2]
    valid = (
        torch.cat([means, quats, scales, opacities[:, None], sh.flatten(1)], dim=1)
        .isfinite()
        .all(1)
    )
    valid &= (quats.detach() ** 2).sum(1) > 0
    valid &= opacities.detach() > alpha_min
    # invalid rows get finite values: 0 * inf in a gradient would reach every sum
    means = torch.where(valid[:, None], means, camera.position)
    quats = torch.where(valid[:, None], quats, quats.new_tensor([1.0, 0, 0, 0]))
    scales = torch.where(valid[:, None], scales, 1.0)
    sh = torch.where(valid[:, None, None], sh, 0.0)
    points = means @ rotation.T + translation  # [n, 3] camera space
    depths = points[:, 2].detach()
    valid = valid & (depths > camera.near) & (depths < camera.far)
    x, y, z = torch.where(valid[:, None], points, 1.0).unbind(1)

    x_low, x_high, y_low, y_high = jacobian_limits(camera)
    u = (x / z).clamp(x_low, x_high)
    v = (y / z).clamp(y_low, y_high)
    axes = rotation @ rotation_matrices(quats) * scales[:, None, :]  # [n, 3, 3] camera space
    row_x = (focal[0] / z)[:, None] * (axes[:, 0] - u[:, None] * axes[:, 2])  # [n, 3]
    row_y = (focal[1] / z)[:, None] * (axes[:, 1] - v[:, None] * axes[:, 2])
    blur = footprint.blur
    var_x = (row_x * row_x).sum(1) + blur
    var_y = (row_y * row_y).sum(1) + blur
    cov = (row_x * row_y).sum(1)
    # Cauchy-Binet: the determinant as a sum of squares, which cannot cancel to 0 or below
    cross = torch.linalg.cross(row_x, row_y)
    det_before = (cross * cross).sum(1)
    det = det_before + blur * (var_x + var_y - blur)
    conics = torch.stack([var_y, -cov, var_x], dim=1) / det[:, None]
    compensations = torch.ones_like(det)
    if footprint.antialiased:
        valid = valid & (det_before.detach() > 0)
        compensations = (torch.where(valid, det_before, 1.0) / torch.where(valid, det, 1.0)).sqrt()
    means2d = torch.stack([x / z, y / z], dim=1) * focal + camera.K[:2, 2]

    safe = torch.where(valid[:, None], means - camera.position, 1.0)
    colors = sh_colors(sh, torch.nn.functional.normalize(safe, dim=1))

    with torch.no_grad():
        reach = 2 * torch.log((opacities / alpha_min).clamp_min(1))  # squared Mahalanobis radius
        radii = torch.stack([reach * var_x, reach * var_y], dim=1).sqrt()
        radii = torch.where(valid[:, None], radii, 0.0)
        inside = box_touches(means2d, radii, (camera.height, camera.width))
        visible = valid & inside & conics.isfinite().all(1) & means2d.isfinite().all(1)
    covs = torch.stack([var_x, cov, var_y], dim=1)
    return Projected(means2d, conics, compensations, z, colors, radii, visible, covs, det)


def box_touches(
    means2d: Float[Tensor, "n 2"], radii: Float[Tensor, "n 2"], size: tuple[int, int]
) -> Bool[Tensor, "n"]:
    """Return True where a box contains the centre of a pixel of an image `(height, width)`."""
    first = torch.ceil(means2d - radii - 0.5)
    last = torch.floor(means2d + radii - 0.5)
    sides = means2d.new_tensor([size[1], size[0]])
    return ((last >= 0) & (first < sides) & (last >= first)).all(1)


def pair_alphas(
    projected: Projected,
    opacities: Float[Tensor, "n"],
    size: tuple[int, int],
    alpha_min: float = ALPHA_MIN,
    *,
    soft_edge: bool = False,
) -> Float[Tensor, "pixels n"]:
    """Return the alpha of every Gaussian at every pixel of `(height, width)`, row by row.

    `alpha = min(0.99, s o exp(-q / 2))` with q the squared Mahalanobis distance (3DGS, Eq. 4) and s
    the compensation, and 0 where `o exp(-q / 2)` is below `alpha_min`. With `soft_edge`,
    `alpha = min(0.99, s (o exp(-q / 2) - alpha_min))`. Where alpha is clamped its gradient is 0.
    """
    like = projected.means2d
    # 0 times an opacity that is not finite would reach the gradient of the pose
    opacities = torch.where(projected.visible, opacities, 0.0)
    ys, xs = torch.meshgrid(
        torch.arange(size[0], dtype=like.dtype, device=like.device) + 0.5,
        torch.arange(size[1], dtype=like.dtype, device=like.device) + 0.5,
        indexing="ij",
    )
    dx = xs.reshape(-1, 1) - like[:, 0]  # [pixels, n]
    dy = ys.reshape(-1, 1) - like[:, 1]
    a, b, c = projected.conics.unbind(1)
    alphas = opacities * torch.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy)
    counts = (alphas >= alpha_min) & projected.visible
    alphas = projected.compensations * (alphas - alpha_min if soft_edge else alphas)
    return torch.where(counts, alphas.clamp_max(ALPHA_MAX), 0.0)
