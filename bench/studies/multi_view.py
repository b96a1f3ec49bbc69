"""Time steps on several views, in one process and in two, at 60,000 Gaussians and 400x266.

    python -m bench.studies.multi_view [--json OUT] [--rounds 12]

Bonsai comes from MOBILEGS_DATA. A short training makes the teacher. Then torchrun starts two
processes, in which all variants take turns: steps of one process with one and with two threads
while the other waits, and steps of both with one thread each. `apart` decodes the Gaussians once
per view instead of once per step.

Each variant has the median and the minimum of the milliseconds, the median processor time of the
first process, and the median over rounds of its ratio to another variant.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import torch

from mobilegs.csrc.binding import kernel_level
from mobilegs.data import View, load_capture, load_view
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import SINGLE_PROCESS, Team, join_team
from mobilegs.train.recipes import cpu_recipe
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher

COUNT, TEACHER_STEPS, VIEWS = 60_000, 150, 12
FORMS = {
    "explicit": {"latents_from": 1.0, "quantize_from": 1.0},
    "networks": {"latents_from": 0.0, "quantize_from": 1.0},
    "codes": {"latents_from": 0.0, "quantize_from": 0.0},
}
# variant: (views, threads, processes, the variant it is compared with)
VARIANTS = {
    "1 view": (1, 1, 1, None),
    "3 views": (3, 1, 1, "1 view"),
    "3 views apart": (3, 1, 1, "3 views"),
    "1 view, 2 threads": (1, 2, 1, "1 view"),
    "3 views, 2 threads": (3, 2, 1, "3 views"),
    "2 views": (2, 1, 1, "1 view"),
    "2 views, 2 threads": (2, 2, 1, "2 views"),
    "2 views, 2 processes": (2, 1, 2, "2 views"),
}
Step = Callable[[list[tuple[int, View]]], object]


def bonsai():
    data = os.environ.get("MOBILEGS_DATA")
    if not data:
        sys.exit("set MOBILEGS_DATA to the folder that holds bonsai")
    dataset = load_capture(Path(data) / "bonsai", downscale=2)
    every = len(dataset.train) // VIEWS
    return dataset, [(i, load_view(dataset.train[i])) for i in range(0, every * VIEWS, every)]


def teacher_stage(dataset, team: Team) -> Teacher:
    config = replace(cpu_recipe().teacher, init_splats=COUNT)
    config = replace(config, densify=DensifyConfig(strategy="fixed"))
    return Teacher(config, dataset, seed=0, device=torch.device("cpu"), team=team)


def student_stage(form: str, teacher: Scene, dataset, views, team: Team) -> Student:
    """Return a student in a given form that neither votes nor reassigns codes."""
    config = cpu_recipe().student
    votes = replace(config.pruning.votes, quantile=0.0)
    schedule = replace(config.schedule, regression_steps=20, reassign_every=10**9, **FORMS[form])
    pruning = replace(config.pruning, votes=votes)
    config = replace(config, pruning=pruning, schedule=schedule)
    cameras = [frame.camera for frame in dataset.train]
    stage = Student(config, teacher, cameras, extent=dataset.extent, seed=0, team=team)
    for index, view in views:
        stage.teacher_images.get(index, view.camera)
    return stage


def apart(stage: Student) -> Step:
    """A step whose views are decoded each for itself."""

    def step(views: list[tuple[int, View]]) -> None:
        for index, view in views:
            stage._add_gradients([stage.cameras[index]], [(index, view)])
        stage.model.step()

    return step


def timed(make: Callable[[Team], Teacher | Student], views, team: Team, rounds: int) -> dict:
    """Milliseconds of each variant in each round, alternating; empty but in the first process."""
    single = make(SINGLE_PROCESS) if team.is_main else None
    pair = make(team)
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in VARIANTS}
    for turn in range(rounds + 1):  # the first one warms up
        for name, (number, threads, processes, _) in VARIANTS.items():
            if "apart" in name and isinstance(pair, Teacher):
                continue
            torch.set_num_threads(threads)  # of our kernels, too: one OpenMP serves both
            shown = [views[(turn * number + i) % len(views)] for i in range(number)]
            team.barrier()
            started, worked = time.perf_counter(), time.process_time()
            if processes == 2:
                pair.advance(shown[team.rank :: 2])
            elif single is not None:
                step = apart(single) if "apart" in name else single.advance
                step(shown)
            if turn:
                taken = time.perf_counter() - started, time.process_time() - worked
                found[name].append((1e3 * taken[0], 1e3 * taken[1]))
            team.barrier()
    return found


def summary(found: dict[str, list[tuple[float, float]]]) -> dict:
    rows = {}
    for name, (*_, other) in VARIANTS.items():
        if not found[name]:
            continue
        passed, worked = zip(*found[name], strict=True)
        rows[name] = {
            "ms": round(statistics.median(passed), 1),
            "least_ms": round(min(passed), 1),
            "processor_ms": round(statistics.median(worked), 1),
        }
        if other:
            pairs = list(zip(found[name], found[other], strict=True))
            ratios = [[a[i] / b[i] for a, b in pairs] for i in range(2)]
            rows[name] |= {
                "of": other,
                "ratio": round(statistics.median(ratios[0]), 2),
                "processor_ratio": round(statistics.median(ratios[1]), 2),
            }
    return rows


def process(options: argparse.Namespace) -> None:
    """Run the variants in one of the two processes."""
    dataset, views = bonsai()
    gaussians, footprint = read_ply_scene(options.teacher)
    scene = Scene(gaussians, background=dataset.background, near=dataset.near, footprint=footprint)
    makers = {"teacher": lambda team: teacher_stage(dataset, team)}
    for form in FORMS:
        makers[form] = lambda team, form=form: student_stage(form, scene, dataset, views, team)
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "gaussians": len(scene.gaussians),
        "image_size": [views[0][1].camera.width, views[0][1].camera.height],
        "rounds": options.rounds,
        "stages": {},
    }
    with join_team("cpu") as team:
        for name, make in makers.items():
            rows = summary(timed(make, views, team, options.rounds))
            result["stages"][name] = rows
            if team.is_main:
                print(name, json.dumps(rows, indent=1), flush=True)
        if team.is_main and options.json:
            options.json.write_text(json.dumps(result, indent=1) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--rounds", type=int, default=12)
    parser.add_argument("--teacher", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.teacher is not None:
        return process(options)
    dataset, views = bonsai()
    stage = teacher_stage(dataset, SINGLE_PROCESS)
    for step in range(TEACHER_STEPS):
        stage.advance([views[step % len(views)]])
    with tempfile.TemporaryDirectory() as folder:
        write_ply(Path(folder) / "teacher.ply", stage.gaussians())
        torchrun = ["-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2"]
        again = [
            "-m",
            "bench.studies.multi_view",
            *sys.argv[1:],
            "--teacher",
            f"{folder}/teacher.ply",
        ]
        subprocess.run([sys.executable, *torchrun, *again], check=True)


if __name__ == "__main__":
    main()
