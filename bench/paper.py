"""The paper's tables on any of its captures: scenes x rows x seeds, from one command.

    python bench/paper.py --data DIR --scenes mipnerf360 tandt db --rows teacher ours network
    python bench/paper.py --scenes small --rows all --set student.steps=1200
    python bench/paper.py --list

DIR (default: MOBILEGS_DATA) holds the captures as their authors pack them: 360_v2/bicycle or
mipnerf360/bicycle or bicycle; tandt/train; db/playroom; what is missing is named and left out.
`--protocol paper` shows photos at most 1600 pixels wide, as the paper's release does; `standard`
takes images_4 outdoors and images_2 indoors, as most others do. Every eighth photo is held back.

All rows of a scene learn from the same teacher (that of `--teacher-seed`), which is kept in RUNS
with everything else: checkpoints, previews, scene.mgs and cell.json of each cell. What is there is
not repeated, so the command can be interrupted and given again; `--json` collects the cells. They
are told apart by row, steps and seed: what else `--set` changes wants RUNS of its own.
bench/paper_report.py makes tables and plots of it. bench/paper_rows.py has the rows.
"""

import argparse
import json
import os
import platform
import signal
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from paper_rows import ROWS, Row

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera
from mobilegs.compress.container import read_mgs, write_mgs
from mobilegs.data import Dataset, ViewLoader, load_capture
from mobilegs.errors import InputError
from mobilegs.evaluate.lpips import lpips_from
from mobilegs.evaluate.report import evaluate, peak_memory_mib, to_json
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.render.kernels.cpu import kernel_level
from mobilegs.render.scene import Scene
from mobilegs.scene_file import choose_device
from mobilegs.train.distributed import Team
from mobilegs.train.loop import Session, TrainRun, run_stage
from mobilegs.train.progress import Monitor
from mobilegs.train.recipes import (
    RECIPES,
    PresetName,
    Recipe,
    with_method,
    with_settings,
    with_steps,
)
from mobilegs.train.run_folder import RunFolder
from mobilegs.train.stage import Stage
from mobilegs.train.student import Student
from mobilegs.train.teacher import Teacher

TIMED_VIEWS = 16
FEW_LPIPS = 4  # with --few-lpips, of the held-back photos one in so many


@dataclass(frozen=True)
class Place:
    """A capture, where it may lie, and how it is used."""

    group: str
    folders: tuple[str, ...]
    downscale: int | None
    """What the photos' size is divided by; None: at most 1600 pixels wide."""
    metric: str = "indoor"
    """Of the importance that simplification goes by."""
    preset: PresetName = "gpu"
    settings: tuple[str, ...] = ()


def _standard(group: str, parents: tuple[str, ...], scenes: dict[str, tuple[str, int | None]]):
    return {
        name: Place(group, (*(f"{parent}/{name}" for parent in parents), name), downscale, metric)
        for name, (metric, downscale) in scenes.items()
    }


def _small(most: int) -> tuple[str, ...]:
    """Mini-Splatting leaves half of its budget, and 5,000 steps are too few for it."""
    return ("teacher.steps=10000", f"teacher.max_splats={most}")


OUTDOOR, INDOOR = ("outdoor", 4), ("indoor", 2)
PLACES: dict[str, Place] = {
    **_standard(
        "mipnerf360",
        ("mipnerf360", "360_v2", "360"),
        {
            **dict.fromkeys(("bicycle", "flowers", "garden", "stump", "treehill"), OUTDOOR),
            **dict.fromkeys(("room", "counter", "kitchen", "bonsai"), INDOOR),
        },
    ),
    **_standard(
        "tandt",
        ("tandt", "tanks_and_temples", "tandt_db/tandt"),
        dict.fromkeys(("train", "truck"), ("outdoor", None)),
    ),
    **_standard(
        "db",
        ("db", "deep_blending", "tandt_db/db"),
        dict.fromkeys(("drjohnson", "playroom"), ("indoor", None)),
    ),
    # what two cores can do, and the same captures at their full size for a GPU
    "bonsai-400": Place("small", ("bonsai",), 2, preset="cpu", settings=_small(100_000)),
    "horns-250": Place("small", ("llff_horns",), 2, preset="cpu", settings=_small(60_000)),
    "lego-200": Place("small", ("lego",), 4, preset="cpu", settings=_small(60_000)),
    "bonsai-800": Place("full", ("bonsai",), 1),
    "horns-499": Place("full", ("llff_horns",), 1),
    "lego-800": Place("full", ("lego",), 1),
}


def found_in(data: Path, place: Place) -> Path | None:
    """The first of a place's folders that is there."""
    return next((data / name for name in place.folders if (data / name).is_dir()), None)


def recipe_of(place: Place, row: Row, options: argparse.Namespace) -> Recipe:
    """The preset with all that place, row and command line change."""
    recipe = with_method(RECIPES[place.preset](), row.teacher)
    if options.steps:
        recipe = with_steps(recipe, options.steps)
    metric = f"teacher.mini_splatting.metric={place.metric}"
    return with_settings(recipe, (metric, *place.settings, *row.settings, *options.set))


@dataclass(frozen=True)
class Work:
    """What all cells of a place share."""

    name: str
    place: Place
    capture: Path
    dataset: Dataset
    loader: ViewLoader
    team: Team
    options: argparse.Namespace


def trained(stage: Stage, folder: Path, work: Work, *, order_seed: int) -> float:
    """Train a stage, from a checkpoint if there is one; returns the seconds of all sessions."""
    kept = RunFolder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    kept.previews.mkdir(exist_ok=True)
    saved = kept.saved() or {"stage": None, "seconds": {}, "journal": []}
    run = TrainRun(work.capture, folder)
    with Monitor(kept.journal, saved["journal"], saved["seconds"]) as monitor:
        session = Session(run, kept, work.dataset, work.loader, monitor, None, work.team, saved)
        run_stage(stage, session, order_seed=order_seed)
        return monitor.seconds[stage.name]


def teacher_of(row: Row, seed: int, work: Work) -> tuple[Scene, float, Path]:
    """The teacher of a row, its seconds, and where it lies; trained now if it is not there."""
    config = recipe_of(work.place, replace(row, settings=()), work.options).teacher
    folder = work.options.runs / work.name / f"teacher-{row.teacher}-{config.steps}-{seed}"
    ply, note = folder / "teacher.ply", folder / "seconds.json"
    if not ply.exists():
        device = work.team.device
        stage = Teacher(config, work.dataset, seed=seed, device=device)
        seconds = trained(stage, folder, work, order_seed=2 * seed)
        atomic_write(note, json.dumps(seconds))
        write_ply(ply, stage.gaussians())
        RunFolder(folder).finish()
    scene = Scene(
        read_ply(ply).to(work.team.device),
        background=work.dataset.background.to(work.team.device),
        near=work.dataset.near,
    )
    return scene, json.loads(note.read_text()), ply


def steps_of(name: str, recipe: Recipe) -> tuple[int, int]:
    """Of the teacher, and of the student if the row has one."""
    return recipe.teacher.steps, recipe.student.steps if ROWS[name].student else 0


def folder_of(name: str, place: str, seed: int, options: argparse.Namespace) -> Path:
    """Where a cell lies."""
    steps = sum(steps_of(name, recipe_of(PLACES[place], ROWS[name], options)))
    return options.runs / place / f"{name}-{steps}-{seed}"


def float_bytes(scene: Scene) -> int:
    """Of a scene's numbers, four bytes each."""
    numbers = sum(tensor.numel() for tensor in scene.gaussians.tensors().values())
    if scene.lobes is not None:  # they hold the opacity, too
        numbers += scene.lobes.numel() - len(scene.gaussians)
    if scene.network is not None:
        numbers += sum(parameter.numel() for parameter in scene.network.parameters())
    return 4 * numbers


@torch.inference_mode()
def frame_ms(scene: Scene, cameras: list[Camera]) -> float:
    """Median milliseconds of a whole frame by the training's kernels, view dependence included."""
    device = scene.gaussians.means.device
    times = []
    for camera in [cameras[0], *cameras[:TIMED_VIEWS]]:
        camera = camera.to(device)
        started = time.perf_counter()
        scene.render(camera)
        if device.type == "cuda":
            torch.cuda.synchronize()
        times.append(1e3 * (time.perf_counter() - started))
    return statistics.median(times[1:])


def figures(scene: Scene, work: Work, lpips) -> dict:
    """What is measured of every scene."""
    cameras = [frame.camera for frame in work.dataset.test]
    found = evaluate(scene, work.dataset, lpips=None if work.options.few_lpips else lpips)
    if work.options.few_lpips and lpips is not None:
        some = replace(work.dataset, test=work.dataset.test[::FEW_LPIPS])
        again = evaluate(scene, some, lpips=lpips)
        found |= {name: value for name, value in again.items() if name.startswith("lpips")}
    found.pop("views")
    return {
        "gaussians": len(scene.gaussians),
        **{name: value for name, value in found.items() if value is not None},
        "frame_ms": round(frame_ms(scene, cameras), 2),
    }


def cell(name: str, seed: int, work: Work, lpips) -> dict:
    """One row on one scene with one seed, from its teacher to its figures."""
    row, options, dataset = ROWS[name], work.options, work.dataset
    folder = folder_of(name, work.name, seed, options)
    recipe = recipe_of(work.place, row, options)
    teacher_steps, student_steps = steps_of(name, recipe)
    camera = dataset.test[0].camera
    about = {
        "scene": work.name,
        "row": name,
        "seed": seed,
        "image_size": [camera.width, camera.height],
        "teacher_steps": teacher_steps,
        "student_steps": student_steps,
    }
    if not row.student:
        scene, seconds, ply = teacher_of(row, seed, work)
        return about | {
            "seconds": round(seconds),
            "bytes": ply.stat().st_size,
            **figures(scene, work, lpips),
        }
    teacher, seconds, _ = teacher_of(row, options.teacher_seed, work)
    cameras = [frame.camera for frame in dataset.train]
    stage = Student(recipe.student, teacher, cameras, extent=dataset.extent, seed=seed)
    spent = trained(stage, folder, work, order_seed=2 * seed + 1)
    if row.coded:
        path = folder / "scene.mgs"
        write_mgs(path, stage.coded(views=cameras[:1]))
        scene, size = read_mgs(path).decode(work.team.device), path.stat().st_size
    else:
        scene = stage.scene()
        size = float_bytes(scene)
    found = {"teacher_seed": options.teacher_seed, "teacher_seconds": round(seconds)}
    found |= {"seconds": round(spent), "bytes": size, **figures(scene, work, lpips)}
    RunFolder(folder).finish()
    return about | found


def opened(options: argparse.Namespace) -> Iterator[tuple[str, Place, Path]]:
    """The places asked for whose captures are there."""
    for name, place in PLACES.items():
        if not {name, place.group} & set(options.scenes):
            continue
        capture = found_in(options.data, place)
        if capture is None:
            print(f"{name}: left out, {options.data} has none of {', '.join(place.folders)}")
            continue
        if options.protocol == "paper" and place.group == "mipnerf360":
            place = replace(place, downscale=None)
        yield name, place, capture


def run(options: argparse.Namespace) -> None:
    """All cells asked for that are not there yet."""
    weights = options.data / "lpips" if (options.data / "lpips").is_dir() else None
    lpips = lpips_from(None if weights is None else str(weights))
    team = Team(choose_device("auto"))
    rows = list(ROWS) if options.rows == ["all"] else options.rows
    begun = time.monotonic()
    for name, place, capture in opened(options):
        missing = [
            (row, seed, folder_of(row, name, seed, options) / "cell.json")
            for row in rows
            for seed in options.seeds
        ]
        missing = [each for each in missing if not each[2].exists()]
        if not missing:
            continue
        dataset = load_capture(capture, downscale=place.downscale)
        with ViewLoader(dataset.train) as loader:
            work = Work(name, place, capture, dataset, loader, team, options)
            for row, seed, path in missing:
                if options.minutes and time.monotonic() - begun > 60 * options.minutes:
                    return
                found = cell(row, seed, work, lpips)
                found |= {"device": device_name(team), "date": time.strftime("%Y-%m-%d")}
                found["peak_memory_mib"] = peak_memory_mib()
                atomic_write(path, to_json(found) + "\n")
                print(f"{name} {row} {seed}: {found['psnr']:.2f} dB, {found['bytes']:,} bytes")


def device_name(team: Team) -> str:
    """What computed."""
    if team.device.type == "cuda":
        return torch.cuda.get_device_name(team.device)
    return f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}"


def collect(runs: Path, out: Path) -> None:
    """All cells under RUNS, and what OUT had beside them, in one file."""
    cells = json.loads(out.read_text())["cells"] if out.exists() else {}
    for path in sorted(runs.glob("*/*/cell.json")):
        found = json.loads(path.read_text())
        steps = found["teacher_steps"] + found["student_steps"]
        cells[f"{found['scene']}/{steps}/{found['row']}/{found['seed']}"] = found
    ordered = dict(sorted(cells.items()))
    atomic_write(out, json.dumps({"cells": ordered, "torch": torch.__version__}, indent=1) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--runs", type=Path, default=Path("runs/paper"))
    parser.add_argument("--json", type=Path, help="collect all cells here")
    groups = sorted({place.group for place in PLACES.values()})
    parser.add_argument(
        "--scenes", nargs="+", default=["small"], choices=[*PLACES, *groups], metavar="SCENE"
    )
    parser.add_argument(
        "--rows", nargs="+", default=["teacher", "ours"], choices=["all", *ROWS], metavar="ROW"
    )
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--teacher-seed", type=int, default=0)
    parser.add_argument("--steps", type=int, help="of teacher and student together")
    parser.add_argument("--set", nargs="+", default=[], metavar="PATH=VALUE")
    parser.add_argument("--protocol", choices=["paper", "standard"], default="paper")
    parser.add_argument("--few-lpips", action="store_true", help="LPIPS of one photo in four")
    parser.add_argument("--minutes", type=float, help="begin no cell after so many")
    parser.add_argument("--list", action="store_true", help="say which scenes and rows there are")
    options = parser.parse_args()
    if options.list:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` ends it without a word
        for name, place in PLACES.items():
            print(f"{place.group:<11} {name:<12} {place.folders[0]}")
        for name, row in ROWS.items():
            print(f"{row.table:<11} {name:<26} {row.about}")
        return
    if options.data is None:
        sys.exit("say where the captures are: --data DIR, or MOBILEGS_DATA")
    options.data = Path(options.data)
    try:
        run(options)
    except InputError as error:
        sys.exit(str(error))
    finally:
        if options.json:
            collect(options.runs, options.json)


if __name__ == "__main__":
    main()
