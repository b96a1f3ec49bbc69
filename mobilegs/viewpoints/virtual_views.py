"""Virtual cameras between the photos and off their path, where only the teacher gives a target."""

from dataclasses import replace

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.viewpoints.visibility import depths_in_view

DIVISOR = 2  # of the photos' width and height
NEIGHBOURS = 4  # nearest cameras towards which a camera is interpolated
MIN_COSINE = 0.7  # between the directions of cameras that look at the same things
MIN_SHARE, MAX_SHARE = 0.25, 0.75  # of the way from one camera to the other
MIN_TOTAL, MIN_PER_CAMERA = 300, 2  # virtual views
POINTS = 10_000  # of the scene, from which its distance from a camera is measured
# Shift of a camera off the path, in median depths of the points that it sees: the standard
# deviation to the sides and up or down, and the range forwards.
SHIFT_STD, FORWARD_MIN, FORWARD_MAX = 0.12, -0.25, 0.4
NEAREST_RATIO = 0.5  # of the greatest shift forwards to the 0.05 quantile of their depths


def views_per_camera(photos: int) -> int:
    """Return the number of virtual views for each of `photos` cameras."""
    return max(MIN_PER_CAMERA, -(-MIN_TOTAL // photos))


def virtual_cameras(cameras: list[Camera], seed: int) -> list[Camera]:
    """Interpolate from each camera to its nearest neighbours with a similar direction.

    Cameras without such a neighbour give none: between opposite cameras, a view shows things that
    neither of them sees. The same `seed` gives the same cameras.
    """
    generator = torch.Generator().manual_seed(seed)
    positions = torch.stack([camera.position for camera in cameras]).cpu()
    forward = torch.stack([camera.viewmat[2, :3] for camera in cameras]).cpu()
    distances = torch.cdist(positions, positions)
    distances[forward @ forward.T < MIN_COSINE] = torch.inf
    distances.fill_diagonal_(torch.inf)
    virtual: list[Camera] = []
    for camera, row in zip(cameras, distances, strict=True):
        near = row.argsort(stable=True)[:NEIGHBOURS]
        near = near[row[near].isfinite()]
        if not len(near):
            continue
        for _ in range(views_per_camera(len(cameras))):
            other = int(near[torch.randint(len(near), (1,), generator=generator)])
            share = MIN_SHARE + (MAX_SHARE - MIN_SHARE) * float(torch.rand(1, generator=generator))
            virtual.append(camera.interpolate(cameras[other], share))
    return virtual


def move_off_path(cameras: list[Camera], means: Float[Tensor, "n 3"], seed: int) -> list[Camera]:
    """Move cameras off the path of the photos, in all directions.

    People who look at a scene move where nobody photographed. There, the order-independent weights
    of a student are extrapolated, and a faint Gaussian can cover everything behind it. `means` are
    those of the scene: shifts are in proportion to their distance. A camera that sees none of them
    stays. Cameras keep their rotations; the same `seed` gives the same cameras.
    """
    generator = torch.Generator().manual_seed(seed)
    points, moved = means[:: max(1, len(means) // POINTS)], []
    for camera in cameras:
        along = float(torch.rand(1, generator=generator))
        sideways = SHIFT_STD * torch.randn(2, generator=generator)
        depths = depths_in_view(points, camera)
        if len(depths):
            distance, nearest = depths.median(), depths.quantile(0.05)
            forwards = min(
                (FORWARD_MIN + (FORWARD_MAX - FORWARD_MIN) * along) * distance,
                NEAREST_RATIO * nearest,
            )
            shift = torch.stack([*(sideways.to(means) * distance), forwards])
            viewmat = camera.viewmat.clone()
            viewmat[:3, 3] -= shift
            camera = replace(camera, viewmat=viewmat)
        moved.append(camera)
    return moved
