"""Initial Gaussians."""

import math

import numpy as np
import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import FAR_POINTS, Dataset, Frame, assemble
from mobilegs.train.teacher.init import (
    gaussians_at,
    initial_gaussians,
    neighbor_distances,
    random_points,
)


def ring(count: int, radius: float, *, outwards: bool = False) -> list[Camera]:
    """Cameras on a circle, 40 degrees wide, that look at its centre or away from it."""
    K = torch.tensor([[50 / math.tan(math.radians(20)), 0, 50], [0, 137.4, 40], [0, 0, 1]])
    cameras = []
    for index in range(count):
        angle = 2 * math.pi * index / count
        eye = torch.tensor([math.cos(angle), math.sin(angle), 0.1]) * radius
        target = 2 * eye if outwards else torch.zeros(3)
        cameras.append(Camera(look_at(eye, target, torch.tensor([0.0, 0, 1])), K, 100, 80))
    return cameras


def dataset(points: torch.Tensor) -> Dataset:
    frames = [Frame(f"{i}", camera) for i, camera in enumerate(ring(8, 4.0))]
    return Dataset(
        name="ring",
        train=frames,
        test=frames[:1],
        points=points,
        colors=torch.rand(len(points), 3, generator=torch.Generator().manual_seed(1)),
        extent=4.4,
        center=torch.zeros(3),
        background=torch.zeros(3),
        near=0.2,
    )


def start(points: torch.Tensor, count: int, seed: int = 0):
    generator = torch.Generator().manual_seed(seed)
    return initial_gaussians(
        dataset(points), count=count, opacity=0.1, sh_degree=3, generator=generator
    )


def test_the_size_is_the_root_mean_square_distance_to_three_neighbours() -> None:
    points = torch.tensor([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3], [50, 0, 0]])
    expected = math.sqrt((1 + 4 + 9) / 3)
    assert neighbor_distances(points)[0].item() == pytest.approx(expected)


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_points_get_a_finite_size(count: int) -> None:
    distances = neighbor_distances(torch.arange(3.0 * count).reshape(count, 3))
    assert distances.shape == (count,) and distances.isfinite().all() and (distances > 0).all()


def test_points_on_top_of_each_other_get_a_size() -> None:
    assert (neighbor_distances(torch.zeros(9, 3)) > 0).all()


def test_a_gaussian_has_the_colour_of_its_point_and_the_given_opacity() -> None:
    colors = torch.rand(5, 3, generator=torch.Generator().manual_seed(0))
    made = gaussians_at(torch.randn(5, 3), colors, opacity=0.1, sh_degree=3)
    torch.testing.assert_close(0.5 + 0.28209479 * made.sh[:, 0], colors)
    assert made.sh.shape == (5, 16, 3) and (made.sh[:, 1:] == 0).all()
    torch.testing.assert_close(made.opacities, torch.full((5,), 0.1))
    assert made.quats.tolist() == [[1, 0, 0, 0]] * 5


def test_too_many_points_are_sampled() -> None:
    points = torch.arange(300.0).reshape(100, 3)
    chosen = start(points, 40).means
    assert len(chosen) == 40 and len(chosen.unique(dim=0)) == 40
    assert not torch.equal(chosen, start(points, 40, seed=1).means)
    assert torch.equal(chosen, start(points, 40).means)


def test_a_capture_without_points_gets_random_ones() -> None:
    made = start(torch.zeros(0, 3), 50)
    assert len(made) == 50 and (made.sh[:, 0] == 0).all()


def random_for(cameras: list[Camera], extent: float) -> torch.Tensor:
    return random_points(
        cameras,
        torch.zeros(3),
        extent,
        count=4000,
        generator=torch.Generator().manual_seed(0),
    )


def test_cameras_around_an_object_give_the_cube_that_they_see() -> None:
    points = random_for(ring(20, 4.0), 4.4)
    half = 4.02 * math.tan(math.radians(20)) * 0.8  # the narrower side is 80 of 100 px
    assert points.abs().max().item() == pytest.approx(half, rel=0.02)


def test_cameras_that_look_outwards_give_a_cube_around_them() -> None:
    points = random_for(ring(20, 1.0, outwards=True), 1.1)
    assert 3 < points.abs().max() < 5 and (points.norm(dim=1) > 1.1).float().mean() > 0.9


@pytest.mark.parametrize("distance", [0.9, 1.5, 200.0, 1e6, 1e30, math.nan])
def test_far_points_change_no_measure_and_no_other_gaussian(
    distance: float, caplog: pytest.LogCaptureFixture
) -> None:
    """One in 200 points at `distance` times the limit, on all sides."""
    generator = np.random.default_rng(0)
    points, colors = generator.normal(size=(400, 3)), generator.random((400, 3))
    away = generator.normal(size=(2, 3))
    limit = FAR_POINTS * np.median(np.linalg.norm(points - [0, 0, 0.4], axis=1))
    away *= distance * limit / np.linalg.norm(away, axis=1, keepdims=True)
    frames = [Frame(f"{i}", camera) for i, camera in enumerate(ring(8, 4.0))]

    def opened(*far: np.ndarray) -> Dataset:
        every = np.concatenate([points, *far])
        shades = np.concatenate([colors, *(0 * part for part in far)])
        return assemble(
            "ring", frames[1:], frames[:1], points=every, colors=shades, background=(0.0, 0.0, 0.0)
        )

    plain, found = opened(), opened(away)
    assert (found.extent, found.near) == (plain.extent, plain.near)
    assert torch.equal(found.center, plain.center)
    kept = 2 if distance < 1 else 0
    assert len(found.points) == len(plain.points) + kept
    said = "2 of 402 sparse points are left out: they are more than 100 times as far" in caplog.text
    assert said == (1 < distance < math.inf)
    one, other = (
        initial_gaussians(each, count=1000, opacity=0.1, sh_degree=0, generator=torch.Generator())
        for each in (plain, found)
    )
    assert torch.equal(one.means, other.means[: len(one)])
    assert torch.equal(one.log_scales, other.log_scales[: len(one)])
