"""Train teachers of full size with other rates, lengths and numbers of Gaussians.

    python -m bench.studies.teacher_rates [--json OUT] [--capture bonsai] [--device cuda]
                                          [--only NAME ...] [--seed 0]
    python -m bench.studies.teacher_rates --table [--json OUT]

Captures come from MOBILEGS_DATA; their photos have the usual size. Each row trains a teacher that
clones and splits, as `mobilegs train --minutes` does, with the steps that two cores reach in an
hour's budget; the first row has twice as many. Rows in OUT are not repeated. `--table` writes the
figures into docs/guides/teachers.md.
"""

import argparse
import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import torch

from bench.pages import between
from mobilegs.atomic import atomic_write
from mobilegs.data import Dataset, View, load_capture
from mobilegs.data.dataset import ViewLoader
from mobilegs.evaluate.report import evaluate
from mobilegs.train.budget import INITIAL
from mobilegs.train.recipes import cpu_recipe, rates_for, with_method, with_settings
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs/guides/teachers.md"
HARMONICS, FALL = "teacher.lr.sh_rest", "teacher.lr.final_factor"


class Row(NamedTuple):
    """A teacher: its steps, most Gaussians, method, and settings that differ."""

    steps: int
    splats: int
    settings: tuple[str, ...] = ()
    method: str | None = None


ROWS = {
    "213,000 Gaussians, 36,000 steps": Row(36_000, 213_200),
    "opacities reset ten times": Row(18_000, 213_200, ("teacher.densify.opacity_reset=0.1",)),
    "Mini-Splatting": Row(18_000, 213_200, method="mini-splatting"),
    "harmonics 1e-3": Row(18_000, 213_200, (f"{HARMONICS}=1e-3",)),
    "341,000 Gaussians": Row(14_000, 341_000),
    "640,000 Gaussians": Row(14_000, 640_000),
    "341,000, harmonics 1e-3": Row(14_000, 341_000, (f"{HARMONICS}=1e-3",)),
    "341,000, harmonics 2.5e-3": Row(14_000, 341_000, (f"{HARMONICS}=2.5e-3",)),
    "341,000, harmonics 1e-3, fall to 0.1": Row(
        14_000, 341_000, (f"{HARMONICS}=1e-3", f"{FALL}=0.1")
    ),
    "the same, densified until 0.65": Row(
        14_000, 341_000, (f"{HARMONICS}=1e-3", f"{FALL}=0.1", "teacher.densify.stop=0.65")
    ),
    "the same, means twice as fast": Row(
        14_000,
        341_000,
        (f"{HARMONICS}=1e-3", f"{FALL}=0.1", "teacher.lr.means=6e-4", "teacher.lr.means_end=6e-6"),
    ),
}


def config_of(row: Row) -> TeacherConfig:
    recipe = cpu_recipe()
    if row.method:
        recipe = with_method(recipe, row.method)
    teacher = replace(
        recipe.teacher,
        steps=row.steps,
        max_splats=row.splats,
        init_splats=round(INITIAL * row.splats),
    )
    if not row.method:
        teacher = replace(teacher, lr=rates_for(row.steps))
    return with_settings(replace(recipe, teacher=teacher), list(row.settings)).teacher


def cell(name: str, dataset: Dataset, seed: int, device: torch.device) -> dict:
    """Train one teacher and measure it."""
    row, started = ROWS[name], time.perf_counter()
    views: dict[int, View] = {}
    stage = Teacher(config_of(row), dataset, seed=seed, device=device)
    with ViewLoader(dataset.train) as loader:
        while stage.done < stage.steps:
            [index] = view_order(len(loader), stage.done, 1, 2 * seed)
            if index not in views:
                views[index] = loader.get(index, device)
            stage.advance([(index, views[index])])
            if stage.done % 1000 == 0:
                seconds = time.perf_counter() - started
                print(f"{name} {stage.done}: {stage.count} {seconds:.0f} s", flush=True)
    figures = evaluate(stage.scene(), dataset)
    camera = dataset.test[0].camera
    return {
        **row._asdict(),
        "seed": seed,
        "gaussians": stage.count,
        "psnr": figures["psnr"],
        "ssim": figures["ssim"],
        "worst_view_psnr": min(view["psnr"] for view in figures["views"]),
        "size": [camera.width, camera.height],
        "device": torch.cuda.get_device_name(device) if device.type == "cuda" else "cpu",
        "date": time.strftime("%Y-%m-%d"),
    }


def table(cells: dict) -> str:
    """Return the figures as a Markdown table."""
    head = "| teacher | steps | Gaussians | PSNR dB | SSIM | worst view dB |"
    lines = [head, "|---|" + "---:|" * 5]
    for name, found in cells.items():
        lines.append(
            f"| {name} | {found['steps']:,} | {found['gaussians']:,} | {found['psnr']:.2f} "
            f"| {found['ssim']:.3f} | {found['worst_view_psnr']:.2f} |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/teacher_rates.json")
    parser.add_argument("--capture", default="bonsai")
    parser.add_argument("--only", nargs="+", default=list(ROWS), choices=ROWS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--table", action="store_true", help="only write the table")
    options = parser.parse_args()
    cells = json.loads(options.json.read_text()) if options.json.exists() else {}
    if not options.table:
        data = Path(os.environ.get("MOBILEGS_DATA") or sys.exit("set MOBILEGS_DATA"))
        dataset = load_capture(data / options.capture)
        for name in options.only:
            if name not in cells:
                cells[name] = cell(name, dataset, options.seed, torch.device(options.device))
                atomic_write(options.json, json.dumps(cells, indent=1) + "\n")
        return
    atomic_write(DOCS, between(DOCS.read_text(), "rates", table(cells)))


if __name__ == "__main__":
    main()
