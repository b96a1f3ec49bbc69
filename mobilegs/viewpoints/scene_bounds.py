"""Estimates the centre, radius, detail size and up direction of a scene."""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.up import USUAL

UP_ANGLE_MAX = 25  # degrees between the ground's normal and `USUAL` or its opposite
FLATNESS_RATIO = 0.5  # of the least variance to the middle one, up to which there is a ground
CENTER_ITERATIONS = 8  # of the search for the centre
AREA_MAX = 10  # times the median area: limits the weight of a sky


@dataclass(frozen=True)
class SceneBounds:
    """Centre, size and orientation of the visible part of a scene.

    Attributes:
        center: the point that most of the scene surrounds, `[3]`, world units.
        radius: distance from `center` that holds half of the weights, world units.
        detail: size of a typical Gaussian, world units: the median, weighted by opacity, of the
            geometric mean of its two larger standard deviations.
        up: unit vector, `[3]`, in world coordinates.
        weights: visibility of each Gaussian, opacity times area, `[n]`; 0 if not finite.
    """

    center: Float[Tensor, "3"]
    radius: float
    detail: float
    up: Float[Tensor, "3"]
    weights: Float[Tensor, "n"]


@torch.no_grad()
def find_scene_bounds(
    gaussians: Gaussians, *, up: Float[np.ndarray, "3"] | None = None
) -> SceneBounds:
    """Estimate the bounds of a scene.

    The centre is a weighted median, repeated over the Gaussians within three times their median
    distance, so that far walls and skies do not shift it. `up` `[3]` is used if it is given.
    Otherwise up is the normal of the plane in which the inner Gaussians are flattest: on the side
    nearer to -y if the normal is within `UP_ANGLE_MAX` degrees of that axis, else on the side to
    which things rise. A scene without such a plane has up = -y, as COLMAP's scenes mostly do.

    Raises InputError if no Gaussian is visible.
    """
    numbers = [tensor.reshape(len(gaussians), -1) for tensor in gaussians.tensors().values()]
    fine = torch.cat(numbers, dim=1).isfinite().all(1)
    two = torch.where(fine[:, None], gaussians.scales, 0.0).topk(2, dim=1).values
    areas = two.prod(1)
    fine &= (areas > 0) & areas.isfinite()
    areas = areas.clamp_max(AREA_MAX * areas[fine].median())
    weights = torch.where(fine, gaussians.opacities * areas, 0.0)
    if not weights.any():
        raise InputError(
            "the scene has no visible Gaussian: its opacities or scales are 0 or not finite"
        )
    means = torch.where(fine[:, None], gaussians.means, 0.0)

    near, center, radius = weights, means[0], 0.0
    for _ in range(CENTER_ITERATIONS):
        center = torch.stack([_median(means[:, axis], near) for axis in range(3)])
        distances = (means - center).norm(dim=1)
        radius = float(_median(distances, near))
        near = torch.where(distances <= 3 * radius, weights, 0.0)
        if not near.any():
            break
    if radius <= 0:
        radius = float(two[fine].median())
    upward = _vertical(means - center, near) if up is None else torch.from_numpy(up)
    seen = torch.where(fine, gaussians.opacities, 0.0)
    detail = float(_median(two.prod(1).sqrt().nan_to_num(0), seen))
    return SceneBounds(
        center, radius, detail, torch.nn.functional.normalize(upward.to(center), dim=0), weights
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
    usual = torch.from_numpy(USUAL).to(offsets)
    normal = axes[:, 0]
    if variances[0] > FLATNESS_RATIO * variances[1]:
        return usual.float()
    if abs(float(normal @ usual)) > torch.cos(torch.deg2rad(torch.tensor(float(UP_ANGLE_MAX)))):
        return torch.sign(normal @ usual).float() * normal.float()
    heights = offsets @ normal
    rises = float((share[:, 0] * heights**3).sum())  # the distribution's long tail is above ground
    return (normal if rises >= 0 else -normal).float()
