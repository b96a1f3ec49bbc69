"""Plain scenes for tests of formats: made at random, and compared as far as a format keeps them."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians


def plain_scene(count: int, degree: int, seed: int = 0) -> Gaussians:
    """Gaussians as training leaves them: small, in any direction, from clear to solid."""
    g = torch.Generator().manual_seed(seed)
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, (degree + 1) ** 2, 3)]
    means, quats, log_scales, logits, sh = (torch.randn(shape, generator=g) for shape in shapes)
    sh[:, 1:] *= 0.2
    return Gaussians(2 * means, normalize(quats, dim=1), log_scales - 4, 3 * logits, sh)


def matched(found: Gaussians, made: Gaussians) -> Gaussians:
    """`found` in the order of `made`: every position's nearest."""
    rows = torch.cdist(made.means, found.means).argmin(1)
    assert len(rows.unique()) == len(made) == len(found)
    return found.select(rows)


def turn_between(one: Gaussians, other: Gaussians) -> float:
    """The largest distance between quaternions, of which both signs mean the same."""
    a, b = normalize(one.quats, dim=1), normalize(other.quats, dim=1)
    return float(torch.minimum((a - b).norm(dim=1), (a + b).norm(dim=1)).max())


def worst(one: torch.Tensor, other: torch.Tensor) -> float:
    """The largest difference, printed."""
    found = float((one.double() - other.double()).abs().max())
    print(f"largest difference {found:.3g}")
    return found


def refusal_of(read: Callable[[Path], Gaussians], path: Path, data: bytes) -> str:
    """The sentence by which a file with these bytes is refused."""
    path.write_bytes(data)
    with pytest.raises(InputError) as found:
        read(path)
    assert "\n" not in str(found.value)
    return str(found.value)
