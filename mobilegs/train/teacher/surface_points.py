"""Surface points of a scene, one per pixel, from which training restarts (Mini-Splatting)."""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.dataset import Frame, load_view
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint, measure_contributions
from mobilegs.render.project import CLASSIC, rotation_matrices
from mobilegs.train.teacher.importance import sample_rows


def ray_depths(
    origin: Float[Tensor, "3"], directions: Float[Tensor, "m 3"], gaussians: Gaussians
) -> Float[Tensor, "m"]:
    """Return the parameter t at which each ray comes nearest to the mean of its Gaussian.

    Ray i runs from `origin` along `directions[i]` through Gaussian i; t is in lengths of the
    direction. Distances are the Gaussian's own: `|S^-1 R^T (o + t d - mean)|^2 = r^2` is
    `a t^2 + b t + c = 0`, and the midpoint of its solutions, `-b / 2a`, does not depend on r.
    """
    inward = rotation_matrices(gaussians.quats).transpose(1, 2) / gaussians.scales[:, :, None]
    start = (inward @ (origin - gaussians.means)[:, :, None])[:, :, 0]
    along = (inward @ directions[:, :, None])[:, :, 0]
    return -(start * along).sum(1) / (along * along).sum(1)


def pixel_rays(camera: Camera) -> Float[Tensor, "pixels 3"]:
    """Return world-space directions through the pixel centres, row by row, of unit depth."""
    like = camera.viewmat
    ys, xs = torch.meshgrid(
        torch.arange(camera.height, dtype=like.dtype, device=like.device) + 0.5,
        torch.arange(camera.width, dtype=like.dtype, device=like.device) + 0.5,
        indexing="ij",
    )
    places = torch.stack([xs.flatten(), ys.flatten()], dim=1)
    places = (places - camera.K[:2, 2]) / camera.K.diagonal()[:2]
    return torch.cat([places, torch.ones_like(places[:, :1])], dim=1) @ camera.viewmat[:3, :3]


@torch.no_grad()
def surface_points(
    gaussians: Gaussians,
    frames: Sequence[Frame],
    *,
    count: int,
    generator: torch.Generator,
    footprint: Footprint = CLASSIC,
) -> tuple[Float[Tensor, "m 3"], Float[Tensor, "m 3"]]:
    """Return at most `count` world-space points and their colours (Mini-Splatting, 4.1).

    Each photo gives the same number of pixels, sampled in proportion to alpha; masked pixels are
    left out. The point of a pixel lies on its ray, nearest to the Gaussian with the largest weight
    there. Points behind the camera are dropped.
    """
    each = max(1, count // len(frames))
    every = -(-len(frames) * each // max(1, count))  # 1, unless there are more photos than points
    points, colors = [], []
    for frame in frames[::every]:
        view = load_view(frame).to(gaussians.means.device)
        shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
        contributions = measure_contributions(*shapes, camera=view.camera, footprint=footprint)
        weights, winner = contributions.alpha, contributions.winner
        if view.mask is not None:
            weights = weights * (view.mask > 0.5)
        weights = torch.where(winner >= 0, weights, 0.0)
        pixels = sample_rows(weights.flatten(), each, generator).to(weights.device)
        directions = pixel_rays(view.camera)[pixels]
        winners = gaussians.select(winner.flatten()[pixels].long())
        depths = ray_depths(view.camera.position, directions, winners)
        ahead = depths.isfinite() & (depths > 0)
        points.append((view.camera.position + depths[:, None] * directions)[ahead])
        colors.append(view.image.reshape(-1, 3)[pixels][ahead])
    return torch.cat(points)[:count], torch.cat(colors)[:count]
