"""What a frame costs: how often its pixels are painted, as something that training can lower."""

import math

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.render.project import rotation_matrices


def overdraw(
    means: Float[Tensor, "n 3"],
    quats: Float[Tensor, "n 4"],
    log_scales: Float[Tensor, "n 3"],
    opacities: Float[Tensor, "n"],
    *,
    camera: Camera,
    alpha_min: float,
) -> Float[Tensor, ""]:
    """Ellipses that lie over a pixel, in the mean: what a device has to paint, which sorts nothing.

    An ellipse ends where alpha falls to `alpha_min`. Its area is taken from the shadow that an
    ellipsoid with semi-axes s throws along the unit direction u, given in its own axes:
    `pi sqrt((s2 s3 u1)^2 + (s1 s3 u2)^2 + (s1 s2 u3)^2)` (the projected area of an ellipsoid,
    Vickers 1996), without the blur and without what perspective adds beside the picture's
    centre. No Gaussian counts more than the picture, and none behind the near plane counts.
    Gaussians are those that can touch the picture. Gradients reach `log_scales` alone: opacities
    that pay for their area fade, which costs the picture far more.
    """
    offsets = (means - camera.position).detach()
    distances = offsets.norm(dim=1)
    along = normalize(offsets, dim=1)
    u = (rotation_matrices(quats.detach()).mT @ along[:, :, None])[:, :, 0]  # [n, 3]
    s = log_scales.exp()
    faces = torch.stack([s[:, 1] * s[:, 2], s[:, 0] * s[:, 2], s[:, 0] * s[:, 1]], 1)
    shadows = math.pi * (faces * u).norm(dim=1)
    reach = 2 * torch.log((opacities.detach() / alpha_min).clamp_min(1))  # squared radius
    focal = float(camera.K[0, 0] * camera.K[1, 1])
    pixels = camera.width * camera.height
    areas = reach * shadows * focal / distances.square().clamp_min(camera.near**2)
    counted = offsets @ camera.viewmat[2, :3] > camera.near
    return torch.where(counted, areas.clamp_max(pixels), 0.0).sum() / pixels
