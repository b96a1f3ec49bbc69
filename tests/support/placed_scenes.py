"""Sort-free scenes among opaque meshes: the definition of what `MobileGSMesh` draws.

The Gaussians of a scene are blended together by Eq. 2; several scenes are layers. Of a Gaussian
counts what lies before the opaque mesh of a pixel. Each scene is moved, turned and scaled in the
world; its weights are those of the scene as it was trained.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import torch
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.render.depth_pass import PASS_BLUR, PASS_LEVEL, visibility
from mobilegs.render.layers import Layer
from mobilegs.render.levels import at_level, level_sizes
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.render.project import (
    Projected,
    jacobian_limits,
    pair_alphas,
    project,
    rotation_matrices,
)
from mobilegs.render.scene import Scene

BAND = 8  # rows of a picture that are computed at once
DEPTH_SPREAD_MIN = 1e-3  # of a Gaussian's depth, so that no edge is harder


@dataclass
class Placed:
    """A scene in the world: its units are `matrix @ (x, y, z, 1)`, of one scale in all directions.

    Attributes:
        opacity: factor of the picture's opacity.
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
    """Sums of a picture's pixels: colours, proximity (1 / sqrt(depth)), its square, weights; T."""

    color: torch.Tensor
    proximity: torch.Tensor
    square: torch.Tensor
    weight: torch.Tensor
    transmittance: torch.Tensor

    @property
    def mean(self) -> torch.Tensor:
        """The mean colour, `[h, w, 3]`."""
        return self.color / self.weight.clamp_min(1e-12)[..., None]

    @property
    def depth(self) -> torch.Tensor:
        """The mean depth, which is that of the mean proximity, `[h, w]`."""
        return (self.weight / self.proximity.clamp_min(1e-12)).square()

    @property
    def layer(self) -> Layer:
        """The layer of these sums."""
        proximity, square = (
            s / self.weight.clamp_min(1e-12) for s in (self.proximity, self.square)
        )
        spread = (square - proximity * proximity).clamp_min(0).sqrt()
        color = (1 - self.transmittance)[..., None] * self.mean
        return Layer(color, self.transmittance, proximity, spread)

    def over(self, behind: torch.Tensor) -> torch.Tensor:
        """The picture over an image of the opaque meshes, `[h, w, 3]`."""
        passed = self.transmittance[..., None]
        return (1 - passed) * self.mean + passed * behind


@torch.no_grad()
def sums_of(scenes: list[Placed], camera: Camera, limits: torch.Tensor | float = torch.inf) -> Sums:
    """Return the sums of all Gaussians in front of `limits`, depths of opaque meshes, `[h, w]`.

    The picture has the opacity of the first scene.
    """
    limits = torch.as_tensor(limits).expand(camera.height, camera.width)
    sums = torch.zeros(camera.height, camera.width, 6)
    passed = torch.zeros(camera.height, camera.width, 1)  # as a logarithm
    for placed in scenes:
        scene, view = placed.scene, placed.seen_by(camera)
        assert scene.lobes is not None
        inverse = torch.linalg.inv(placed.matrix)
        eye = inverse[:3, :3] @ camera.position + inverse[:3, 3]
        directions = normalize(scene.gaussians.means - eye, dim=1)
        opacities, phi = evaluate_lobes(scene.lobes, directions)
        g, alpha_min = scene.gaussians, scene.weighting.alpha_min
        options = {"camera": view, "alpha_min": alpha_min, "footprint": scene.footprint}
        projected = project(g.means, g.quats, g.scales, opacities, g.sh, **options)
        weights = scene.weighting.weights(projected.depths, g.scales.amax(1), phi)
        planes = depth_planes(scene, view, projected)
        moments = None
        if scene.weighting.name == "depth_pass":
            near = limits / placed.scale
            moments = moments_before(near, projected, opacities, planes, scene)
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
            limit = limits[band].reshape(-1, 1) / placed.scale
            alphas = alphas * shares_before(limit, part, planes[rows], size)
            lit = alphas * weights[rows]
            if moments is not None:
                seen = visibility(moments, part.depths, 0, (camera.height, camera.width))
                lit = lit * seen.reshape(*limits.shape, -1)[band].flatten(0, 1)
            proximity = (placed.scale * part.depths).rsqrt()
            parts = torch.stack([proximity, proximity**2, torch.ones_like(proximity)], 1)
            added = lit @ torch.cat([part.colors, parts], 1)
            sums[band] += added.reshape(*size, 6)
            passed[band] += torch.log1p(-alphas).sum(1).reshape(*size, 1)
    proximity, square, weight = sums[..., 3:].unbind(2)
    covered = scenes[0].opacity * (1 - passed.exp()[..., 0])
    return Sums(sums[..., :3], proximity, square, weight, 1 - covered)


def moments_before(
    limits: torch.Tensor,
    projected: Projected,
    opacities: torch.Tensor,
    planes: torch.Tensor,
    scene: Scene,
) -> torch.Tensor:
    """Return the picture of the depth pass in front of `limits`, in units of the scene."""
    rows, alpha_min = projected.visible.nonzero()[:, 0], scene.weighting.alpha_min
    part = Projected(*(column[rows] for column in projected))
    height, width = level_sizes(*limits.shape)[PASS_LEVEL]
    options = {"size": (height, width), "alpha_min": alpha_min}
    every = torch.ones_like(part.visible)
    coarse, faded = at_level(part, opacities[rows], PASS_LEVEL, every, spread=-PASS_BLUR, **options)
    soft_edge = scene.footprint.soft_edge
    alphas = pair_alphas(coarse, faded, (height, width), alpha_min, soft_edge=soft_edge)
    # any pixel of a block will do
    places = [
        (2**PASS_LEVEL * (torch.arange(count) - 1)).clamp(0, most - 1)
        for count, most in zip((height, width), limits.shape, strict=True)
    ]
    limit = limits[places[0]][:, places[1]].reshape(-1, 1)
    sloped = planes[rows] * torch.tensor([2.0**PASS_LEVEL, 2.0**PASS_LEVEL, 1.0])
    alphas = alphas * shares_before(limit, coarse, sloped, (height, width))
    u = coarse.depths.log()
    return (alphas @ torch.stack([torch.ones_like(u), u, u * u], 1)).reshape(height, width, 3)


def depth_planes(scene: Scene, view: Camera, projected: Projected) -> torch.Tensor:
    """Return the depth of each Gaussian along the rays of pixels: a normal distribution, `[n, 3]`.

    Its mean is linear in the pixel: the slope along x and y, then the standard deviation.
    """
    g, rotation = scene.gaussians, view.viewmat[:3, :3]
    axes = rotation @ rotation_matrices(g.quats) * g.scales[:, None, :]
    x, y, z = (g.means @ rotation.T + view.viewmat[:3, 3]).unbind(1)
    x_low, x_high, y_low, y_high = jacobian_limits(view)
    u, v = (x / z).clamp(x_low, x_high)[:, None], (y / z).clamp(y_low, y_high)[:, None]
    row_x = view.K[0, 0] / z[:, None] * (axes[:, 0] - u * axes[:, 2])
    row_y = view.K[1, 1] / z[:, None] * (axes[:, 1] - v * axes[:, 2])
    with_x, with_y = (row_x * axes[:, 2]).sum(1), (row_y * axes[:, 2]).sum(1)
    a, b, c = projected.conics.unbind(1)
    slope_x, slope_y = a * with_x + b * with_y, b * with_x + c * with_y
    variance = axes[:, 2].square().sum(1) - slope_x * with_x - slope_y * with_y
    least = DEPTH_SPREAD_MIN * z
    return torch.stack([slope_x, slope_y, torch.maximum(variance, least * least).sqrt()], 1)


def shares_before(
    limit: torch.Tensor, part: Projected, planes: torch.Tensor, size: tuple[int, int]
) -> torch.Tensor:
    """Return the share of each Gaussian before a depth at each pixel, `[pixels, n]`."""
    rows, columns = torch.meshgrid(torch.arange(size[0]), torch.arange(size[1]), indexing="ij")
    pixels = torch.stack([columns, rows], 2).reshape(-1, 1, 2) + 0.5
    depths = part.depths + ((pixels - part.means2d) * planes[:, :2]).sum(2)
    return torch.sigmoid(1.702 * (limit - depths) / planes[:, 2])


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
