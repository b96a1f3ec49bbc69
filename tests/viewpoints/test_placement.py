"""Bounds of a scene, placed cameras, and cameras between given ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.viewpoints.cameras_json import read_cameras_json
from mobilegs.viewpoints.placement import interpolate_cameras, place_cameras
from mobilegs.viewpoints.scene_bounds import find_scene_bounds
from tests.support.garden import UP, cameras_json, garden


def test_scene_bounds_have_the_centre_and_up_direction() -> None:
    scene = garden()
    found = find_scene_bounds(scene)
    assert (found.center - torch.tensor([5.0, 6.0, 7.0])).abs().max() < 0.3
    assert 0.5 < found.radius < 2
    assert float(found.up @ UP) > 0.99


def test_scene_bounds_ignore_distant_and_infinite_gaussians() -> None:
    scene, before = garden(), find_scene_bounds(garden())
    scene.means[:20] = 1e4 * torch.randn(20, 3, generator=torch.Generator().manual_seed(1))
    scene.log_scales[:20] = 6.0
    scene.means[20] = float("nan")
    found = find_scene_bounds(scene)
    assert (found.center - before.center).norm() < 0.1
    assert float(found.up @ UP) > 0.99
    assert found.weights[20] == 0


def test_up_is_that_of_colmap_if_nothing_is_flat() -> None:
    scene = garden()
    scene.means[:] = torch.randn(len(scene), 3, generator=torch.Generator().manual_seed(2))
    assert torch.equal(find_scene_bounds(scene).up, torch.tensor([0.0, -1.0, 0.0]))


def test_a_given_up_direction_is_used() -> None:
    given = np.array([0.0, 3.0, 4.0])
    assert find_scene_bounds(garden(), up=given).up.tolist() == pytest.approx([0, 0.6, 0.8])


def test_a_scene_without_visible_gaussians_raises_an_error() -> None:
    scene = garden()
    scene.log_scales[:] = float("-inf")
    with pytest.raises(InputError, match="no visible Gaussian"):
        find_scene_bounds(scene)
    scene = garden()
    scene.logit_opacities[:] = -200.0
    with pytest.raises(InputError, match="no visible Gaussian"):
        find_scene_bounds(scene)


def placed(scene: Gaussians, count: int = 24, seed: int = 0):
    generator = torch.Generator().manual_seed(seed)
    bounds = find_scene_bounds(scene)
    return bounds, place_cameras(
        Scene(scene), bounds, count, width=80, height=60, generator=generator
    )


def test_placed_cameras_are_upright_all_around_and_see_the_scene() -> None:
    scene = garden()
    bounds, cameras = placed(scene)
    assert len(cameras) == 24
    for view in cameras:
        assert float(-view.viewmat[1, :3] @ UP) > 0.2  # the image's top is up
        assert view.position[2] > 7 - 0.5  # not below the lawn
        drawn = Scene(scene).render(view)
        assert drawn.alpha.mean() > 0.15
    away = torch.stack([view.position - bounds.center for view in cameras])
    assert torch.atan2(away[:, 1], away[:, 0]).sort().values.diff().max() < 1.7  # all around
    again = placed(scene)[1]
    assert all(torch.equal(a.viewmat, b.viewmat) for a, b in zip(cameras, again, strict=True))
    other = placed(scene, seed=1)[1]
    assert not torch.equal(cameras[0].viewmat, other[0].viewmat)


def test_cameras_keep_the_distance_of_visible_detail() -> None:
    scene, bounds = Scene(garden()), find_scene_bounds(garden())
    assert bounds.detail == pytest.approx(0.05)
    nearest = []
    for detail in (1e-3, 3e-3, 1.0):
        cameras = place_cameras(
            scene,
            replace(bounds, detail=detail * bounds.radius),
            24,
            width=80,
            height=60,
            generator=torch.Generator().manual_seed(0),
        )
        away = torch.stack([view.position for view in cameras]) - bounds.center
        nearest.append(float(away.norm(dim=1).min()) / bounds.radius)
    # a Gaussian covers 1/500 of the width at 433 times its size
    assert 0.6 <= nearest[0] < 1.2 and 1.29 <= nearest[1] < 2 and nearest[2] >= 1.999


def test_cameras_stay_inside_a_wall() -> None:
    """A wall around the garden hides it from outside."""
    scene = garden()
    turn = torch.linspace(0, 6.28, 4000)
    wall = garden(4000)
    high = torch.rand(4000, generator=torch.Generator().manual_seed(3))
    wall.means[:] = torch.stack([5 + 4 * turn.cos(), 6 + 4 * turn.sin(), 7 + 5 * high], 1)
    wall.log_scales[:] = torch.tensor(0.15).log()
    both = Gaussians(
        **{name: torch.cat([t, wall.tensors()[name]]) for name, t in scene.tensors().items()}
    )
    _, cameras = placed(both)
    for view in cameras:
        away = (view.position - torch.tensor([5.0, 6.0, 7.0]))[:2].norm()
        over = view.position[2] > 7 + 4.5
        assert away < 4 or over


def test_a_scene_that_no_camera_sees_raises_an_error() -> None:
    scene = garden()
    scene.logit_opacities[:] = -4.0
    scene.log_scales[:] = torch.tensor(1e-4).log()
    with pytest.raises(InputError, match="--cameras"):
        placed(scene, count=2)


def test_cameras_are_interpolated_between_given_ones(tmp_path: Path) -> None:
    given = read_cameras_json(cameras_json(tmp_path / "cameras.json"))
    bounds = find_scene_bounds(garden())
    generator = torch.Generator().manual_seed(0)
    found = interpolate_cameras(given, bounds, 40, size=160, generator=generator)
    assert len(found) == 40
    assert {(view.width, view.height) for view in found} == {(160, 100)}
    for one, other in zip(given, found, strict=False):
        assert torch.equal(one.viewmat, other.viewmat)
    eyes = torch.stack([view.position for view in found])
    apart = torch.cdist(eyes, torch.stack([view.position for view in given])).amin(1)
    assert 0.5 < apart.max() < 4
    for view in found[6:]:
        turned = view.viewmat[:3, :3]
        assert torch.allclose(turned @ turned.T, torch.eye(3), atol=1e-5)
    few = interpolate_cameras(given, bounds, 3, size=160, generator=generator)
    assert [float(v.position[0]) for v in few] == [float(given[i].position[0]) for i in (0, 2, 5)]
