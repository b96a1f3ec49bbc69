"""Train a teacher with each method, all of one size: quality, Gaussians, minutes.

    python -m bench.studies.teachers [--json OUT] [--runs FOLDER] [--only NAME ...] [--seed 0]
    python -m bench.studies.teachers --table [--json OUT]

Captures come from MOBILEGS_DATA. Every teacher trains in the CPU preset's 5,000 steps on bonsai
at half size with at most 60,000 Gaussians. Cells in OUT are not repeated, so the script resumes.
FOLDER keeps each teacher and three held-back renders next to their photos. `--table` writes
the figures into docs/guides/teachers.md.
"""

import argparse
import json
import os
import platform
import sys
import time
from pathlib import Path

import torch
from PIL import Image

from mobilegs.csrc.binding import kernel_level
from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.evaluate.lpips import lpips_from
from mobilegs.evaluate.metrics import as_displayed, to_bytes
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.ply import write_ply
from mobilegs.render.scene import Scene
from mobilegs.train.recipes import cpu_recipe, with_method, with_settings
from mobilegs.train.stage import view_order
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs/guides/teachers.md"
BEGIN, END = "<!-- BEGIN:numbers -->", "<!-- END:numbers -->"
STEPS, MAX_SPLATS, DOWNSCALE = 5000, 60_000, 2
SHOWN = (2, 15, 30)  # of the held-back views
# name: method (None: the preset's), and what else differs, as for `mobilegs train --set`
TEACHERS: dict = {
    "clone and split": (None, []),
    "3dgs": ("3dgs", []),
    "mini-splatting": ("mini-splatting", []),
    "mini-splatting, outdoor": ("mini-splatting", ["teacher.mini_splatting.metric=outdoor"]),
    "mcmc": ("mcmc", []),
    # twice as many steps; Mini-Splatting with a larger budget, of which it keeps about half
    "clone and split, 10,000": (None, ["teacher.steps=10000"]),
    "mini-splatting, 10,000": (
        "mini-splatting",
        ["teacher.steps=10000", "teacher.max_splats=100000"],
    ),
}


def config_of(name: str) -> TeacherConfig:
    method, settings = TEACHERS[name]
    recipe = cpu_recipe()
    if method:
        recipe = with_method(recipe, method)
    settings = [f"teacher.steps={STEPS}", f"teacher.max_splats={MAX_SPLATS}", *settings]
    return with_settings(recipe, settings).teacher


@torch.inference_mode()
def show(scene: Scene, dataset: Dataset, path: Path) -> None:
    """Write held-back renders, each next to its photo."""
    rows = []
    for index in SHOWN:
        view = load_view(dataset.test[index % len(dataset.test)])
        drawn = as_displayed(scene.render(view.camera).image)
        rows.append(torch.cat([view.image, drawn], dim=1))
    Image.fromarray(to_bytes(torch.cat(rows)).numpy()).save(path)


def cell(name: str, dataset: Dataset, seed: int, runs: Path) -> dict:
    """Train one teacher and measure it."""
    views = [load_view(frame) for frame in dataset.train]
    config = config_of(name)
    started, spent = time.perf_counter(), time.process_time()
    stage = Teacher(config, dataset, seed=seed, device=torch.device("cpu"))
    peak, counts = 0, []
    while stage.done < stage.steps:
        [index] = view_order(len(views), stage.done, 1, 2 * seed)
        loss = stage.advance([(index, views[index])]).loss
        peak = max(peak, stage.count)
        if stage.done % 250 == 0:
            counts.append([stage.done, stage.count])
            print(f"{name} {stage.done}: {stage.count} {float(loss):.4f}", flush=True)
    found: dict = {
        "seed": seed,
        "gaussians": stage.count,
        "peak": peak,
        "counts": counts,
        "minutes": round((time.perf_counter() - started) / 60, 2),
        "cpu_minutes": round((time.process_time() - spent) / 60, 2),
        "threads": torch.get_num_threads(),
    }
    scene = stage.scene()
    stem = name.replace(", ", "-").replace(" ", "-") + f"-{seed}"
    write_ply(runs / f"{stem}.ply", scene.gaussians)
    show(scene, dataset, runs / f"{stem}.png")
    data = Path(os.environ["MOBILEGS_DATA"])
    lpips = lpips_from(str(data / "lpips")) if (data / "lpips").exists() else None
    figures = evaluate(scene, dataset, lpips=lpips)
    worst = min(figures["views"], key=lambda row: row["psnr"])
    found |= {key: figures[key] for key in ("psnr", "ssim", "lpips_vgg")}
    return found | {"worst_view_psnr": worst["psnr"]}


def table(result: dict) -> str:
    """Return a Markdown table: one row per teacher, means over its seeds."""
    head = "method | PSNR dB | SSIM | LPIPS (VGG, [0, 1]) | worst view dB | Gaussians | at most"
    lines = [f"| {head} | processor minutes |", "|" + "---|" * 8]
    for name in TEACHERS:
        rows = [row for key, row in result["cells"].items() if key.split("/")[0] == name]
        if not rows:
            continue

        def mean(key: str, rows: list[dict] = rows) -> float:
            return sum(row[key] for row in rows) / len(rows)

        cells = [name, f"{mean('psnr'):.2f}", f"{mean('ssim'):.3f}", f"{mean('lpips_vgg'):.3f}"]
        cells += [f"{mean('worst_view_psnr'):.2f}", f"{mean('gaussians'):,.0f}"]
        cells += [f"{max(row['peak'] for row in rows):,}", f"{mean('cpu_minutes'):.1f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=ROOT / "bench/results/teachers.json")
    parser.add_argument("--runs", type=Path, default=Path("runs/teachers"))
    parser.add_argument("--only", nargs="+", default=list(TEACHERS), choices=TEACHERS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--table", action="store_true", help="write the table, train nothing")
    options = parser.parse_args()
    result: dict = {"cells": {}}
    if options.json.exists():
        result = json.loads(options.json.read_text())
    if options.table:
        before, rest = DOCS.read_text().split(BEGIN)
        text = f"{BEGIN}\n{table(result)}\n{END}"
        DOCS.write_text(before + text + rest.split(END)[1])
        return
    if "MOBILEGS_DATA" not in os.environ:
        sys.exit("set MOBILEGS_DATA to the folder that holds bonsai")
    folder = Path(os.environ["MOBILEGS_DATA"]) / "bonsai"
    dataset = load_capture(folder, downscale=DOWNSCALE)
    options.runs.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        key = f"{name}/{options.seed}"
        if key in result["cells"]:
            continue
        found = cell(name, dataset, options.seed, options.runs)
        result["cells"][key] = found
        result |= {
            "date": time.strftime("%Y-%m-%d"),
            "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
            "image_size": [dataset.test[0].camera.width, dataset.test[0].camera.height],
            "steps": STEPS,
            "max_splats": MAX_SPLATS,
        }
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(json.dumps(result, indent=1) + "\n")
        print(key, json.dumps(found), flush=True)


if __name__ == "__main__":
    main()
