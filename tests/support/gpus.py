"""Marks of tests that render with wgpu: `GPU`, or `GPU_FLOAT32` for full precision."""

from functools import cache

import pytest

from mobilegs.errors import InputError
from mobilegs.view.wgpu_renderer import usable_gpu

GPU = pytest.mark.usefixtures("gpu")
GPU_FLOAT32 = pytest.mark.usefixtures("gpu_float32")


@cache
def renders(*, full_precision: bool) -> bool:
    """Return True if this machine renders with wgpu; in software is enough."""
    try:
        usable_gpu(False, full_precision)
    except InputError:
        return False
    return True


def precisions() -> list[bool]:
    """Return the values of `full_precision` that the GPU of this machine renders with."""
    return [value for value in (False, True) if renders(full_precision=value)]


@pytest.fixture(scope="session")
def gpu() -> None:
    """Skip the test on a machine without a GPU that renders; finding out takes seconds."""
    if not renders(full_precision=False):
        pytest.skip("needs a GPU renderer (make drivers)")


@pytest.fixture(scope="session")
def gpu_float32() -> None:
    """Skip the test on a machine without a GPU that renders 32-bit floats."""
    if not renders(full_precision=True):
        pytest.skip("needs a GPU renderer of 32-bit floats (make drivers)")
