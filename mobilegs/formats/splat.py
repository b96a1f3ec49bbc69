"""antimatter15's `.splat`: 32 bytes a Gaussian, no header, no harmonics.

Position and scales are three floats each, then come red, green, blue and opacity as bytes, then the
rotation wxyz, each part p as the byte 128 + 128 p. Axes are those of the `.ply` it was made of. The
facts are those of github.com/antimatter15/splat.
"""

from pathlib import Path

import numpy as np
import torch

from mobilegs.atomic import file_size
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.spherical_harmonics import C0

ROW = np.dtype([("mean", "<f4", 3), ("scale", "<f4", 3), ("color", "u1", 4), ("rotation", "u1", 4)])
BLOCK = 1 << 15  # rows that are decoded at a time
FLAT = np.float32(1e-30)  # for scales of 0, which have no logarithm
CLEAR = 1e-6  # 0 and 255 are no logits; both stay as good as invisible and opaque


def read_splat(path: Path | str) -> Gaussians:
    """Read a `.splat` scene, degree 0, as float32 on the CPU; what is not finite is left out.

    Raises:
        InputError: the file is missing, is empty, or is not made of rows of 32 bytes.
    """
    path = Path(path)
    try:
        size = file_size(path)
        count, rest = divmod(size, ROW.itemsize)
        if not size:
            raise InputError(f"{path} is empty")
        if rest:
            raise InputError(f"{path} is no .splat, or cut off: {size} bytes are no rows of 32")
        shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, 1, 3)]
        found = [np.empty(shape, np.float32) for shape in shapes]
        with path.open("rb") as file:
            for first in range(0, count, BLOCK):
                rows = np.fromfile(file, ROW, min(BLOCK, count - first))
                for whole, values in zip(found, _decoded(rows), strict=True):
                    whole[first : first + len(rows)] = values
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    return Gaussians(*(torch.from_numpy(whole) for whole in found)).finite(path)


def _decoded(rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Means, quaternions, log-scales, logits, harmonics of some rows."""
    quats = rows["rotation"] / 128 - 1
    length = np.linalg.norm(quats, axis=1, keepdims=True)
    quats = np.where(length > 0, quats / np.maximum(length, 1e-9), [1.0, 0, 0, 0])
    colors = rows["color"] / 255
    opaque = np.clip(colors[:, 3], CLEAR, 1 - CLEAR)
    logits = np.log(opaque / (1 - opaque))
    with np.errstate(invalid="ignore"):  # what is not finite is left out in the end
        scales = np.log(np.maximum(rows["scale"], FLAT))
    return rows["mean"], quats, scales, logits, (colors[:, None, :3] - 0.5) / C0
