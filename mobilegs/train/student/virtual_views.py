"""Virtual cameras between the training cameras, where only the teacher gives a target."""

import torch

from mobilegs.camera import Camera

NEIGHBOURS = 4
MIN_COSINE = 0.7  # of the angle between the directions of cameras that look at the same things
MIN_SHARE, MAX_SHARE = 0.25, 0.75  # of the way from one camera to the other
MIN_TOTAL, MIN_PER_CAMERA = 300, 2


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
    found: list[Camera] = []
    for camera, row in zip(cameras, distances, strict=True):
        near = row.argsort(stable=True)[:NEIGHBOURS]
        near = near[row[near].isfinite()]
        if not len(near):
            continue
        for _ in range(views_per_camera(len(cameras))):
            other = int(near[torch.randint(len(near), (1,), generator=generator)])
            share = MIN_SHARE + (MAX_SHARE - MIN_SHARE) * float(torch.rand(1, generator=generator))
            found.append(camera.interpolate(cameras[other], share))
    return found
