"""What a scene tells of itself: where its middle is, how far it reaches, which way is up."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians

DEGREES_UP = 25  # of the ground's normal to an axis that is usually up
FLAT = 0.5  # least variance against the middle one, from which on there is a ground
ROUNDS = 8  # of looking for the middle
AREA_MAX = 10  # times the median: a sky counts no more than that
USUAL = (0.0, -1.0, 0.0)  # up, in scenes that began with COLMAP


@dataclass(frozen=True)
class Layout:
    """Where there is something to see.

    Attributes:
        center: what most of the scene is around, `[3]`, world units.
        radius: distance from it within which half of what can be seen lies, world units.
        detail: standard deviation of the usual Gaussian, world units: of its two larger ones the
            geometric mean, and of those the median by opacity.
        up: unit vector, `[3]`.
        weights: how much each Gaussian can be seen, opacity times area; 0 for what is not finite.
    """

    center: Float[Tensor, "3"]
    radius: float
    detail: float
    up: Float[Tensor, "3"]
    weights: Float[Tensor, "n"]


@torch.no_grad()
def layout_of(gaussians: Gaussians, *, up: Float[Tensor, "3"] | None = None) -> Layout:
    """Find the middle, the reach and the vertical of a scene; `up` is believed if it is given.

    The middle is that of the ball which moves to the weighted median of what lies within three
    times the median distance, until it rests: far walls and skies do not drag it along. Up is
    perpendicular to the plane that the middle is flattest along, on the side where things rise
    from it, or, where it is close to -y or nothing is flat, as COLMAP's scenes mostly have it.

    Raises InputError if no Gaussian can be seen.
    """
    numbers = [tensor.reshape(len(gaussians), -1) for tensor in gaussians.tensors().values()]
    fine = torch.cat(numbers, dim=1).isfinite().all(1)
    two = torch.where(fine[:, None], gaussians.scales, 0.0).topk(2, dim=1).values
    areas = two.prod(1)
    fine &= (areas > 0) & areas.isfinite()
    areas = areas.clamp_max(AREA_MAX * areas[fine].median())
    weights = torch.where(fine, gaussians.opacities * areas, 0.0)
    if not weights.any():
        raise InputError("the scene has no Gaussian that can be seen: there is nothing to show")
    means = torch.where(fine[:, None], gaussians.means, 0.0)

    near = weights
    for _ in range(ROUNDS):
        center = torch.stack([_median(means[:, axis], near) for axis in range(3)])
        distances = (means - center).norm(dim=1)
        radius = float(_median(distances, near))
        near = torch.where(distances <= 3 * radius, weights, 0.0)
        if not near.any():
            break
    if radius <= 0:
        radius = float(two[fine].median())
    if up is None:
        up = _vertical(means - center, near)
    seen = torch.where(fine, gaussians.opacities, 0.0)
    detail = float(_median(two.prod(1).sqrt().nan_to_num(0), seen))
    return Layout(
        center, radius, detail, torch.nn.functional.normalize(up.to(center), dim=0), weights
    )


def _median(values: Float[Tensor, "n"], weights: Float[Tensor, "n"]) -> Float[Tensor, ""]:
    order = values.argsort()
    sums = weights[order].double().cumsum(0)
    return values[order[int(torch.searchsorted(sums, sums[-1:] / 2))]]


def _vertical(offsets: Float[Tensor, "n 3"], weights: Float[Tensor, "n"]) -> Float[Tensor, "3"]:
    share = (weights / weights.sum()).double()[:, None]
    offsets = offsets.double()
    offsets = offsets - (share * offsets).sum(0)
    variances, axes = torch.linalg.eigh(offsets.T @ (share * offsets))
    usual = torch.tensor(USUAL, dtype=torch.float64, device=offsets.device)
    normal = axes[:, 0]
    if variances[0] > FLAT * variances[1]:
        return usual.float()
    if abs(float(normal @ usual)) > torch.cos(torch.deg2rad(torch.tensor(float(DEGREES_UP)))):
        return torch.sign(normal @ usual).float() * normal.float()
    heights = offsets @ normal
    rises = float((share[:, 0] * heights**3).sum())  # the long tail is on the upper side
    return (normal if rises >= 0 else -normal).float()
