"""Fixtures that several test files share."""

import os
from pathlib import Path

import pytest
import torch
from hypothesis import settings

# examples are the same in every run, and a busy machine is no failure
settings.register_profile("mobilegs", deadline=None, derandomize=True)
settings.load_profile("mobilegs")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real captures and scenes that `MOBILEGS_DATA` names."""
    folder = os.environ.get("MOBILEGS_DATA")
    if not folder:
        pytest.skip("MOBILEGS_DATA names no folder of real captures")
    if not Path(folder).is_dir():
        pytest.fail(f"MOBILEGS_DATA is {folder}, which is no folder")
    return Path(folder)


@pytest.fixture
def generator() -> torch.Generator:
    """Random numbers, the same ones for every test and run."""
    return torch.Generator().manual_seed(0)
