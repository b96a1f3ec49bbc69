"""Train students of one teacher with several learning rates.

    python -m bench.studies.student_rates --runs FOLDER [--json OUT] [--only ROW ...]
    python -m bench.studies.student_rates --table [--json OUT]

The preset cpu on bonsai at half its size, 5,000 steps of the teacher and 8,000 of each student,
seed 0. The capture comes from MOBILEGS_DATA. Finished runs under FOLDER are not repeated; the
teacher is FOLDER/teacher. `--table` writes the figures into docs/explanation/benchmarks.md.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path

from bench.pages import between
from mobilegs.atomic import atomic_write
from mobilegs.csrc.binding import kernel_level

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs/explanation/benchmarks.md"
# those of the preset until 2026-11-26
APPEARANCE = {"lobes": 0.04, "sh0": 2.5e-3, "sh_rest": 5e-4, "network": 4e-3, "color_latents": 5e-3}
SHAPES = {"quats": 2e-3, "scales": 5e-3, "means_max": 0.05}
STEPS = 8000
FALL = 0.1


def rates(appearance: float = 1, shapes: float = 1, fall: float = FALL) -> dict[str, float]:
    """Return the rates above times `appearance` and `shapes`, and the factor at the end."""
    found = {name: appearance * value for name, value in APPEARANCE.items()}
    found |= {name: shapes * value for name, value in SHAPES.items()}
    return found | {"final_factor": fall}


ROWS = {
    "before": rates(),
    "all halved": rates(0.5, 0.5),
    "fall to 0.02": rates(fall=0.02),
    "appearance doubled": rates(2),
    "appearance fourfold, fall to 0.05": rates(4, fall=0.05),
}


def train(output: Path, settings: list[str], *options: str) -> dict:
    """Train unless the run is finished; return its metrics."""
    metrics = output / "metrics.json"
    if not metrics.exists():
        capture = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA")) / "bonsai"
        command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
        command += ["--preset", "cpu", "--downscale", "2", *options, "--set", *settings]
        subprocess.run(command, check=True)
    return json.loads(metrics.read_text())


def table(cells: dict) -> str:
    """Return the figures as a Markdown table."""
    lines = ["| rates | PSNR dB | SSIM | Gaussians | kB |", "|---|---:|---:|---:|---:|"]
    for name, row in cells.items():
        figures = f"{row['psnr']:.2f} | {row['ssim']:.3f} | {row['gaussians']:,}"
        lines.append(f"| {name} | {figures} | {row['file_bytes'] / 1e3:.0f} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/student_rates.json")
    parser.add_argument("--runs", type=Path, help="folder of the runs")
    parser.add_argument("--only", nargs="+", choices=ROWS, default=list(ROWS))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    result = json.loads(options.json.read_text()) if options.json.exists() else {"cells": {}}
    if options.runs:
        teacher = options.runs / "teacher"
        found = train(teacher, ["student.steps=500"])
        result["teacher_psnr"] = found["teacher"]["psnr"]
        result["machine"] = (
            f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}"
        )
        result["date"] = time.strftime("%Y-%m-%d")
        for name in options.only:
            settings = [f"student.lr.{key}={value}" for key, value in ROWS[name].items()]
            settings.append(f"student.steps={STEPS}")
            output = options.runs / name.replace(" ", "-").replace(",", "")
            found = train(output, settings, "--teacher", str(teacher / "teacher.ply"))["student"]
            keys = ("psnr", "ssim", "gaussians", "file_bytes")
            result["cells"][name] = {"rates": ROWS[name]} | {key: found[key] for key in keys}
            atomic_write(options.json, json.dumps(result, indent=1) + "\n")
    if options.table:
        atomic_write(DOCS, between(DOCS.read_text(), "student_rates", table(result["cells"])))


if __name__ == "__main__":
    main()
