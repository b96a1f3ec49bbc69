"""Quality against time: `mobilegs train --minutes N`, on photos of a screen's size.

    python -m bench.quality_per_minute [--json OUT] [--runs FOLDER] [--only bonsai horns]
                                       [--minutes 2 5 15 30 60 120] [--target-mb MB]
    python -m bench.quality_per_minute --plot [--json OUT]

Captures come from MOBILEGS_DATA. Each run trains in FOLDER/CAPTURE-MINUTES and resumes there. With
`--target-mb` the file has about that size, and the run's name ends with it. The scene's
file is then compared with the held-back photos at most 1,600 pixels wide, whatever the size of the
photos that the plan chose; LPIPS takes all of them up to 20, and every fourth of more. `--plot`
draws docs/images/minutes.png instead. Nothing else may run on the machine.
"""

import argparse
import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from bench.record import RESULTS, ROOT, Figures, data_folder
from mobilegs.atomic import atomic_write
from mobilegs.data import load_capture
from mobilegs.evaluate.lpips import lpips_from
from mobilegs.evaluate.report import evaluate
from mobilegs.mgs.codec import read_mgs

PLOT = ROOT / "docs/images/minutes.png"
CAPTURES = {"bonsai": "bonsai", "horns": "llff_horns", "lego": "lego", "stitch": "stitch"}
MINUTES = (2, 5, 15, 30, 60, 120)
ALL_LPIPS, FEW_LPIPS = 20, 4


def timed(command: list[str], clock: Path) -> float:
    """Run a command and return its seconds; those of interrupted runs before are in `clock`."""
    before = json.loads(clock.read_text()) if clock.exists() else 0.0
    clock.parent.mkdir(parents=True, exist_ok=True)
    started = time.monotonic()
    try:
        subprocess.run(command, check=True)
    finally:
        seconds = before + time.monotonic() - started
        atomic_write(clock, json.dumps(seconds))
    return seconds


def measure(file: Path, capture: Path, data: Path) -> dict:
    """Compare a scene's file with the held-back photos, at most 1,600 pixels wide."""
    scene, screen = read_mgs(file).decode("cpu"), load_capture(capture)
    found = evaluate(scene, screen)
    step = FEW_LPIPS if len(screen.test) > ALL_LPIPS else 1
    few = replace(screen, test=screen.test[::step])
    lpips = evaluate(scene, few, lpips=lpips_from(data / "lpips"))
    camera = screen.test[0].camera
    return {
        "measured_at": [camera.width, camera.height],
        "psnr": found["psnr"],
        "ssim": found["ssim"],
        "lpips_vgg": lpips["lpips_vgg"],
        "lpips_photos": len(few.test),
        "bytes": file.stat().st_size,
        "gaussians": len(scene.gaussians.means),
    }


def cell(capture: Path, output: Path, minutes: int, target_mb: float, data: Path) -> dict:
    """Train and measure one run."""
    command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
    command += ["--minutes", str(minutes), "--resume"]
    if target_mb:
        command += ["--target-mb", str(target_mb)]
    seconds = timed(command, output.with_suffix(".seconds.json"))
    metrics = json.loads((output / "metrics.json").read_text())
    config = json.loads((output / "config.json").read_text())
    steps = {"teacher": config["recipe"]["teacher"]["steps"]}
    steps["student"] = config["recipe"]["student"]["steps"]
    steps |= {stage: number for stage, _, number in config["plan"]["corrections"]}
    return {
        "minutes": minutes,
        "target_mb": target_mb,
        "taken": seconds / 60,
        "trained_at": metrics["image_size"],
        "max_splats": config["recipe"]["teacher"]["max_splats"],
        "steps": steps,
        "teacher_psnr": metrics["teacher"]["psnr"],
        "trained_psnr": metrics["student"]["psnr"],
        "peak_memory_mib": metrics["peak_memory_mib"],
        **measure(output / "scene.mgs", capture, data),
    }


def plot(cells: dict) -> None:
    """Draw PSNR and LPIPS against minutes, a line for each capture; of equal minutes the newest."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    for name in CAPTURES:
        newest: dict[int, dict] = {}
        for key, found in cells.items():
            minutes, date = found["minutes"], found["date"]
            newer = minutes not in newest or date >= newest[minutes]["date"]
            if key.split("-")[0] == name and newer:
                newest[minutes] = found
        if not newest:
            continue
        runs = [newest[minutes] for minutes in sorted(newest)]
        width, height = runs[0]["measured_at"]
        for axis, key in zip(axes, ("psnr", "lpips_vgg"), strict=True):
            axis.plot(
                [found["minutes"] for found in runs],
                [found[key] for found in runs],
                marker="o",
                label=f"{name}, {width}x{height}",
            )
        for found in runs:
            axes[0].annotate(
                f"{found['bytes'] / 1e6:.1f} MB",
                (found["minutes"], found["psnr"]),
                xytext=(4, 4),
                textcoords="offset points",
                fontsize=7,
            )
    for axis, label in zip(axes, ("PSNR dB", "LPIPS (less is better)"), strict=True):
        axis.set(xscale="log", xlabel="minutes on two cores", ylabel=label)
        axis.set_xticks(MINUTES, [str(minutes) for minutes in MINUTES])
        axis.minorticks_off()
        axis.margins(x=0.2, y=0.15)
    axes[0].legend(fontsize=8)
    figure.savefig(PLOT, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=RESULTS / "quality_per_minute.json")
    parser.add_argument("--runs", type=Path, default=Path("runs/minutes"))
    parser.add_argument("--only", nargs="+", choices=CAPTURES, default=list(CAPTURES))
    parser.add_argument("--minutes", nargs="+", type=int, default=MINUTES)
    parser.add_argument("--target-mb", type=float, default=0.0, help="size of the file; 0: any")
    parser.add_argument("--plot", action="store_true", help="only draw the plot")
    options = parser.parse_args()
    figures = Figures(options.json)
    if options.plot:
        return plot(figures.rows)
    data, size = data_folder(), options.target_mb
    for name in options.only:
        for minutes in options.minutes:
            key = f"{name}-{minutes}" + (f"-{size:g}mb" if size else "")
            if key not in figures.rows:
                found = cell(data / CAPTURES[name], options.runs / key, minutes, size, data)
                figures.add(key, **found)


if __name__ == "__main__":
    main()
