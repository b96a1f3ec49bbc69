"""Range checks of a scene's numbers, shared by the encoder and the header's parser."""

from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor

from mobilegs.camera import Camera
from mobilegs.errors import InputError
from mobilegs.mgs.container import short_text
from mobilegs.mgs.positions import PositionGrid
from mobilegs.render import Footprint, Weighting
from mobilegs.render.sortfree import WEIGHTINGS

VIEWS_MAX = 64
SIDE_MAX = 1 << 16  # of a view, in pixels
META_MAX = 64
TEXT_MAX = 4096
WORLD_MIN, WORLD_MAX = 1e-20, 1e20  # lengths: the largest float16 position stays finite in float32


def check_ranges(
    grid: PositionGrid, weighting: Weighting, background: Float[Tensor, "3"], near: float
) -> None:
    """Raise `InputError` unless a renderer can use a scene's numbers."""
    if not (grid.center.abs() <= WORLD_MAX).all() or not WORLD_MIN <= grid.radius <= WORLD_MAX:
        raise InputError("the scene's centre or radius is out of range")
    if not 0 < near <= WORLD_MAX:
        raise InputError(f"the scene's near plane {near} is out of range")
    if not ((background >= 0) & (background <= 1)).all():
        raise InputError("the scene's background colour lies outside of [0, 1]")
    if weighting.name not in WEIGHTINGS:
        raise InputError(
            f"a .mgs file cannot hold the weighting '{weighting.name}': use one of "
            f"{', '.join(WEIGHTINGS)}"
        )
    if not 0 < weighting.sigma <= WORLD_MAX or weighting.background_weight < 0:
        raise InputError(
            "the scene's weighting needs a sigma above 0 and a background weight of at least 0"
        )


def check_footprint(footprint: Footprint, blend: str) -> None:
    """Raise `InputError` unless scenes of this blending can have the footprint."""
    if footprint.soft_edge and blend == "sorted":
        raise InputError("a scene that is blended sorted cannot have a footprint with a soft edge")


def check_views(views: list[Camera]) -> None:
    """Raise `InputError` unless a file can hold these views and each is a valid camera."""
    if len(views) > VIEWS_MAX:
        raise InputError(f"the scene has {len(views)} views: {VIEWS_MAX} are allowed")
    for view in views:
        if not 1 <= min(view.width, view.height) <= max(view.width, view.height) <= SIDE_MAX:
            raise InputError(f"a view of {view.width} x {view.height} pixels is out of range")
        for matrix in (view.viewmat, view.K):
            last = torch.eye(len(matrix))[-1]
            if not matrix.isfinite().all() or not torch.equal(matrix[-1], last):
                raise InputError("a view's matrices are not those of a camera")
        if min(view.K[0, 0], view.K[1, 1]) <= 0:
            raise InputError("a view's focal length is not positive")


def check_meta(meta: dict[Any, Any]) -> None:
    """Raise `InputError` unless all notes are short texts, numbers, booleans or None."""
    if len(meta) > META_MAX:
        raise InputError(f"the scene has {len(meta)} notes: {META_MAX} are allowed")
    for name, value in meta.items():
        number = isinstance(value, int | float) and abs(value) <= 2**53  # JavaScript's limit
        text = short_text(value, TEXT_MAX)
        if not (number or text or value is None) or not short_text(name, TEXT_MAX):
            raise InputError(f"the note {str(name)[:40]!r} is not a short text or a number")
