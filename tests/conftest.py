"""Fixtures that several test files share."""

import os
from pathlib import Path

import pytest
import torch
from hypothesis import settings

pytest_plugins = [
    "tests.support.browser",
    "tests.support.cuda_on_host",
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
