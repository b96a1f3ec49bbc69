"""Peak memory of a training by size of photos and number of Gaussians.

    python -m bench.memory [--json OUT]

The photos are those of bonsai in MOBILEGS_DATA, enlarged where more pixels are asked for. Each cell
has a few steps of the preset short, whose Gaussians double until they are as many as they may be.
The caches hold the photos and teacher images that its few steps see, which the table subtracts.
`needed` is what a plan reckons with (mobilegs/train/memory.py), for the same views.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from PIL import Image

from bench.record import RESULTS, Figures, data_folder
from mobilegs.train import memory
from mobilegs.train.recipes import short_recipe
from mobilegs.viewpoints.virtual_views import DIVISOR

SIZES = ((400, 267), (800, 533), (1600, 1067))
SPLATS = (100_000, 500_000, 1_000_000)
TEACHER, STUDENT = 280, 60  # steps
PHOTOS = 255  # for training, each of which the steps see
SETTINGS = (
    f"teacher.steps={TEACHER}",
    f"student.steps={STUDENT}",
    "teacher.first_divisor=1",
    "teacher.densify.gradient=0",
    "teacher.densify.min_interval=20",
)


def enlarged(source: Path, target: Path, size: tuple[int, int]) -> None:
    """Write the capture `source` with photos of `size`."""
    shutil.copytree(source / "sparse", target / "sparse")
    (target / "images").mkdir()
    for photo in sorted((source / "images").iterdir()):
        Image.open(photo).convert("RGB").resize(size).save(target / "images" / photo.name)


def cell(capture: Path, size: tuple[int, int], splats: int, runs: Path) -> dict:
    """Train one run and return its peak, in bytes."""
    output = runs / f"{size[0]}-{splats}"
    command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
    command += ["--preset", "short", "--max-splats", str(splats), "--device", "cpu", "--resume"]
    subprocess.run([*command, "--downscale", "1", "--set", *SETTINGS], check=True)
    metrics = json.loads((output / "metrics.json").read_text())
    pixels = size[0] * size[1]
    student = short_recipe().student
    config = replace(student, cache_mib=0)
    needed = memory.needed_memory(config, photos=PHOTOS, pixels=pixels, splats=splats)
    virtual = STUDENT // student.loss.virtual_view_every
    smaller = DIVISOR**2
    needed += round(memory.CACHE_RATIO * memory.TARGET_BYTES * virtual * pixels / smaller)
    return {
        "size": list(size),
        "splats": splats,
        "peak": round(metrics["peak_memory_mib"] * (1 << 20)),
        "needed": needed,
        "steps": [TEACHER, STUDENT],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=RESULTS / "memory.json")
    figures = Figures(parser.parse_args().json)
    for size in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            capture = Path(folder, "capture")
            capture.mkdir()
            enlarged(data_folder() / "bonsai", capture, size)
            for splats in SPLATS:
                name = f"{size[0]}-{splats}"
                if name not in figures.rows:
                    figures.add(name, **cell(capture, size, splats, Path(folder)))


if __name__ == "__main__":
    main()
