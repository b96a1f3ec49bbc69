"""Fragments: how many Gaussians a renderer evaluates at a pixel, which decides a frame's time."""

import math
import statistics
from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.render.levels import LEVELS, at_level, choose_levels, level_sizes
from mobilegs.render.lobes import constant_lobes, evaluate_lobes
from mobilegs.render.project import ALPHA_MIN, Projected, project
from mobilegs.render.scene import Scene


@torch.no_grad()
def fragments_per_pixel(scene: Scene, camera: Camera, *, level_sigma: float = 0.0) -> list[float]:
    """Return the mean number of fragments per pixel of the image that each level takes.

    A fragment is a pixel of a level's target inside of a Gaussian's ellipse. Areas stand in for
    counts of pixels; that of an ellipse across the border counts by the share of its box that lies
    inside. With `level_sigma` 0 and for sorted scenes all are of level 0. The paper's network is
    left out: its scenes count with their base opacities.
    """
    gaussians, sortfree = scene.gaussians, scene.blend == "sortfree"
    lobes = constant_lobes(gaussians.logit_opacities) if scene.lobes is None else scene.lobes
    opacities, phi = evaluate_lobes(lobes, normalize(gaussians.means - camera.position, dim=1))
    alpha_min = scene.weighting.alpha_min if sortfree else ALPHA_MIN
    shapes = (gaussians.means, gaussians.quats, gaussians.scales, opacities, gaussians.sh[:, :1])
    projected = project(*shapes, camera=camera, alpha_min=alpha_min, footprint=scene.footprint)
    weights = torch.ones_like(opacities)
    if not sortfree:
        level_sigma = 0.0
    if level_sigma:
        s_max = torch.where(projected.visible, gaussians.scales.amax(1), 0.0)
        depths = projected.depths
        weights = torch.where(projected.visible, scene.weighting.weights(depths, s_max, phi), 0.0)
    levels = choose_levels(projected, weights, level_sigma)
    sizes = level_sizes(camera.height, camera.width)
    pixels = camera.height * camera.width
    means = []
    for level in range(LEVELS if level_sigma else 1):
        part, faded = at_level(
            projected, opacities, level, levels == level, size=sizes[level], alpha_min=alpha_min
        )
        means.append(float(_areas(part, faded / alpha_min, sizes[level]).sum()) / pixels)
    return means


def mean_fragments(
    scene: Scene, cameras: Sequence[Camera], *, level_sigma: float = 0.0
) -> list[float]:
    """Return the means of `fragments_per_pixel` over cameras."""
    device = scene.gaussians.means.device
    rows = [
        fragments_per_pixel(scene, camera.to(device), level_sigma=level_sigma) for camera in cameras
    ]
    return [statistics.fmean(values) for values in zip(*rows, strict=True)]


def _areas(part: Projected, excess: Tensor, size: tuple[int, int]) -> Tensor:
    """Return the areas of the ellipses inside of a target; `excess` is opacity / alpha_min."""
    a, b, c = part.conics.unbind(1)
    reach = 2 * torch.log(excess.clamp_min(1))
    areas = math.pi * reach / (a * c - b * b).sqrt()
    low, high = part.means2d - part.radii, part.means2d + part.radii
    sides = torch.tensor([size[1], size[0]], device=low.device)
    inside = (torch.minimum(high, sides) - low.clamp_min(0)).clamp_min(0).prod(1)
    shares = inside / (high - low).prod(1).clamp_min(1e-9)
    return torch.where(part.visible, areas * shares, 0.0)
