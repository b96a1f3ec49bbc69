"""Sort-free scenes among opaque meshes: the definition of what `MobileGSMesh` draws.

All Gaussians of all scenes are blended together by Eq. 2. A Gaussian contributes to a pixel if its
centre is nearer than the opaque mesh there. Each scene is moved, turned and scaled in the world;
its weights are those of the scene as it was trained.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import Projected, pair_alphas, project
from mobilegs.render.scene import Scene

BAND = 8  # rows of a picture that are computed at once


@dataclass
class Placed:
    """A scene in the world: its units are `matrix @ (x, y, z, 1)`, of one scale in all directions.

    Attributes:
        opacity: factor of the opacities.
    """

    scene: Scene
    matrix: torch.Tensor
    opacity: float = 1.0

    @property
    def scale(self) -> float:
        return float(self.matrix[:3, :3].det().abs() ** (1 / 3))

    def seen_by(self, camera: Camera) -> Camera:
        """Return the camera in the units of the scene."""
        viewmat = camera.viewmat @ self.matrix
        viewmat[:3] /= self.scale
        return replace(camera, viewmat=viewmat, near=self.scene.near)


class Sums(NamedTuple):
    """Sums of a picture's pixels: colours, nearness (1 / depth), weights, and T."""

    color: torch.Tensor
    nearness: torch.Tensor
    weight: torch.Tensor
    transmittance: torch.Tensor

    @property
    def mean(self) -> torch.Tensor:
        """The mean colour, `[h, w, 3]`."""
        return self.color / self.weight.clamp_min(1e-12)[..., None]

    @property
    def depth(self) -> torch.Tensor:
        """The mean depth, which is that of the mean nearness, `[h, w]`."""
        return self.weight / self.nearness.clamp_min(1e-12)

    def over(self, behind: torch.Tensor) -> torch.Tensor:
        """The picture over an image of the opaque meshes, `[h, w, 3]`."""
        passed = self.transmittance[..., None]
        return (1 - passed) * self.mean + passed * behind


@torch.no_grad()
def sums_of(scenes: list[Placed], camera: Camera, limits: torch.Tensor | float = torch.inf) -> Sums:
    """Return the sums of all Gaussians in front of `limits`, depths of opaque meshes, `[h, w]`."""
    limits = torch.as_tensor(limits).expand(camera.height, camera.width)
    sums = torch.zeros(camera.height, camera.width, 5)
    passed = torch.zeros(camera.height, camera.width, 1)  # as a logarithm
    for placed in scenes:
        scene, view = placed.scene, placed.seen_by(camera)
        assert scene.lobes is not None
        inverse = torch.linalg.inv(placed.matrix)
        eye = inverse[:3, :3] @ camera.position + inverse[:3, 3]
        directions = normalize(scene.gaussians.means - eye, dim=1)
        opacities, phi = evaluate_lobes(scene.lobes, directions)
        opacities = placed.opacity * opacities
        g, alpha_min = scene.gaussians, scene.weighting.alpha_min
        options = {"camera": view, "alpha_min": alpha_min, "footprint": scene.footprint}
        projected = project(g.means, g.quats, g.scales, opacities, g.sh, **options)
        weights = scene.weighting.weights(projected.depths, g.scales.amax(1), phi)
        middle, reach = projected.means2d[:, 1], projected.radii[:, 1] + 1
        for first in range(0, camera.height, BAND):
            band = slice(first, min(first + BAND, camera.height))
            touched = (middle + reach > band.start) & (middle - reach < band.stop)
            rows = (projected.visible & touched).nonzero()[:, 0]
            part = Projected(*(column[rows] for column in projected))
            part = part._replace(means2d=part.means2d - torch.tensor([0, first]))
            size = (band.stop - band.start, camera.width)
            edge = scene.footprint.soft_edge
            alphas = pair_alphas(part, opacities[rows], size, alpha_min, soft_edge=edge)
            depths = placed.scale * part.depths
            alphas = torch.where(depths < limits[band].reshape(-1, 1), alphas, 0.0)
            parts = torch.stack([1 / depths, torch.ones_like(depths)], 1)
            added = (alphas * weights[rows]) @ torch.cat([part.colors, parts], 1)
            sums[band] += added.reshape(*size, 5)
            passed[band] += torch.log1p(-alphas).sum(1).reshape(*size, 1)
    return Sums(sums[..., :3], sums[..., 3], sums[..., 4], passed.exp()[..., 0])


def ball_depths(camera: Camera, center: torch.Tensor, radius: float) -> torch.Tensor:
    """Return the depth of a ball at every pixel, infinite beside it, `[h, w]`."""
    rows, columns = torch.meshgrid(
        torch.arange(camera.height) + 0.5, torch.arange(camera.width) + 0.5, indexing="ij"
    )
    k = camera.K
    rays = torch.stack(
        [(columns - k[0, 2]) / k[0, 0], (rows - k[1, 2]) / k[1, 1], torch.ones_like(rows)], 2
    )
    middle = camera.viewmat[:3, :3] @ center + camera.viewmat[:3, 3]
    square = (rays * rays).sum(2)
    half = (rays @ middle) / square
    root = half * half - (middle @ middle - radius * radius) / square
    return torch.where(root > 0, half - root.clamp_min(0).sqrt(), torch.inf)
