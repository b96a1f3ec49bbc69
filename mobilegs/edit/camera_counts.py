"""Counts of the cameras that saw each Gaussian, and floaters, which few saw."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import torch
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.mgs.lod import pixel_contributions
from mobilegs.progress_display import Advance
from mobilegs.render.scene import Scene

SIDE = 256  # pixels, longer side of the renders that are counted
SEEN_MIN = 0.02  # sum of blending weights, in pixels of such a render, from which a camera sees
CAMERAS_MAX = 400  # of a capture with more, evenly spread ones are counted
NEIGHBOURS = 8  # nearest Gaussians, whose distances tell whether one is isolated
ISOLATED_FROM = 3.0  # distance to the farthest of them, in the largest standard deviation
SEEN_SHARE_MAX = 0.1  # of the cameras that frame a floater, those that see it
SURFACE_ALPHA = 0.1  # of a pixel, from which it has a surface
AHEAD_DEPTH = 0.7  # of the depth of the surface: nearer Gaussians are ahead of it
AHEAD_SHARE_MIN = 0.6  # of the cameras that frame a floater, those in which it is ahead
WEIGHT_MAX = 5e-4  # of all blending weights, those that floaters may have together


@dataclass(frozen=True)
class CameraCounts:
    """Counts of the cameras that see each Gaussian, and whether it is isolated.

    Attributes:
        seen: number of cameras that saw it, `[n]`: those in whose picture, at a longer side of 256
            pixels, its blending weights add up to at least 0.02 pixels.
        framed: number of cameras whose picture contains its mean, whatever is before it, `[n]`.
        ahead: number of those in which its mean is nearer than 0.7 of the depth at its pixel of
            the Gaussians that are not isolated.
        isolated: whether its eight nearest neighbours reach farther than three standard deviations
            along its longest axis, `[n]`.
        weight: sum of its blending weights over all pictures, in pixels.
        cameras: number of cameras.
    """

    seen: Int[Tensor, "n"]
    framed: Int[Tensor, "n"]
    ahead: Int[Tensor, "n"]
    isolated: Bool[Tensor, "n"]
    weight: Float[Tensor, "n"]
    cameras: int


def count_cameras(
    scene: Scene, cameras: Sequence[Camera], *, progress: Advance | None = None
) -> CameraCounts:
    """Render the scene for each camera, at most 400 of them, on the device of the scene.

    `progress` is called with the cameras that are done and their number. At least one is needed.
    """
    every = -(-len(cameras) // CAMERAS_MAX)
    used = cameras[::every]
    means = scene.gaussians.means
    isolated = _isolated(scene)
    surface = _selected(scene, ~isolated)
    seen = torch.zeros(len(means), dtype=torch.int32)
    framed, ahead = torch.zeros_like(seen), torch.zeros_like(seen)
    weight = torch.zeros(len(means))
    for number, camera in enumerate(used):
        small = _reduced(camera).to(means.device, torch.float32)
        shares = pixel_contributions(scene, [small]).cpu()
        seen += shares >= SEEN_MIN
        weight += shares.clamp_min(0)
        inside, before = _depth_order(means, surface, small)
        framed += inside
        ahead += before
        if progress is not None:
            progress(number + 1, len(used))
    return CameraCounts(seen, framed, ahead, isolated, weight, len(used))


@torch.no_grad()
def floaters(counts: CameraCounts) -> Bool[Tensor, "n"]:
    """Return which Gaussians float: isolated, and hardly seen or before what most cameras see.

    A Gaussian floats if it is isolated and either at most a tenth of the cameras that have it in
    their picture see it, or it is before the scene in most of them. The least weighted
    come first, up to a share of 0.0005 of all blending weights, so that what the cameras see hardly
    changes.
    """
    framed = counts.framed.clamp_min(1)
    hidden = counts.seen <= SEEN_SHARE_MAX * framed
    before = counts.ahead >= AHEAD_SHARE_MIN * framed
    candidates = counts.isolated & (counts.framed > 0) & (hidden | before)
    rows = candidates.nonzero()[:, 0]
    rows = rows[counts.weight[rows].argsort(stable=True)]
    total = counts.weight.double().sum()
    few = counts.weight[rows].double().cumsum(0) <= WEIGHT_MAX * total
    floating = torch.zeros_like(candidates)
    floating[rows[few]] = True
    return floating


def _reduced(camera: Camera) -> Camera:
    """Return the camera with a longer side of at most 256 pixels."""
    factor = min(1.0, SIDE / max(camera.width, camera.height))
    return camera.resized(*(max(1, round(factor * s)) for s in (camera.width, camera.height)))


@torch.no_grad()
def _isolated(scene: Scene) -> Bool[Tensor, "n"]:
    gaussians = scene.gaussians
    if len(gaussians) <= NEIGHBOURS:
        return torch.zeros(len(gaussians), dtype=torch.bool)
    means = gaussians.means.cpu().double().numpy()
    distances, _ = KDTree(means).query(means, k=NEIGHBOURS + 1, workers=-1)
    sizes = gaussians.scales.amax(1).cpu().double().numpy()
    return torch.from_numpy(distances[:, -1] > ISOLATED_FROM * sizes)


def _selected(scene: Scene, rows: Bool[Tensor, "n"]) -> Scene:
    rows = rows.to(scene.gaussians.means.device)
    lobes = None if scene.lobes is None else scene.lobes[rows]
    return replace(scene, gaussians=scene.gaussians.select(rows), lobes=lobes)


@torch.no_grad()
def _depth_order(
    means: Float[Tensor, "n 3"], surface: Scene, camera: Camera
) -> tuple[Bool[Tensor, "n"], Bool[Tensor, "n"]]:
    """Return which means lie in the picture, and which of them clearly before the surface."""
    rendered = surface.render(camera, depth=True)
    assert rendered.depth is not None
    alpha = rendered.alpha.cpu()
    depth = torch.where(
        alpha < SURFACE_ALPHA, 0, rendered.depth.cpu() / alpha.clamp_min(SURFACE_ALPHA)
    )
    points = (means @ camera.viewmat[:3, :3].T + camera.viewmat[:3, 3]).cpu()
    z = points[:, 2]
    pixels = (points @ camera.K.cpu().T)[:, :2] / z[:, None].clamp_min(1e-9)
    column, row = pixels.floor().T
    inside = (z > camera.near) & (column >= 0) & (column < camera.width)
    inside &= (row >= 0) & (row < camera.height)
    before = torch.zeros_like(inside)
    before[inside] = z[inside] < AHEAD_DEPTH * depth[row[inside].long(), column[inside].long()]
    return inside, before
