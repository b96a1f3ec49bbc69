"""The demo capture: consistent geometry, determinism, and writing to disk."""

import pytest
import torch

from mobilegs.data import Frame, load_capture, load_view
from mobilegs.data.demo.capture import (
    demo_cameras,
    demo_capture,
    write_capture,
)
from mobilegs.data.demo.scene import DemoScene


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
    return demo_capture(views=16, width=48, height=32, points=600)


@pytest.fixture(scope="module")
def scene():
    return DemoScene(0)


def test_the_seed_decides_the_capture():
    one, again, other = (
        demo_capture(views=2, width=24, height=16, points=20, seed=seed) for seed in (0, 0, 1)
    )
    assert torch.equal(one.points, again.points) and torch.equal(one.colors, again.colors)
    assert torch.equal(pixels(one.train[0]), pixels(again.train[0]))
    assert not torch.equal(pixels(one.train[0]), pixels(other.train[0]))


def test_the_number_of_threads_is_restored():
    torch.set_num_threads(2)
    try:
        demo_capture(views=2, width=12, height=8, points=20)
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(1)


def test_a_written_capture_is_read_back_unchanged(dataset, tmp_path):
    assert [frame.name for frame in dataset.test] == ["view_000.png", "view_008.png"]
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
