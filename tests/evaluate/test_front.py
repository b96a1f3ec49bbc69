"""Light lost in front of surfaces, measured and learned."""

from dataclasses import replace

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.evaluate.front import lost_in_front
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.train.teacher.init import gaussians_at
from tests.support.scenes import camera
from tests.support.tiny import blobs, cameras

SIDE = 40


def wall(distance: float, opacity: float, far: float = 0.0) -> Gaussians:
    """Return a wall across the view at a distance, of which the right half is `far` farther."""
    x, y = torch.meshgrid(torch.linspace(-4, 4, 25), torch.linspace(-4, 4, 25), indexing="ij")
    z = distance + far * (x > 0)
    points = torch.stack([x, y, z], dim=2).reshape(-1, 3)
    made = gaussians_at(points, torch.full_like(points, 0.5), opacity=opacity, sh_degree=0)
    return replace(made, log_scales=torch.full_like(made.log_scales, -1.2))


def joined(*parts: Gaussians) -> Gaussians:
    names = parts[0].tensors()
    return Gaussians(**{n: torch.cat([part.tensors()[n] for part in parts]) for n in names})


def front_view() -> Camera:
    K = torch.tensor([[40.0, 0, 20], [0, 40, 20], [0, 0, 1]])
    viewmat = look_at(torch.zeros(3), torch.tensor([0.0, 0, 1]), torch.tensor([0.0, -1, 0]))
    return Camera(viewmat, K, SIDE, SIDE)


def test_haze_before_a_surface_is_the_light_that_is_lost():
    surfaces = Scene(wall(4.0, 0.99, far=3.0))
    for opacity in (0.2, 0.6):
        haze = wall(2.0, opacity)
        scenes = {"same": surfaces, "hazy": Scene(joined(wall(4.0, 0.99, far=3.0), haze))}
        scenes["unsorted"] = replace(scenes["hazy"], blend="sortfree")
        found = lost_in_front(surfaces, scenes, [front_view()])
        alone = Scene(haze).render(front_view()).alpha[:, SIDE // 2 + 6 :].mean()
        same = found["same"]
        assert same is not None and same < 0.1
        for name in ("hazy", "unsorted"):
            assert found[name] == pytest.approx(same + (1 - same) * float(alone), abs=0.02), name


def test_without_surfaces_nothing_is_measured():
    empty = Scene(blobs().select(torch.zeros(50, dtype=torch.bool)))
    assert lost_in_front(empty, {"scene": Scene(blobs())}, cameras()) == {"scene": None}
    assert lost_in_front(
        Scene(blobs()), {"scene": Scene(blobs())}, [camera(9, 7).to(dtype=torch.float32)]
    ) == {"scene": None}
