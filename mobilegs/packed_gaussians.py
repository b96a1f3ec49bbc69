"""Parts of Gaussians as files of few bits pack them: opacities, rotations, blocks of rows."""

import math
from collections.abc import Callable

import numpy as np
import torch
from jaxtyping import Float, Integer

from mobilegs.gaussians import Gaussians

BLOCK = 1 << 15  # rows that are decoded at a time: what they pass through is several times as large
OPACITY_MIN = 1e-6  # opacities 0 and 1 have no logit: clip to this and 1 - this
SMALL_MAX = math.sqrt(0.5)  # largest absolute value of a component that is not the largest
# places of the largest component and of the others, by the index of the largest
_PLACES = np.array([[0, 1, 2, 3], [1, 0, 2, 3], [1, 2, 0, 3], [1, 2, 3, 0]])


def logits_of(opacities: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """Return the logits of opacities in [0, 1]."""
    clipped = np.clip(opacities, OPACITY_MIN, 1 - OPACITY_MIN)
    return np.log(clipped / (1 - clipped))


def quats_of_smallest_three(
    small: Float[np.ndarray, "n 3"], largest: Integer[np.ndarray, "n"]
) -> Float[np.ndarray, "n 4"]:
    """Return unit quaternions from their other components and the index of the largest one."""
    parts = np.empty((len(small), 4))
    parts[:, 0] = np.sqrt(np.clip(1 - (small**2).sum(1), 0, None))
    parts[:, 1:] = small
    return np.take_along_axis(parts, _PLACES[largest], axis=1)


def gaussians_in_blocks(
    count: int, coefficients: int, decode: Callable[[slice], tuple[np.ndarray, ...]]
) -> Gaussians:
    """Return `count` Gaussians with some SH coefficients per channel, decoded in blocks of rows.

    `decode` returns means, quaternions, log-scales, logits and SH of the rows of a slice; it gets
    the slices in order. Numbers that float32 does not hold become infinite or NaN.
    """
    shapes = [(count, 3), (count, 4), (count, 3), (count,), (count, coefficients, 3)]
    tensors = [np.empty(shape, np.float32) for shape in shapes]
    with np.errstate(all="ignore"):
        for first in range(0, count, BLOCK):
            rows = slice(first, min(first + BLOCK, count))
            for whole, values in zip(tensors, decode(rows), strict=True):
                whole[rows] = values
    return Gaussians(*(torch.from_numpy(whole) for whole in tensors))
