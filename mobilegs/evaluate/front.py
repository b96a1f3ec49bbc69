"""Light lost in front of surfaces: the coverage before planes that lie well before them.

The image of sort-free blending hides Gaussians of little weight wherever they stand; meshes, other
scenes and depths show them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.render.scene import Scene

QUANTILES = (0.1, 0.3, 0.5, 0.7)  # of the surfaces' depths, where the planes lie
SOLID = 0.9  # coverage from which a pixel shows a surface
BEHIND = 1.15  # least depth of such a surface, in that of the plane
PIXELS_MIN = 500  # a plane with fewer pixels before surfaces does not count


def front_coverage(scene: Scene, camera: Camera, z: float) -> Float[Tensor, "h w"]:
    """Return the coverage by the Gaussians whose camera-space z is below `z`, in [0, 1]."""
    return scene.render(replace(camera, far=z)).alpha


@torch.inference_mode()
def lost_in_front(
    surfaces: Scene, scenes: Mapping[str, Scene], cameras: Sequence[Camera]
) -> dict[str, float | None]:
    """Return the share of light, 0 to 1, that each scene loses before surfaces, by its name.

    It is the mean over cameras and planes. `surfaces`, a scene blended sorted, has the surfaces:
    pixels of a coverage above 0.9. A plane lies at each of four quantiles of their depths, and
    the surfaces at least 15 % behind it count. None where no plane has enough of them.
    """
    found: dict[str, list[float]] = {name: [] for name in scenes}
    for camera in cameras:
        camera = camera.to(surfaces.gaussians.means.device)
        for z, behind in _planes(surfaces, camera):
            for name, scene in scenes.items():
                found[name].append(float(front_coverage(scene, camera, z)[behind].mean()))
    return {name: sum(of) / len(of) if of else None for name, of in found.items()}


def _planes(surfaces: Scene, camera: Camera) -> list[tuple[float, Bool[Tensor, "h w"]]]:
    """Return the z of each plane, and the pixels whose surfaces count."""
    seen = surfaces.render(camera, depth=True)
    assert seen.depth is not None
    solid, depths = seen.alpha > SOLID, seen.depth / seen.alpha.clamp_min(SOLID)
    if not solid.any():
        return []
    planes = depths[solid].quantile(depths.new_tensor(QUANTILES)).tolist()
    found = [(z, solid & (depths > BEHIND * z)) for z in planes]
    return [(z, behind) for z, behind in found if int(behind.sum()) >= PIXELS_MIN]
