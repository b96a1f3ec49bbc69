"""Reads antimatter15's `.splat`: 32 bytes per Gaussian, no header, no view dependence.

A row has mean and scales as three floats each, then red, green, blue and opacity as bytes, then the
rotation wxyz, each component q as the byte 128 + 128 q. Axes are those of the source `.ply`.
Source: https://github.com/antimatter15/splat.
"""

import os
from pathlib import Path

import numpy as np

from mobilegs.atomic import open_input
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.packed_gaussians import gaussians_in_blocks, logits_of
from mobilegs.spherical_harmonics import C0

ROW = np.dtype([("mean", "<f4", 3), ("scale", "<f4", 3), ("color", "u1", 4), ("rotation", "u1", 4)])


def read_splat(path: Path | str) -> Gaussians:
    """Read a `.splat` scene, SH degree 0, as float32 on the CPU.

    Gaussians that cannot be drawn are left out (`Gaussians.drawable`). Raises InputError if the
    file is missing or empty, its size is not a multiple of 32 bytes, or none can be drawn.
    """
    path = Path(path)
    with open_input(path) as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(0)
        count, rest = divmod(size, ROW.itemsize)
        if not size:
            raise InputError(f"{path} is empty")
        if rest:
            raise InputError(f"{path} is not a .splat, or cut off: {size} bytes are not rows of 32")
        return gaussians_in_blocks(
            count, 1, lambda rows: _decoded(np.fromfile(file, ROW, rows.stop - rows.start))
        ).drawable(path)


def _decoded(rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Decode rows: means, quaternions, log-scales, logits, SH."""
    quats = rows["rotation"] / 128 - 1
    length = np.linalg.norm(quats, axis=1, keepdims=True)
    quats /= np.maximum(length, 1e-9)
    colors = rows["color"] / 255
    return (
        rows["mean"],
        quats,
        np.log(rows["scale"]),
        logits_of(colors[:, 3]),
        (colors[:, None, :3] - 0.5) / C0,
    )
