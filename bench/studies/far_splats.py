"""Train captures with and without Gaussians on a far sphere.

    python -m bench.studies.far_splats --runs FOLDER [--json OUT]

Preset cpu, 2,000 + 2,000 steps, at most 30,000 Gaussians, photos at a quarter of their size, one
seed. Captures come from MOBILEGS_DATA; the sample is the program's own, at its size. Finished runs
under FOLDER are not repeated.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from mobilegs.csrc.binding import kernel_level
from mobilegs.data.demo.capture import write_capture

SAMPLE = "sample"
CAPTURES = (SAMPLE, "bonsai", "llff_horns", "stitch")
COUNTS = (0, 3000)
SETTINGS = ("teacher.steps=2000", "student.steps=2000")
NEVER = ("teacher.exposure.learned=never", "student.exposure.learned=never")


def run(capture: Path, output: Path, count: int, *options: str) -> dict:
    """Train unless the run is finished, and return its metrics."""
    metrics = output / "metrics.json"
    if not metrics.exists():
        command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
        command += ["--preset", "cpu", "--max-splats", "30000", *options, "--set"]
        subprocess.run([*command, *SETTINGS, *NEVER, f"teacher.far_splats={count}"], check=True)
    return json.loads(metrics.read_text())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--json", type=Path, help="write the figures here")
    options = parser.parse_args()
    if not os.environ.get("MOBILEGS_DATA"):
        sys.exit("set MOBILEGS_DATA to the folder that holds the captures")
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "settings": [*SETTINGS, *NEVER],
        "cells": {},
    }
    for name in CAPTURES:
        capture = Path(os.environ["MOBILEGS_DATA"]) / name
        size = ["--downscale", "4"]
        if name == SAMPLE:
            capture, size = options.runs / "sample_capture", []
            if not capture.exists():
                write_capture(capture)
        for count in COUNTS:
            found = run(capture, options.runs / f"{name}-{count}", count, *size)
            keys = ("psnr", "ssim", "gaussians", "file_bytes")
            result["cells"][f"{name}, {count}"] = {
                who: {key: found[who][key] for key in keys if key in found[who]}
                for who in ("teacher", "student")
            } | {"image_size": found["image_size"]}
            if options.json:
                options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
