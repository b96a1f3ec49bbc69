"""Measure the gain and the cost of view dependence: variants x captures x seeds.

    python -m bench.studies.view_dependence [--json OUT] [--runs FOLDER] [--captures ...]
        [--variants ...] [--seeds 0 1] [--steps 1500]
    python -m bench.studies.view_dependence --speed [--json OUT] [--runs FOLDER]

Every student of a capture starts from the same teacher (kept under FOLDER) and trains for the
same number of steps. `sorted-1` and `sorted-3` are that teacher with spherical harmonics of
degree 1 or 3, trained for as long with the same losses and learning rates, not quantised. Figures
are of held-back photos; students are drawn from their files. Cells in OUT are not repeated, so
the script resumes. `--speed` times training steps, all variants in turns in one process.
bench/studies/view_dependence_report.py makes the table and the plot.
"""

import argparse
import json
import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import torch
from torch import Tensor
from torch.nn.functional import normalize

from bench.paper.rows import CODEBOOKS
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.data.dataset import View
from mobilegs.data.demo.capture import demo_capture
from mobilegs.evaluate.lpips import lpips_from
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.render.lobes import lobe_degree
from mobilegs.render.scene import Scene
from mobilegs.spherical_harmonics import C0, sh_basis
from mobilegs.train.recipes import cpu_recipe, demo_recipe, with_settings
from mobilegs.train.stage import view_order
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.teacher.trainer import Teacher

LPIPS_EVERY = 4  # every 4th held-back photo: VGG on a CPU takes longer than all other work
TIMED = ("decoded-2", "chosen", "free-2", "projected-13")
TIMED_EVERY = 8  # every 8th training photo is timed


@dataclass(frozen=True)
class Capture:
    """The photos of a capture, and the largest number of Gaussians."""

    folder: str | None
    downscale: int
    max_splats: int


CAPTURES = {
    "bonsai": Capture("bonsai", 2, 60_000),
    "horns": Capture("llff_horns", 2, 30_000),
    "lego": Capture("lego", 4, 30_000),
    "sample": Capture(None, 1, 20_000),
}


# to compare with: sorted blending, never quantised, nothing pruned
SORTED = [
    "view_dependence.kind=constant",
    "blend=sorted",
    "schedule.quantize_from=1",
    "schedule.latents_from=1",
    "pruning.votes.quantile=0",
]
FREE = [
    "view_dependence.kind=free",
    "view_dependence.decoder_from=0.7",
]  # free lobes until 0.7 of the run
KLT = [
    "view_dependence.latents=18",
    "view_dependence.subvector_length=1",
    "view_dependence.codebook_size=16",
]
VARIANTS: dict[str, list[str]] = {
    # name: what differs from the preset's student, as for `mobilegs train --set`
    "sorted-1": [*SORTED, "color.degree=1"],
    "sorted-3": [*SORTED, "color.degree=3"],
    "chosen": [],
    "network": ["view_dependence.kind=network"],
    "fitted": ["view_dependence.decoder_from=0.5", "view_dependence.kind=fitted"],
    **{
        f"decoded-{d}": ["view_dependence.kind=decoded", f"view_dependence.degree={d}"]
        for d in (1, 2, 3)
    },
    **{f"free-{d}": [*FREE, f"view_dependence.degree={d}"] for d in (0, 1, 2, 3)},
    **{
        f"latent-{k}": ["view_dependence.kind=latent", f"view_dependence.latents={k}"]
        for k in (0, 1, 3, 5, 7, 9)
    },  # 13: chosen
    **{
        f"latent-9-degree-{d}": ["view_dependence.latents=9", f"view_dependence.degree={d}"]
        for d in (1, 3)
    },
    **{
        f"projected-{k}": ["view_dependence.kind=projected", f"view_dependence.latents={k}"]
        for k in (5, 9, 13)
    },
    # lobes are free first; latents then start along their principal directions
    "latent-9-principal": ["view_dependence.latents=9", "view_dependence.decoder_from=0.35"],
    "projected-9-principal": [
        "view_dependence.kind=projected",
        "view_dependence.latents=9",
        "view_dependence.decoder_from=0.35",
    ],
    # other ways to store free lobes
    "free-2-vq3": [
        *FREE,
        "view_dependence.subvector_length=3",
        "view_dependence.codebook_size=1024",
    ],
    "klt-scalar": ["view_dependence.kind=projected", "view_dependence.decoder_from=0.35", *KLT],
    # the form of the weight
    "exponent-2": ["weighting.exponent_max=2"],
    "exponent-8": ["weighting.exponent_max=8"],
    "exponent-14": ["weighting.exponent_max=14"],
    "free-2-decay": [*FREE, "ablation.lobe_decay=0.001"],
    # lobes pulled back into bounds along random directions, most of which no camera looked along
    "floor-2": [],
    "phi-0-8": [],
    # random noise on phi before its ReLU, new in every training image
    "noise-0.3": [],
    "noise-1": [],
}
BOUNDED = ("floor-2", "phi-0-8")
NOISE = {"noise-0.3": 0.3, "noise-1": 1.0}  # standard deviations
PULL = 0.1  # weight of the mean distance from those bounds; the loss is about 0.1


def open_capture(name: str, data: Path) -> Dataset:
    capture = CAPTURES[name]
    if capture.folder is None:
        return demo_capture()
    return load_capture(data / capture.folder, downscale=capture.downscale)


def recipe_of(name: str):
    recipe = demo_recipe() if CAPTURES[name].folder is None else cpu_recipe()
    teacher = replace(recipe.teacher, max_splats=CAPTURES[name].max_splats)
    return replace(recipe, teacher=teacher)


def teacher_of(name: str, dataset: Dataset, views: list[View], runs: Path) -> Scene:
    """Return the capture's teacher, from FOLDER or trained now."""
    path = runs / f"{name}.ply"
    if not path.exists():
        stage = Teacher(recipe_of(name).teacher, dataset, seed=0, device=torch.device("cpu"))
        while stage.done < stage.steps:
            [index] = view_order(len(views), stage.done, 1, 0)
            stage.advance([(index, views[index])])
            if stage.done % 500 == 0:
                print(f"{name}: teacher {stage.done} / {stage.steps}", flush=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_ply(path, stage.gaussians())
    gaussians, footprint = read_ply_scene(path)
    return Scene(gaussians, background=dataset.background, near=dataset.near, footprint=footprint)


def out_of_bounds(variant: str, lobes: Tensor, directions: Tensor) -> Tensor:
    """Return the distance of each Gaussian's `lobes` [n, m, 2] from the variant's bounds: [n]."""
    basis = sh_basis(directions, lobe_degree(lobes))
    logits, raw_phi = (basis[:, :, None] * lobes).sum(1).unbind(1)
    if variant == "floor-2":
        return (C0 * lobes[:, 0, 0] - 2 - logits).relu()
    return (-raw_phi).relu() + (raw_phi - 8).relu()


class BoundedStudent(Student):
    """A student whose lobes are pulled into bounds along one random direction in each step."""

    def __init__(self, variant: str, *given, seed: int, **named) -> None:
        super().__init__(*given, seed=seed, **named)
        directions = torch.Generator().manual_seed(seed)
        lobes_of = self.model.lobes

        def lobes(*inputs) -> Tensor:
            found = lobes_of(*inputs)
            if found.requires_grad:
                free = found.detach().requires_grad_()
                drawn = normalize(torch.randn(len(found), 3, generator=directions), dim=1)
                with torch.enable_grad():
                    distance = PULL * out_of_bounds(variant, free, drawn).mean()
                [pull] = torch.autograd.grad(distance, free)
                found.register_hook(lambda grad: grad + pull)
            return found

        self.model.lobes = lobes  # pyright: ignore[reportAttributeAccessIssue]


class NoisyStudent(Student):
    """A student whose weights carry random noise, new in each step."""

    def __init__(self, variant: str, *given, seed: int, **named) -> None:
        super().__init__(*given, seed=seed, **named)
        draws = torch.Generator().manual_seed(seed)
        lobes_of = self.model.lobes

        def lobes(*inputs) -> Tensor:
            found = lobes_of(*inputs)
            if not found.requires_grad:
                return found
            noise = torch.zeros_like(found)
            noise[:, 0, 1] = NOISE[variant] / C0 * torch.randn(len(found), generator=draws)
            return found + noise

        self.model.lobes = lobes  # pyright: ignore[reportAttributeAccessIssue]


def train(stage, views: list[View], *, seed: int) -> float:
    """Train to the end; return the processor's seconds per step."""
    started = time.process_time()
    while stage.done < stage.steps:
        [index] = view_order(len(views), stage.done, 1, 2 * seed + 1)
        stage.advance([(index, views[index])])
    return (time.process_time() - started) / stage.steps


def config_of(capture: str, variant: str) -> StudentConfig:
    """Return the student's preset with the paper's codebooks and the changes of a variant."""
    settings = (*CODEBOOKS, *(f"student.{setting}" for setting in VARIANTS[variant]))
    return with_settings(recipe_of(capture), settings).student


def multiply_adds(view: ViewDependence) -> int:
    """Return the multiply-adds per Gaussian and frame for opacity and phi."""
    if view.kind == "network":
        return 22 * 256 + 256 * 128 + 128 * 2  # its linear 64-wide layer is folded into the heads
    return (0, 3, 17, 38)[view.degree] + 2 * (view.degree + 1) ** 2  # harmonics, dot products


def cell(name: str, variant: str, seed: int, steps: int, world: tuple, lpips) -> dict:
    """Train one student and measure it."""
    dataset, views, teacher = world
    config = replace(config_of(name, variant), steps=steps)
    found: dict = {"steps": steps}
    cameras = [frame.camera for frame in dataset.train]
    kind: Callable[..., Student] = Student
    if variant in BOUNDED:
        kind = partial(BoundedStudent, variant)
    elif variant in NOISE:
        kind = partial(NoisyStudent, variant)
    stage = kind(config, teacher, cameras, extent=dataset.extent, seed=seed)
    found["cpu_seconds_per_step"] = round(train(stage, views, seed=seed), 4)
    if config.blend == "sorted":
        scene = stage.scene()
    else:
        found["multiply_adds"] = multiply_adds(config.view_dependence)
        data = pack(stage.quantized_scene())
        streams: dict[str, int] = {}
        for row in inspect(data)["streams"]:
            part = row["name"].split(".")[0]
            streams[part] = streams.get(part, 0) + row["bytes"]
        found |= {"file_bytes": len(data), "streams": streams}
        scene = unpack(data).decode()
    found["gaussians"] = len(scene.gaussians)
    found |= {key: value for key, value in evaluate(scene, dataset).items() if key != "views"}
    if lpips is not None:
        some = replace(dataset, test=dataset.test[::LPIPS_EVERY])
        found["lpips_vgg"] = evaluate(scene, some, lpips=lpips)["lpips_vgg"]
    return found


def study(options: argparse.Namespace, result: dict, save: Callable[[], None]) -> None:
    data = Path(os.environ.get("MOBILEGS_DATA", "."))
    lpips = lpips_from(str(data / "lpips")) if (data / "lpips").exists() else None
    for name in options.captures:
        dataset = open_capture(name, data)
        views = [load_view(frame) for frame in dataset.train]
        world = (dataset, views, teacher_of(name, dataset, views, options.runs))
        if f"{name}/teacher" not in result["cells"]:
            figures = evaluate(world[2], dataset)
            figures.pop("views")
            size = [dataset.train[0].camera.width, dataset.train[0].camera.height]
            count = len(world[2].gaussians)
            result["cells"][f"{name}/teacher"] = {**figures, "image_size": size, "gaussians": count}
        for variant in options.variants or VARIANTS:
            for seed in options.seeds:
                key = f"{name}/{options.steps}/{variant}/{seed}"
                if key in result["cells"]:
                    continue
                found = cell(name, variant, seed, options.steps, world, lpips)
                result["cells"][key] = found
                save()
                print(key, json.dumps(found), flush=True)


def speed(options: argparse.Namespace, result: dict) -> None:
    """Time a training step of each variant in each phase, votes included."""
    data = Path(os.environ.get("MOBILEGS_DATA", "."))
    dataset = open_capture("bonsai", data)
    views = [load_view(frame) for frame in dataset.train]
    teacher = teacher_of("bonsai", dataset, views, options.runs)
    timed = list(enumerate(views))[::TIMED_EVERY]
    cameras = [frame.camera for frame in dataset.train]
    forms = {
        "explicit": {},
        "networks": {"latents_from": 0.0},
        "codes": {"latents_from": 0.0, "quantize_from": 0.0},
    }
    for form, changes in forms.items():
        students = {}
        for name in dict.fromkeys(["network", *(options.variants or TIMED)]):
            config = config_of("bonsai", name)
            view = config.view_dependence
            if form == "codes":
                view = replace(view, decoder_from=0.0)
            schedule = replace(config.schedule, **changes)
            config = replace(config, view_dependence=view, schedule=schedule)
            students[name] = Student(config, teacher, cameras, extent=dataset.extent, seed=0)
        times = {name: [] for name in students}
        for index, view in timed:
            for name, student in students.items():
                student.teacher_images.get(index, view.camera)
                started = time.perf_counter()
                student.advance([(index, view)])
                times[name].append(1e3 * (time.perf_counter() - started))
        for name, found in times.items():
            row = {"ms": round(statistics.median(found[3:]), 1)}
            row["of_network"] = round(
                statistics.median(
                    a / b for a, b in zip(found[3:], times["network"][3:], strict=True)
                ),
                3,
            )
            result["speed"][f"{form}/{name}"] = row
            print(form, name, row, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, default=Path("view_dependence.json"))
    parser.add_argument("--runs", type=Path, default=Path("runs/view_dependence"))
    parser.add_argument("--captures", nargs="+", default=list(CAPTURES), choices=CAPTURES)
    parser.add_argument("--variants", nargs="+", choices=VARIANTS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1])
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--speed", action="store_true", help="time training steps instead")
    options = parser.parse_args()
    result: dict = {"cells": {}, "speed": {}}
    if options.json.exists():
        result = json.loads(options.json.read_text())

    def save() -> None:
        result["date"] = time.strftime("%Y-%m-%d")
        result["machine"] = f"{platform.machine()}, {os.cpu_count()} cores, {kernel_level()}"
        result["torch"] = torch.__version__
        cells = dict(sorted(result["cells"].items()))
        options.json.write_text(json.dumps({**result, "cells": cells}, indent=1) + "\n")

    if options.speed:
        speed(options, result)
    else:
        study(options, result, save)
    save()


if __name__ == "__main__":
    main()
