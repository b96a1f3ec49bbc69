"""A plain scene in the formats of others, measured like the `.mgs` that is made of it."""

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypedDict

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.sog import read_sog_scene, write_sog
from mobilegs.formats.spz import read_spz_scene, write_spz
from mobilegs.render.scene import Scene

FORMATS = {"sog": (write_sog, read_sog_scene), "spz": (write_spz, read_spz_scene)}


class FormatMetrics(TypedDict):
    """Size and means over the held-back photos, as in `FileMetrics`."""

    file_bytes: int
    psnr: float
    ssim: float
    neutral_rms: float | None


def measure_formats(
    scene: Scene, dataset: Dataset, progress: Callable[[int, int], None] | None = None
) -> dict[str, FormatMetrics]:
    """Write a scene for sorted blending as `.sog` and `.spz`, and measure what is read back.

    Returns the figures by format. A format that cannot hold the scene is left out. `progress` is
    called with the number of photos done and in total, for each format anew.
    """
    found: dict[str, FormatMetrics] = {}
    with tempfile.TemporaryDirectory() as folder:
        for kind, (write, read) in FORMATS.items():
            path = Path(folder) / f"scene.{kind}"
            try:
                write(path, scene.gaussians, footprint=scene.footprint)
                gaussians, footprint = read(path)
            except InputError:
                continue
            device = scene.gaussians.means.device
            reread = replace(scene, gaussians=gaussians.to(device), footprint=footprint)
            measured = evaluate(reread, dataset, progress=progress)
            found[kind] = {
                "file_bytes": path.stat().st_size,
                "psnr": measured["psnr"],
                "ssim": measured["ssim"],
                "neutral_rms": measured["neutral_rms"],
            }
    return found
