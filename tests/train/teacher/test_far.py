"""Gaussians on a far sphere."""

from dataclasses import replace
from typing import Literal

import pytest
import torch

from mobilegs.data.dataset import Dataset, Frame, load_view
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import CLASSIC
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.far import far_points, hidden_far
from mobilegs.train.teacher.init import gaussians_at, initial_gaussians
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.train.teacher.test_init import dataset, ring


def test_far_gaussians_have_the_colours_that_photos_show() -> None:
    """The upper half of the photos is blue, the lower half green; one half of the sphere unseen."""
    pixels = torch.zeros(80, 100, 3, dtype=torch.uint8)
    pixels[:40, :, 2], pixels[40:, :, 1] = 255, 255
    cameras = [camera for camera in ring(8, 4.0, outwards=True) if camera.position[0] > 0]
    frames = [Frame(f"{i}", camera, pixels=pixels) for i, camera in enumerate(cameras)]
    scene = replace(dataset(torch.randn(500, 3)), train=frames)
    points, colors = far_points(scene.train, scene.center, scene.extent, count=2000)
    torch.testing.assert_close(points.norm(dim=1), torch.full((len(points),), 20 * 4.4))
    assert 100 < len(points) < 1000
    for point, color in zip(points[::10], colors[::10], strict=True):
        seen = []
        for camera in cameras:
            x, y, z = camera.viewmat[:3, :3] @ point + camera.viewmat[:3, 3]
            row = float(y / z * camera.K[1, 1] + camera.K[1, 2])
            column = float(x / z * camera.K[0, 0] + camera.K[0, 2])
            if z > 0 and 0 <= column < 100 and 0 <= row < 80 and abs(row - 40) > 2:
                seen.append([0.0, 0.0, 1.0] if row < 40 else [0.0, 1.0, 0.0])
        if seen:
            torch.testing.assert_close(color, torch.tensor(seen).mean(0), atol=0.51, rtol=0)
            assert color[0] == 0 and color.sum() == pytest.approx(1)
    options = {"opacity": 0.1, "sh_degree": 1, "generator": torch.Generator()}
    made = initial_gaussians(scene, count=300, far=200, **options)
    far = made.means.norm(dim=1) > 80
    assert len(made) == 300 and 5 < int(far.sum()) <= 150
    over = replace(scene, train=[replace(frame, alpha="over") for frame in frames])
    assert not (initial_gaussians(over, count=300, far=200, **options).means.norm(dim=1) > 80).any()


def outwards() -> Dataset:
    """Grey photos of eight cameras that look away from each other."""
    grey = torch.full((80, 100, 3), 128, dtype=torch.uint8)
    cameras = ring(8, 1.0, outwards=True)
    frames = [Frame(f"{i}", camera, pixels=grey) for i, camera in enumerate(cameras)]
    return replace(dataset(torch.randn(300, 3)), train=frames, extent=1.1)


def walled(scene: Dataset, opacity: float) -> Gaussians:
    """300 far Gaussians, and a wall of 4,000 before those with x > 0."""
    far, _ = far_points(scene.train, scene.center, scene.extent, count=600)
    number = torch.arange(8000) + 0.5
    polar, turn = (1 - number / 4000).acos(), 2.399963 * number
    around = torch.stack([polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()], dim=1)
    wall = 6 * around[around[:, 0] > 0]
    points = torch.cat([far, wall])
    return gaussians_at(points, torch.rand(len(points), 3), opacity=opacity, sh_degree=1)


def test_far_gaussians_behind_a_wall_are_hidden() -> None:
    scene = outwards()
    made = walled(scene, 0.9)
    far = made.means.norm(dim=1) > 20
    hidden = hidden_far(made, scene, CLASSIC, 0.1)
    assert not hidden[~far].any()
    side = made.means[:, 0] / made.means.norm(dim=1)
    assert hidden[far & (side > 0.3)].all() and (far & (side > 0.3)).sum() > 20
    assert not hidden[far & (side < -0.3)].any() and (far & (side < -0.3)).sum() > 20


def test_a_translucent_wall_leaves_a_share_of_visibility() -> None:
    scene = outwards()
    faint = walled(scene, 0.02)
    behind = (faint.means[:, 0] > 8) & (faint.means.norm(dim=1) > 20)
    assert not hidden_far(faint, scene, CLASSIC, 0.1)[behind].any()
    assert hidden_far(faint, scene, CLASSIC, 1.0)[behind].all()


@pytest.mark.parametrize("strategy", ["clone_split", "mini_splatting", "mcmc", "fixed"])
def test_a_teacher_removes_hidden_far_gaussians_once(
    strategy: Literal["clone_split", "mini_splatting", "mcmc", "fixed"],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = outwards()
    removed = []

    def hidden(gaussians: Gaussians, given: Dataset, footprint: object, least: float):
        assert given is scene and least == 0.2
        removed.append(len(gaussians))
        return torch.arange(len(gaussians)) % 3 == 0

    monkeypatch.setattr("mobilegs.train.teacher.trainer.hidden_far", hidden)
    config = TeacherConfig(
        steps=20,
        init_splats=200,
        max_splats=300,
        far_splats=100,
        far_visibility=0.2,
        densify=DensifyConfig(strategy=strategy, min_interval=3, prune_scale=0.0),
    )
    teacher = Teacher(config, scene, seed=0, device=torch.device("cpu"))
    counts = []
    for step in range(12):
        index = step % len(scene.train)
        teacher.advance([(index, load_view(scene.train[index]))])
        counts.append(teacher.count)
    assert len(removed) == 1 and counts[5] == removed[0] * 2 // 3


def test_a_run_that_is_shortened_keeps_the_check() -> None:
    config = TeacherConfig(steps=100, far_splats=10, far_visibility=0.2)
    teacher = Teacher(config, outwards(), seed=0, device=torch.device("cpu"))
    teacher.set_steps(20, 0)
    assert teacher.steps == max(31, teacher.strategy.last_event + 1)
