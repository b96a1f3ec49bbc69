"""Points on the surfaces that a scene shows, one a pixel: where training may begin anew."""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.dataset import Frame, load_view
from mobilegs.gaussians import Gaussians
from mobilegs.render import measure_contributions
from mobilegs.render.project import rotation_matrices
from mobilegs.train.teacher.importance import drawn_rows


def chord_depths(
    origin: Float[Tensor, "3"], directions: Float[Tensor, "m 3"], gaussians: Gaussians
) -> Float[Tensor, "m"]:
    """How far along each ray the middle of its chord through its Gaussian is.

    Row i of `directions`, whose lengths are the unit, belongs to Gaussian i. There
    `|S^-1 R^T (o + t d - mean)|^2 = r^2` is `a t^2 + b t + c = 0`, and the middle of its
    solutions, `-b / 2a`, does not depend on r: it is the point of the ray that is nearest to the
    centre, as the Gaussian measures distances.
    """
    inward = rotation_matrices(gaussians.quats).transpose(1, 2) / gaussians.scales[:, :, None]
    start = (inward @ (origin - gaussians.means)[:, :, None])[:, :, 0]
    along = (inward @ directions[:, :, None])[:, :, 0]
    return -(start * along).sum(1) / (along * along).sum(1)


def pixel_directions(camera: Camera) -> Float[Tensor, "pixels 3"]:
    """World-space directions through the pixels' centres, row by row, one unit of depth long."""
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
    gaussians: Gaussians, frames: Sequence[Frame], *, count: int, generator: torch.Generator
) -> tuple[Float[Tensor, "m 3"], Float[Tensor, "m 3"]]:
    """At most `count` points in world space and their photos' colours (Mini-Splatting, 4.1).

    The photos are looked at one by one. Each gives as many pixels as any other, drawn with
    chances as their alpha, never masked ones; a pixel's point lies on its ray, in the middle of
    the Gaussian that has the largest share of it. What would lie behind the camera is left out.
    """
    each = max(1, count // len(frames))
    every = -(-len(frames) * each // max(1, count))  # 1, unless there are more photos than points
    points, colors = [], []
    for frame in frames[::every]:
        view = load_view(frame).to(gaussians.means.device)
        shapes = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities)
        found = measure_contributions(*shapes, camera=view.camera)
        weights = found.alpha if view.mask is None else found.alpha * (view.mask > 0.5)
        weights = torch.where(found.winner >= 0, weights, 0.0)
        pixels = drawn_rows(weights.flatten(), each, generator).to(weights.device)
        directions = pixel_directions(view.camera)[pixels]
        winners = gaussians.select(found.winner.flatten()[pixels].long())
        depths = chord_depths(view.camera.position, directions, winners)
        ahead = depths.isfinite() & (depths > 0)
        points.append((view.camera.position + depths[:, None] * directions)[ahead])
        colors.append(view.image.reshape(-1, 3)[pixels][ahead])
    return torch.cat(points)[:count], torch.cat(colors)[:count]
