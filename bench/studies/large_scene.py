"""Compress a large scene within a given time, with its photos.

    python -m bench.studies.large_scene [--json OUT] [--runs FOLDER]
    python -m bench.studies.large_scene --table [--json OUT]

The scene is a plain 3DGS .ply of 600,000 Gaussians of bonsai in MOBILEGS_DATA, which the script
trains first: densified without a threshold, so it is large rather than good. `mobilegs compress
SCENE --capture bonsai --minutes 15` then makes the .mgs. Both are compared with the held-back
photos. A finished run under FOLDER is not repeated. `--table` writes the figures into
docs/guides/existing_scenes.md.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

from bench.pages import between
from bench.quality_per_minute import machine, timed
from mobilegs.atomic import atomic_write

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs/guides/existing_scenes.md"
SPLATS, STEPS, MINUTES = 600_000, 2000, 15
SETTINGS = (
    f"teacher.steps={STEPS}",
    "student.steps=20",
    "teacher.densify.gradient=0",
    "teacher.densify.min_interval=20",
)
KEPT = ("gaussians", "file_bytes", "psnr", "ssim")


def run(verb: list[str], output: Path) -> tuple[dict, float]:
    """Run a verb of the command line unless it is finished; return its metrics and seconds."""
    clock = output.with_suffix(".seconds.json")
    if not (output / "metrics.json").exists():
        timed([sys.executable, "-m", "mobilegs", *verb, "-o", str(output), "--resume"], clock)
    return json.loads((output / "metrics.json").read_text()), json.loads(clock.read_text())


def measured(data: Path, runs: Path) -> dict:
    """Train the scene, compress it and return the figures of both."""
    capture, large, small = str(data / "bonsai"), runs / "large", runs / "compressed"
    first = ["train", capture, "--preset", "cpu", "--max-splats", str(SPLATS)]
    run([*first, "--downscale", "1", "--set", *SETTINGS], large)
    verb = ["compress", str(large / "teacher.ply"), "--capture", capture]
    metrics, seconds = run([*verb, "--minutes", str(MINUTES)], small)
    config = json.loads((small / "config.json").read_text())
    steps = [config["recipe"]["student"]["steps"]]
    steps += [number for _, _, number in config["plan"]["corrections"]]
    return {
        "size": metrics["image_size"],
        "minutes": MINUTES,
        "taken": seconds / 60,
        "teacher_steps": STEPS,
        "steps": steps[-1],
        "peak_memory_mib": metrics["peak_memory_mib"],
        "teacher": {key: metrics["teacher"][key] for key in KEPT},
        "student": {key: metrics["student"][key] for key in KEPT},
        "machine": machine(),
        "date": time.strftime("%Y-%m-%d"),
    }


def table(found: dict) -> str:
    """Return the figures as a Markdown table."""
    lines = ["| scene | Gaussians | MB | PSNR dB | SSIM |", "|---|---:|---:|---:|---:|"]
    for name, key in (("the `.ply`", "teacher"), ("its `.mgs`", "student")):
        row = found[key]
        quality = f"{row['psnr']:.2f} | {row['ssim']:.3f}"
        megabytes = row["file_bytes"] / 1e6
        lines.append(f"| {name} | {row['gaussians']:,} | {megabytes:.2f} | {quality} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/large_scene.json")
    parser.add_argument("--runs", type=Path, default=Path("runs/large_scene"))
    parser.add_argument("--table", action="store_true", help="only write the table")
    options = parser.parse_args()
    if not options.table:
        data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
        found = measured(data, options.runs)
        atomic_write(options.json, json.dumps(found, indent=1) + "\n")
        print(json.dumps(found))
        return
    found = json.loads(options.json.read_text())
    atomic_write(DOCS, between(DOCS.read_text(), "large_scene", table(found)))


if __name__ == "__main__":
    main()
