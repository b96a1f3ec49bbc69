"""Random scenes for tests of formats, comparisons of scenes, and the errors of readers."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians


def random_scene(count: int, degree: int, seed: int = 0) -> Gaussians:
    """Return Gaussians as training makes them: small, of any rotation and opacity."""
    g = torch.Generator().manual_seed(seed)
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, (degree + 1) ** 2, 3)]
    means, quats, log_scales, logits, sh = (torch.randn(shape, generator=g) for shape in shapes)
    sh[:, 1:] *= 0.2
    return Gaussians(2 * means, normalize(quats, dim=1), log_scales - 4, 3 * logits, sh)


def matched(found: Gaussians, made: Gaussians) -> Gaussians:
    """Return `found` in the order of `made`, matched by nearest means."""
    rows = torch.cdist(made.means, found.means).argmin(1)
    assert len(rows.unique()) == len(made) == len(found)
    return found.select(rows)


def rotation_error(one: Gaussians, other: Gaussians) -> float:
    """Return the largest distance between unit quaternions, up to their signs."""
    a, b = normalize(one.quats, dim=1), normalize(other.quats, dim=1)
    return float(torch.minimum((a - b).norm(dim=1), (a + b).norm(dim=1)).max())


def max_error(one: torch.Tensor, other: torch.Tensor) -> float:
    """Return the largest absolute difference, and print it."""
    found = float((one.double() - other.double()).abs().max())
    print(f"largest difference {found:.3g}")
    return found


def error_message(read: Callable[[Path], Gaussians], path: Path, data: bytes) -> str:
    """Return the one-line message with which `read` rejects a file of these bytes."""
    path.write_bytes(data)
    with pytest.raises(InputError) as found:
        read(path)
    assert "\n" not in str(found.value)
    return str(found.value)
