"""Where training looks at each Gaussian from, and lobes that fit what is known along there."""

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

CAMERAS = 64  # that directions are taken from
RIDGE = 0.1  # of a fit, in directions: flat where nobody looks


@torch.no_grad()
def looks(
    gaussians: Gaussians, cameras: list[Camera]
) -> Iterator[tuple[Int[Tensor, "k"], Float[Tensor, "k 3"]]]:
    """For at most 64 cameras, evenly chosen: rows seen, and unit directions towards them."""
    means = gaussians.means
    for camera in cameras[:: max(1, -(-len(cameras) // CAMERAS))]:
        camera = camera.to(means.device)
        rows = visible_rows(means, gaussians.quats, gaussians.scales, camera=camera)
        yield rows, normalize(means[rows] - camera.position, dim=1)


@torch.no_grad()
def seen_metric(gaussians: Gaussians, cameras: list[Camera], degree: int) -> Float[Tensor, "m m"]:
    """Mean product of the harmonics over the directions from which cameras see Gaussians."""
    size = (degree + 1) ** 2
    total = torch.zeros(size, size, dtype=torch.float64)
    for _, directions in looks(gaussians, cameras):
        basis = sh_basis(directions, degree).double()
        total += (basis.T @ basis).cpu()
    if total.trace() == 0:
        return torch.eye(size, dtype=torch.float64)
    return total / total.trace() * size


@torch.no_grad()
def fit_to_network(
    network: ViewNetwork, gaussians: Gaussians, cameras: list[Camera], degree: int
) -> Float[Tensor, "n m 2"]:
    """Lobes nearest to what `network` says along the directions from which cameras see each.

    Weighted least squares: a direction counts as often as it is looked along, and a ridge keeps
    all but the constant parts small where that leaves a choice. Gaussians that no camera sees
    keep their base opacity and phi = 1.
    """
    count, size = len(gaussians), (degree + 1) ** 2
    means = gaussians.means
    gram, moment = means.new_zeros(count, size, size), means.new_zeros(count, size, 2)
    for rows, directions in looks(gaussians, cameras):
        basis = sh_basis(directions, degree)
        values = C0 * network(gaussians.select(rows), directions)  # [k, 1, 2]
        gram[rows] += basis[:, :, None] * basis[:, None, :]
        moment[rows] += basis[:, :, None] * values
    ridge = torch.full((size,), RIDGE, dtype=means.dtype, device=means.device)
    ridge[0] = 1e-4
    gram += torch.diag(ridge)
    moment[:, :1] += ridge[0] * constant_lobes(gaussians.logit_opacities)
    return torch.linalg.solve(gram, moment)
