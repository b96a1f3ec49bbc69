"""Reads coloured points from a PLY file, as nerfstudio captures have them."""

from pathlib import Path

import numpy as np
from jaxtyping import Float

from mobilegs.data.ply_table import (
    CHANNELS,
    channel_max,
    find_vertex,
    read_header,
    vertex_rows,
)
from mobilegs.errors import InputError

AXES = ["x", "y", "z"]


def read_points_ply(
    path: Path,
) -> tuple[Float[np.ndarray, "m 3"], Float[np.ndarray, "m 3"]]:
    """Return (points [m, 3] in world units, colours [m, 3] in [0, 1]); grey without colours.

    Raises `InputError` for a file that is not a PLY, is damaged, or has no vertices.
    """
    header, size = read_header(path)
    vertex, _ = find_vertex(header, path)
    if not vertex.columns.keys() >= set(AXES):
        raise InputError(f"{path} lacks the properties x, y, z")
    colored = vertex.columns.keys() >= set(CHANNELS)
    names = [*AXES, *(CHANNELS if colored else [])]
    blocks = vertex_rows(header, size, names, path, np.float64)
    table = np.concatenate([np.zeros((0, len(names))), *blocks])
    points, colors = table[:, :3], table[:, 3:]
    if not colored:
        return points, np.full_like(points, 0.5)
    return points, colors / channel_max(vertex)
