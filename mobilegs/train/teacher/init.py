"""Initial Gaussians of the teacher: at the capture's points, or at random points."""

import logging
import math
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float
from scipy.spatial import KDTree
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import rgb_to_sh0
from mobilegs.train.teacher.far import far_points
from mobilegs.train.teacher.silhouettes import draw_within, read_silhouettes

log = logging.getLogger(__name__)

NEIGHBORS = 3
SQUARED_DISTANCE_MIN = 1e-7  # of 3DGS, in world units: gives coinciding points a size


def initial_gaussians(
    dataset: Dataset,
    *,
    count: int,
    opacity: float,
    sh_degree: int,
    generator: torch.Generator,
    far: int = 0,
) -> Gaussians:
    """Return at most `count` Gaussians at the capture's points, or at random points without any.

    If the capture has more points, a random choice of them is taken. Random points lie where no
    photo is transparent (`silhouettes.draw_within`). At most `far` of the Gaussians lie on a far
    sphere instead (`far_points`), unless the photos are transparent around an object.
    """
    points, colors = dataset.points, dataset.colors
    sphere = points[:0], colors[:0]
    if far and not any(frame.alpha == "over" for frame in dataset.train):
        sphere = far_points(
            dataset.train, dataset.center, dataset.extent, count=min(far, count // 2)
        )
        count -= len(sphere[0])
    if len(points) == 0:
        log.warning("%s has no points: training starts from random ones", dataset.name)
        cameras = [frame.camera for frame in dataset.train]
        center, extent = dataset.center, dataset.extent

        def draw(count: int) -> Tensor:
            return random_points(cameras, center, extent, count=count, generator=generator)

        silhouettes = read_silhouettes(dataset.train)
        points = draw_within(silhouettes, draw, count) if silhouettes else draw(count)
        colors = torch.full_like(points, 0.5)
    elif len(points) > count:
        chosen = torch.randperm(len(points), generator=generator)[:count].sort().values
        points, colors = points[chosen], colors[chosen]
    points, colors = torch.cat([points, sphere[0]]), torch.cat([colors, sphere[1]])
    return gaussians_at(points, colors, opacity=opacity, sh_degree=sh_degree)


def gaussians_at(
    points: Float[Tensor, "n 3"],
    colors: Float[Tensor, "n 3"],
    *,
    opacity: float,
    sh_degree: int,
) -> Gaussians:
    """Return isotropic Gaussians at `points` (world units) with `colors` in [0, 1].

    All have the same `opacity`, in (0, 1). The standard deviation is the root mean square of the
    distances to the three nearest neighbors (3DGS, section 5.1); a single point gets 0.01.
    """
    count = len(points)
    sh = torch.zeros(count, (sh_degree + 1) ** 2, 3)
    sh[:, 0] = rgb_to_sh0(colors)
    quats = torch.zeros(count, 4)
    quats[:, 0] = 1
    log_scales = neighbor_distances(points).log()[:, None].expand(count, 3).contiguous()
    logit = math.log(opacity / (1 - opacity))
    return Gaussians(points.clone(), quats, log_scales, torch.full((count,), logit), sh)


def neighbor_distances(points: Float[Tensor, "n 3"]) -> Float[Tensor, "n"]:
    """Return the root mean square distance of each point to its three nearest neighbors."""
    if len(points) < 2:
        return torch.full((len(points),), 0.01)
    nearest = min(NEIGHBORS, len(points) - 1)
    array = points.numpy().astype(np.float64)
    distances, _ = KDTree(array).query(array, k=nearest + 1, workers=-1)
    squared = (np.atleast_2d(distances)[:, 1:] ** 2).mean(axis=1)
    return torch.from_numpy(np.sqrt(np.maximum(squared, SQUARED_DISTANCE_MIN))).float()


def random_points(
    cameras: Sequence[Camera],
    center: Float[Tensor, "3"],
    extent: float,
    *,
    count: int,
    generator: torch.Generator,
) -> Float[Tensor, "n 3"]:
    """Return `count` points, uniform in a cube in front of the cameras, in world units.

    If the cameras look at `center` (an object capture), the cube is centred there. Half its side is
    the median over the cameras of the distance times the tangent of half the narrower field of
    view; for NeRF's synthetic scenes that is 1.45. Otherwise (cameras that look outwards or in
    parallel) the cube reaches 3 extents to each side of the point one extent in front of the
    cameras' mean.
    """
    eyes = torch.stack([camera.position for camera in cameras])
    axes = torch.stack([camera.viewmat[2, :3] for camera in cameras])
    ahead = ((center - eyes) * axes).sum(1)  # depth of the centre in each camera
    if (ahead > 0.5 * extent).float().mean() > 0.9:
        tangents = torch.tensor(
            [
                min(camera.width / float(camera.K[0, 0]), camera.height / float(camera.K[1, 1])) / 2
                for camera in cameras
            ]
        )
        middle, half = center, float((ahead * tangents).median())
    else:
        middle, half = eyes.mean(0) + axes.mean(0) * extent, 3 * extent
    unit = torch.rand(count, 3, generator=generator)
    return middle + (2 * unit - 1) * half
