"""Peak memory of a training by size of photos and number of Gaussians.

    python -m bench.memory [--json OUT]
    python -m bench.memory --table [--json OUT]

The photos are those of bonsai in MOBILEGS_DATA, enlarged where more pixels are asked for. Each cell
is a short run of the preset cpu, whose Gaussians double until they are as many as they may be. The
caches of photos and of the teacher's images hold what its few steps see, which the table subtracts.
`needed` is what a plan reckons with (mobilegs/train/memory.py), for the same views. `--table`
writes the figures into docs/explanation/benchmarks.md.
"""

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from PIL import Image

from bench.pages import between
from mobilegs.atomic import atomic_write
from mobilegs.train import memory
from mobilegs.train.recipes import cpu_recipe
from mobilegs.train.student.virtual_views import DIVISOR

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs/explanation/benchmarks.md"
SIZES = ((400, 267), (800, 533), (1600, 1067))
SPLATS = (100_000, 500_000)
TEACHER, STUDENT = 200, 60  # steps
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
    command += ["--preset", "cpu", "--max-splats", str(splats), "--device", "cpu", "--resume"]
    subprocess.run([*command, "--downscale", "1", "--set", *SETTINGS], check=True)
    metrics = json.loads((output / "metrics.json").read_text())
    pixels = size[0] * size[1]
    student = cpu_recipe().student
    config = replace(student, cache_mib=0)
    needed = memory.needed_memory(config, photos=PHOTOS, pixels=pixels, splats=splats)
    virtual = STUDENT // student.loss.virtual_view_every
    smaller = DIVISOR**2
    needed += round(memory.HOLES * memory.TARGET * virtual * pixels / smaller)
    return {
        "size": list(size),
        "splats": splats,
        "peak": round(metrics["peak_memory_mib"] * (1 << 20)),
        "needed": needed,
        "steps": [TEACHER, STUDENT],
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "date": time.strftime("%Y-%m-%d"),
    }


def table(cells: dict) -> str:
    """Return the figures as a Markdown table."""
    lines = ["| photos | Gaussians | peak GB | reckoned GB |", "|---" + "|---:" * 3 + "|"]
    for found in sorted(cells.values(), key=lambda c: (c["size"], c["splats"])):
        size = "x".join(map(str, found["size"]))
        values = [size, f"{found['splats']:,}"]
        values += [f"{1e-9 * found[name]:.2f}" for name in ("peak", "needed")]
        lines.append("| " + " | ".join(values) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/memory.json")
    parser.add_argument("--table", action="store_true", help="only write the table")
    options = parser.parse_args()
    cells = json.loads(options.json.read_text()) if options.json.exists() else {}
    if not options.table:
        data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
        for size in SIZES:
            with tempfile.TemporaryDirectory() as folder:
                capture = Path(folder, "capture")
                capture.mkdir()
                enlarged(data / "bonsai", capture, size)
                for splats in SPLATS:
                    key = f"{size[0]}-{splats}"
                    if key not in cells:
                        cells[key] = cell(capture, size, splats, Path(folder))
                        atomic_write(options.json, json.dumps(cells, indent=1) + "\n")
    atomic_write(DOCS, between(DOCS.read_text(), "memory", table(cells)))


if __name__ == "__main__":
    main()
