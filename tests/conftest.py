"""Fixtures that several test files share."""

import os
from pathlib import Path

import pytest
import torch
from hypothesis import settings

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset, Frame
from mobilegs.data.demo.capture import write_capture
from mobilegs.render.scene import Scene
from mobilegs.train.teacher.init import gaussians_at

pytest_plugins = [
    "tests.support.browser",
    "tests.support.gpus",
    "tests.support.quantized_scenes",
    "tests.support.runs",
    "tests.support.selection",
    "tests.support.tiny",
    "tests.support.visitor",
]

# examples are the same in every run, and a busy machine is no failure
settings.register_profile("mobilegs", deadline=None, derandomize=True)
settings.load_profile("mobilegs")


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return more processes than there are cores: tests wait for browsers, thorough ones longer."""
    return (os.cpu_count() or 1) + (2 if config.getoption("--thorough") else 1)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real captures and scenes that `MOBILEGS_DATA` names."""
    folder = os.environ.get("MOBILEGS_DATA")
    if not folder:
        pytest.skip("needs real captures (MOBILEGS_DATA)")
    if not Path(folder).is_dir():
        pytest.fail(f"MOBILEGS_DATA is {folder}, which is no folder")
    return Path(folder)


@pytest.fixture
def generator() -> torch.Generator:
    """Random numbers, the same ones for every test and run."""
    return torch.Generator().manual_seed(0)


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine photos, 24 x 20, of fifty blobs, as COLMAP would leave them."""
    generator = torch.Generator().manual_seed(5)
    points = torch.randn(50, 3, generator=generator) * 0.5
    colors = torch.rand(50, 3, generator=generator)
    truth = Scene(gaussians_at(points, colors, opacity=0.8, sh_degree=0))
    K = torch.tensor([[28.0, 0, 12], [0, 28, 10], [0, 0, 1]])
    frames = []
    for index in range(9):
        eye = torch.randn(3, generator=generator)
        viewmat = look_at(3 * eye / eye.norm(), torch.zeros(3), torch.tensor([0.0, 0, 1]))
        camera = Camera(viewmat, K, 24, 20)
        pixels = (truth.render(camera).image.clamp(0, 1) * 255).round().to(torch.uint8)
        frames.append(Frame(f"view_{index}.png", camera, pixels=pixels))
    folder = tmp_path_factory.mktemp("capture") / "blobs"
    dataset = Dataset(
        name="blobs",
        train=frames[1:],
        test=frames[:1],
        points=points,
        colors=colors,
        extent=3.0,
        center=torch.zeros(3),
        background=torch.zeros(3),
        near=0.2,
    )
    write_capture(folder, dataset)
    return folder
