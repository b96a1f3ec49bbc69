"""Cameras between those of the photos: there the teacher alone says what is right."""

import torch

from mobilegs.camera import Camera

NEIGHBOURS = 4
ALIKE = 0.7  # cosine of the angle between directions that look at the same things
LEAST, MOST = 0.25, 0.75  # shares of the way
TOTAL, EACH = 300, 2  # at least as many, and as many for each camera


def cameras_between(cameras: list[Camera], seed: int) -> list[Camera]:
    """Cameras on the way from each camera to one of its nearest neighbours that look alike.

    Those without such a neighbour have none: from places between opposite cameras one sees what
    neither does. The same `seed` gives the same cameras.
    """
    generator = torch.Generator().manual_seed(seed)
    eyes = torch.stack([camera.position for camera in cameras]).cpu()
    forward = torch.stack([camera.viewmat[2, :3] for camera in cameras]).cpu()
    apart = torch.cdist(eyes, eyes)
    apart[forward @ forward.T < ALIKE] = torch.inf
    apart.fill_diagonal_(torch.inf)
    found: list[Camera] = []
    for one, distances in zip(cameras, apart, strict=True):
        near = distances.argsort(stable=True)[:NEIGHBOURS]
        near = near[distances[near].isfinite()]
        if not len(near):
            continue
        for _ in range(max(EACH, -(-TOTAL // len(cameras)))):
            other = int(near[torch.randint(len(near), (1,), generator=generator)])
            share = LEAST + (MOST - LEAST) * float(torch.rand(1, generator=generator))
            found.append(one.interpolate(cameras[other], share))
    return found
