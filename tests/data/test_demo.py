"""The demo capture: consistent geometry, determinism, and writing to disk."""

import pytest
import torch

from mobilegs.data import Dataset, Frame, load_capture, load_view
from mobilegs.data.demo.capture import (
    DISTANT,
    OUTLIERS,
    POINT_NOISE,
    demo_cameras,
    demo_capture,
    write_capture,
)
from mobilegs.data.demo.scene import DemoScene


def small_capture(seed: int = 0) -> Dataset:
    return demo_capture(views=16, width=48, height=32, points=600, seed=seed)


def pixels(frame: Frame) -> torch.Tensor:
    assert frame.pixels is not None
    return frame.pixels


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """The ray tracer's operations are too short to run in parallel."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def dataset():
    return small_capture()


@pytest.fixture(scope="module")
def scene():
    return DemoScene(0)


@pytest.mark.thorough
def test_the_seed_decides_the_capture(dataset):
    again, other = small_capture(), small_capture(seed=1)
    assert torch.equal(dataset.points, again.points)
    assert torch.equal(dataset.colors, again.colors)
    for one, two, three in zip(dataset.train, again.train, other.train, strict=True):
        assert torch.equal(pixels(one), pixels(two))
        assert not torch.equal(pixels(one), pixels(three))


def test_the_number_of_threads_is_restored():
    torch.set_num_threads(2)
    try:
        demo_capture(views=2, width=12, height=8, points=20)
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(1)


def test_every_eighth_view_is_held_back(dataset):
    assert [frame.name for frame in dataset.test] == ["view_000.png", "view_008.png"]
    assert len(dataset.train) == 14


def test_a_written_capture_is_read_back_unchanged(dataset, tmp_path):
    write_capture(tmp_path / "sample", dataset)
    loaded = load_capture(tmp_path / "sample")
    assert loaded.name == "sample"
    assert torch.equal(loaded.points, dataset.points)
    assert torch.equal(loaded.colors, dataset.colors)
    assert loaded.extent == pytest.approx(dataset.extent, rel=1e-6)
    for split in ("train", "test"):
        for read, made in zip(getattr(loaded, split), getattr(dataset, split), strict=True):
            assert read.name == made.name
            assert torch.equal(read.camera.K, made.camera.K)
            torch.testing.assert_close(read.camera.viewmat, made.camera.viewmat, atol=1e-6, rtol=0)
            assert torch.equal(load_view(read).image, load_view(made).image)


def test_depths_of_two_views_agree(scene):
    """Points from the depth of one view have the right depth in the next view."""
    here, there = demo_cameras(56, 96, 64)[20:22]
    _, depth = scene.picture(here, samples=1)
    rows, columns = torch.meshgrid(torch.arange(64), torch.arange(96), indexing="ij")
    rays = torch.stack([columns + 0.5, rows + 0.5, torch.ones(64, 96)]).reshape(3, -1)
    hit = depth.flatten().isfinite()
    local = torch.linalg.inv(here.K) @ rays[:, hit] * depth.flatten()[hit]
    world = here.viewmat[:3, :3].T @ (local - here.viewmat[:3, 3:])
    toward = world - there.position[:, None]
    _, distance = scene.rays(there.position[:, None].expand_as(toward), toward)
    # 1: the same point; less: it is occluded; more: a ray misses an edge by rounding
    assert (distance > 1.002).float().mean() < 1e-3
    assert (distance > 0.998).float().mean() > 0.8


def test_bounding_windows_cut_nothing_off(scene):
    """Rendering per window gives the same image as testing every ray against all solids."""
    for camera in demo_cameras(7, 60, 40)[::3]:
        image, depth = scene.picture(camera, samples=1)
        rows, columns = torch.meshgrid(torch.arange(40), torch.arange(60), indexing="ij")
        pixels = torch.stack([columns + 0.5, rows + 0.5, torch.ones(40, 60)]).reshape(3, -1)
        rays = camera.viewmat[:3, :3].T @ (torch.linalg.inv(camera.K) @ pixels)
        color, distance = scene.rays(camera.position[:, None].expand_as(rays), rays)
        same = torch.isclose(distance, depth.flatten(), rtol=1e-3)
        assert same.float().mean() > 0.998  # edges may differ
        assert (color - image.reshape(-1, 3).T).abs().mean() < 2e-3


def test_points_have_the_stated_noise(dataset, scene):
    count = len(dataset.points)
    assert count == 600
    eyes = torch.stack([frame.camera.position for frame in dataset.train])
    distant = ((dataset.points - dataset.center).norm(dim=1) > 6).float().mean()
    assert distant == pytest.approx(DISTANT, abs=0.02)
    # the camera that saw a point is unknown: take the one that fits best
    toward = (dataset.points[:, None] - eyes).reshape(-1, 3).T
    length = toward.norm(dim=0)
    origins = eyes.repeat(count, 1).T.contiguous()
    _, distance = scene.rays(origins, toward / length)
    best = (distance - length).abs().reshape(count, -1).amin(1)
    on_surface = (best < 5 * POINT_NOISE).float().mean()
    assert on_surface > 1 - DISTANT - OUTLIERS - 0.05
    assert 0.1 * POINT_NOISE < best[best < 5 * POINT_NOISE].mean() < 2 * POINT_NOISE


def test_the_lacquered_ball_is_view_dependent(scene):
    """A point of the ball has different colours from different positions."""
    point = torch.tensor([0.0, -0.1, 1.0])
    eyes = torch.tensor([[2.0, -2.0, 3.0], [-2.5, -1.0, 2.0], [1.0, 3.0, 2.0]]).T
    color, distance = scene.rays(eyes, point[:, None] - eyes)
    assert (distance - 1).abs().max() < 1e-3
    assert (color[:, :1] - color[:, 1:]).abs().max() > 0.05


def test_the_background_is_at_infinity(scene):
    rays = torch.tensor([[1.0, 0.2, 0.3], [0.3, 1.0, -0.2]]).T
    near, _ = scene.rays(torch.full((3, 2), 20.0), rays)
    far, distance = scene.rays(torch.full((3, 2), 500.0), rays)
    assert distance.isinf().all() and torch.equal(near, far)


def test_images_are_finite_and_varied(dataset):
    for frame in [*dataset.train, *dataset.test]:
        image = load_view(frame).image
        assert image.isfinite().all() and image.std() > 0.1
