"""Directions from which the training cameras see Gaussians, and a fit of lobes along them."""

from collections.abc import Iterator

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.gaussians import Gaussians
from mobilegs.render import visible_rows
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.view_network import ViewNetwork
from mobilegs.spherical_harmonics import C0, sh_basis

CAMERAS_MAX = 64
RIDGE = 0.1  # of a fit, in directions: makes lobes flat where no camera looks


@torch.no_grad()
def viewing_directions(
    gaussians: Gaussians, cameras: list[Camera]
) -> Iterator[tuple[Int[Tensor, "k"], Float[Tensor, "k 3"]]]:
    """Yield, for at most 64 evenly chosen cameras, visible rows and unit directions to them."""
    means = gaussians.means
    for camera in cameras[:: max(1, -(-len(cameras) // CAMERAS_MAX))]:
        camera = camera.to(means.device)
        rows = visible_rows(means, gaussians.quats, gaussians.scales, camera=camera)
        yield rows, normalize(means[rows] - camera.position, dim=1)


@torch.no_grad()
def basis_gram(gaussians: Gaussians, cameras: list[Camera], degree: int) -> Float[Tensor, "m m"]:
    """Return the mean product of the harmonics over viewing directions, with the trace `m`.

    As a metric, it weights errors of lobes by how often cameras look along a direction. Without
    any direction it is the identity.
    """
    size = (degree + 1) ** 2
    total = torch.zeros(size, size, dtype=torch.float64)
    for _, directions in viewing_directions(gaussians, cameras):
        basis = sh_basis(directions, degree).double()
        total += (basis.T @ basis).cpu()
    if total.trace() == 0:
        return torch.eye(size, dtype=torch.float64)
    return total / total.trace() * size


@torch.no_grad()
def fit_lobes_to_network(
    network: ViewNetwork, gaussians: Gaussians, cameras: list[Camera], degree: int
) -> Float[Tensor, "n m 2"]:
    """Fit lobes to the outputs of `network` along the viewing directions of each Gaussian.

    The fit is weighted least squares. Each view of a Gaussian counts once, and a ridge keeps all
    but the constant parts small where views leave them open. Gaussians that no camera sees keep
    their base opacity and phi = 1.
    """
    count, size = len(gaussians), (degree + 1) ** 2
    means = gaussians.means
    gram, moment = means.new_zeros(count, size, size), means.new_zeros(count, size, 2)
    for rows, directions in viewing_directions(gaussians, cameras):
        basis = sh_basis(directions, degree)
        values = C0 * network(gaussians.select(rows), directions)  # [k, 1, 2]
        gram[rows] += basis[:, :, None] * basis[:, None, :]
        moment[rows] += basis[:, :, None] * values
    ridge = torch.full((size,), RIDGE, dtype=means.dtype, device=means.device)
    ridge[0] = 1e-4
    gram += torch.diag(ridge)
    moment[:, :1] += ridge[0] * constant_lobes(gaussians.logit_opacities)
    return torch.linalg.solve(gram, moment)
