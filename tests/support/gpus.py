"""Marks of tests that render with wgpu: `GPU`, or `GPU_FLOAT32` for full precision."""

from functools import cache

import pytest

from mobilegs.errors import InputError
from mobilegs.view.wgpu_renderer import usable_gpu


@cache
def renders(*, full_precision: bool) -> bool:
    """Return True if this machine renders with wgpu; in software is enough."""
    try:
        usable_gpu(False, full_precision)
    except InputError:
        return False
    return True


GPU = pytest.mark.skipif(
    not renders(full_precision=False), reason="needs a GPU renderer (make drivers)"
)
GPU_FLOAT32 = pytest.mark.skipif(
    not renders(full_precision=True),
    reason="needs a GPU renderer of 32-bit floats (make drivers)",
)
