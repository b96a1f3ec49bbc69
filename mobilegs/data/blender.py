"""Reads NeRF-synthetic captures: RGBA renders with `transforms_train.json` and `_test.json`."""

from pathlib import Path

import numpy as np

from mobilegs.data.dataset import Color, Dataset, assemble, split_every_eighth
from mobilegs.data.nerfstudio import read_frames


def load_blender(
    path: Path,
    *,
    downscale: int | None = None,
    background: Color | None = None,
    masks: bool = True,
) -> Dataset:
    """Read a Blender capture: renders composited over `background`, without sparse points.

    `background` is white by default. Without `transforms_test.json` every eighth view by name is
    held back. `load_capture` describes the arguments. Raises `InputError`.
    """
    background = background or (1.0, 1.0, 1.0)
    train = read_frames(
        path, "transforms_train.json", downscale=downscale, background=background, masks=masks
    )
    if (path / "transforms_test.json").is_file():
        test = read_frames(
            path, "transforms_test.json", downscale=downscale, background=background, masks=masks
        )
    else:
        train, test = split_every_eighth(train)
    return assemble(
        path.resolve().name,
        train,
        test,
        points=np.zeros((0, 3)),
        colors=np.zeros((0, 3)),
        background=background,
    )
