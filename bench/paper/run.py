"""Make cells of the paper's tables: scenes x rows x seeds.

    python -m bench.paper.run --data DIR --scenes mipnerf360 tandt db --rows teacher ours codebooks
    python -m bench.paper.run --scenes small --rows all --set student.steps=1200
    python -m bench.paper.run --list

DIR (default: MOBILEGS_DATA) holds the captures as their authors pack them: 360_v2/bicycle,
mipnerf360/bicycle or bicycle; tandt/train; db/playroom. The script names captures that are
missing and goes on without them. `--protocol paper` uses photos at most 1600 pixels wide, as the
paper's release does; `--protocol standard` uses images_4 outdoors and images_2 indoors, as most
papers do. Every eighth photo is held back.

All rows of a scene learn from the same teacher (seed: `--teacher-seed`). RUNS keeps the teacher,
checkpoints, previews, scene.mgs and cell.json of each cell. A finished cell is not repeated, so
the command resumes. `--json` collects all cells. A cell that fails leaves error.txt in its
folder; the others are made, and the exit code is 1. bench/paper/report.py makes tables and plots.
"""

import argparse
import json
import os
import platform
import shutil
import signal
import statistics
import sys
import time
import traceback
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import torch

from bench.paper.captures import CAPTURES, BenchCapture, find_capture, with_protocol
from bench.paper.cells import (
    CELL,
    ERROR,
    as_json,
    begin_folder,
    cell_identity,
    collect,
    folder_of,
    is_done,
    recipe_of,
    teacher_folder,
)
from bench.paper.huffman import huffman_bytes
from bench.paper.rows import ARCHIVED, BASE, ROWS, Row
from bench.paper.student import student_class
from bench.record import commit
from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera
from mobilegs.csrc.binding import kernel_build
from mobilegs.data import Dataset, ViewLoader, load_capture
from mobilegs.device import choose_device
from mobilegs.errors import InputError
from mobilegs.evaluate.front import lost_in_front
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.report import evaluate, peak_memory_mib, to_json
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.mgs.codec import inspect_mgs, read_mgs, write_mgs
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import Team
from mobilegs.train.loop import train_stage
from mobilegs.train.memory import keep_freed_memory
from mobilegs.train.monitor import Monitor
from mobilegs.train.run_dir import Checkpoint, RunDir, StopRequest
from mobilegs.train.stage import Stage
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher

TIMED_VIEWS = 16
TIMED_FRAMES = 4  # of each; the first one warms up
USUAL = ["teacher", "ours", BASE]
ARC = 8  # an arc has every ARC-th photo
FRONT_EVERY = 3  # light lost in front is measured in every 3rd held-back photo
FORK = "before_quantization"  # of a cell: the folder of a checkpoint
FEW_LPIPS = 4  # with --few-lpips, LPIPS of every 4th held-back photo


@dataclass(frozen=True)
class Work:
    """The inputs that all cells of a scene share."""

    name: str
    place: BenchCapture
    capture: Path
    dataset: Dataset
    loader: ViewLoader
    team: Team
    options: argparse.Namespace


@dataclass(frozen=True)
class KeepFork:
    """Keeps the student as it is before quantisation, for rows that go on from there."""

    folder: Path
    monitor: Monitor

    def show(self, dataset: Dataset) -> None:
        """Do nothing: there is nothing to see."""

    def after_step(self, stage: Stage, stop: StopRequest) -> None:
        """Save the state after the last step without quantisation."""
        if isinstance(stage, Student) and stage.phase == "quantized" != stage.model.phase:
            self.folder.mkdir(exist_ok=True)
            monitor = self.monitor
            state = Checkpoint(stage.name, stage.state(), monitor.seconds, monitor.rows)
            RunDir(self.folder).save_checkpoint(state)


def begin_fork(name: str, seed: int, folder: Path, work: Work) -> None:
    """Give a row that shares another one's student the checkpoint of that, before its first step.

    Raises InputError if the other row has not come so far.
    """
    own = RunDir(folder).checkpoint
    of = folder_of(ROWS[name].fork, work.name, work.place, seed, work.options) / FORK
    if own.exists():
        return
    if not RunDir(of).checkpoint.exists():
        raise InputError(f"make the row {ROWS[name].fork} first: {of} has no checkpoint")
    shutil.copyfile(RunDir(of).checkpoint, own)


def trained(
    stage: Stage, folder: Path, work: Work, *, order_seed: int, keep: bool = False
) -> float:
    """Train a stage, from its checkpoint if there is one; return the seconds of all sessions.

    `keep` keeps the state before quantisation.
    """
    run_dir = RunDir(folder)
    folder.mkdir(parents=True, exist_ok=True)
    run_dir.previews.mkdir(exist_ok=True)
    saved = run_dir.load_checkpoint()
    with Monitor(run_dir.log, saved.log, saved.seconds) as monitor:
        train_stage(
            stage,
            work.loader,
            run_dir,
            monitor,
            work.team,
            resume_from=saved,
            order_seed=order_seed,
            preview_frame=work.dataset.test[0],
            live=KeepFork(folder / FORK, monitor) if keep else None,
        )
        return monitor.seconds[stage.name]


def teacher_of(row: Row, seed: int, work: Work) -> tuple[Scene, float, Path]:
    """Return a row's teacher, its seconds and its path; train it if it is missing."""
    of = replace(row, settings=(), student=False)
    recipe = recipe_of(work.place, of, work.options)
    steps = recipe.teacher.steps
    folder = teacher_folder(row, work.name, work.place, seed, steps, work.options)
    begin_folder(folder, as_json(recipe, of, protocol=work.place.protocol, seed=seed))
    ply, note = folder / "teacher.ply", folder / "seconds.json"
    if not ply.exists():
        device = work.team.device
        stage = Teacher(recipe.teacher, work.dataset, seed=seed, device=device)
        seconds = trained(stage, folder, work, order_seed=2 * seed)
        atomic_write(note, json.dumps(seconds))
        write_ply(ply, stage.gaussians(), footprint=recipe.teacher.scene_footprint)
        RunDir(folder).remove_checkpoint()
    gaussians, footprint = read_ply_scene(ply)
    scene = Scene(
        gaussians.to(work.team.device),
        footprint=footprint,
        background=work.dataset.background.to(work.team.device),
        near=work.dataset.near,
    )
    return scene, json.loads(note.read_text()), ply


def float_bytes(scene: Scene) -> int:
    """Return the bytes of a scene's tensors as float32."""
    numbers = sum(tensor.numel() for tensor in scene.gaussians.tensors().values())
    if scene.lobes is not None:  # they hold the opacity, too
        numbers += scene.lobes.numel() - len(scene.gaussians)
    if scene.network is not None:
        numbers += sum(parameter.numel() for parameter in scene.network.parameters())
    return 4 * numbers


def index_bytes(path: Path, coded: QuantizedScene) -> dict[str, int]:
    """Return the bytes of the indices in a file, and those that Huffman codes would take."""
    huffman = huffman_bytes(coded)
    rows = inspect_mgs(path)["streams"]
    return {
        "index_bytes": sum(row["bytes"] for row in rows if row["name"] in huffman),
        "huffman_bytes": sum(huffman.values()),
    }


@torch.inference_mode()
def frame_ms(scene: Scene, cameras: list[Camera]) -> float:
    """Return the milliseconds of a whole frame by the training kernels, view dependence included.

    The value is the median over views of the fastest of a few frames.
    """
    device = scene.gaussians.means.device

    def frame(camera: Camera) -> float:
        started = time.perf_counter()
        scene.render(camera)
        if device.type == "cuda":
            torch.cuda.synchronize()
        return 1e3 * (time.perf_counter() - started)

    views = [camera.to(device) for camera in cameras[:TIMED_VIEWS]]
    return statistics.median(min(frame(view) for _ in range(TIMED_FRAMES)) for view in views)


def figures(
    scene: Scene, work: Work, lpips: LpipsSuite | None, teacher: Scene | None = None
) -> dict:
    """Measure a scene on the held-back photos; a teacher gives the surfaces for `front`."""
    test = work.dataset.test
    some = test[::FEW_LPIPS] if work.options.few_lpips else test
    found = evaluate(scene, work.dataset, lpips=lpips if some is test else None)
    if some is not test and lpips is not None:
        again = evaluate(scene, replace(work.dataset, test=some), lpips=lpips)
        found |= {name: value for name, value in again.items() if name.startswith("lpips")}
    found.pop("views")
    teacher = scene if teacher is None else teacher
    cameras = [frame.camera for frame in test[::FRONT_EVERY]]
    front = lost_in_front(teacher, {"scene": scene}, cameras)["scene"]
    return {
        "gaussians": len(scene.gaussians),
        **{name: value for name, value in found.items() if value is not None},
        "photos": len(test),
        **({} if lpips is None else {"lpips_photos": len(some)}),
        "frame_ms": round(frame_ms(scene, [frame.camera for frame in test]), 2),
        **({} if front is None else {"front": front}),
    }


def cell(name: str, seed: int, folder: Path, work: Work, lpips: LpipsSuite | None) -> dict:
    """Make one cell: teacher, student, figures."""
    row, options, dataset = ROWS[name], work.options, work.dataset
    recipe = recipe_of(work.place, row, options)
    camera = dataset.test[0].camera
    of = {"image_size": [camera.width, camera.height]}
    if not row.student:
        scene, seconds, ply = teacher_of(row, seed, work)
        size = ply.stat().st_size
        return of | {"seconds": round(seconds), "bytes": size, **figures(scene, work, lpips)}
    if row.fork:
        begin_fork(name, seed, folder, work)
    teacher, seconds, ply = teacher_of(row, options.teacher_seed, work)
    cameras = [frame.camera for frame in dataset.train]
    student = student_class(row.method)
    stage = student(recipe.student, teacher, cameras, extent=dataset.extent, seed=seed)
    keep = any(other.fork == name for other in ROWS.values())
    spent = trained(stage, folder, work, order_seed=2 * seed + 1, keep=keep)
    if row.coded:
        path = folder / "scene.mgs"
        write_mgs(path, stage.quantized_scene(views=cameras[:1]))
        coded, size = read_mgs(path), path.stat().st_size
        of |= index_bytes(path, coded)
        scene = coded.decode(work.team.device)
    else:
        scene = stage.scene()
        size = float_bytes(scene)
    found = of | {"teacher_seconds": round(seconds), "seconds": round(spent), "bytes": size}
    if row.coded and scene.network is not None:  # the file rounds it to float16
        exact = evaluate(replace(scene, network=stage.model.network), dataset)
        found["psnr_float32_network"] = exact["psnr"]
    found["teacher_crc"] = zlib.crc32(ply.read_bytes())  # cells may be of several trainings of it
    found |= figures(scene, work, lpips, teacher)
    RunDir(folder).remove_checkpoint()
    return found


def hold_arc(dataset: Dataset) -> Dataset:
    """Return the capture with the photos nearest to the first one held back, an eighth of all."""
    frames = sorted([*dataset.train, *dataset.test], key=lambda frame: frame.name)
    positions = torch.stack([frame.camera.position for frame in frames])
    nearest = (positions - positions[0]).norm(dim=1).argsort(stable=True)
    held = set(nearest[: len(frames) // ARC].tolist())
    train = [frame for at, frame in enumerate(frames) if at not in held]
    return replace(dataset, train=train, test=[frames[at] for at in sorted(held)])


def present_captures(options: argparse.Namespace) -> Iterator[tuple[str, BenchCapture, Path]]:
    """Yield the requested captures that exist."""
    for name, place in CAPTURES.items():
        if not {name, place.group} & set(options.scenes):
            continue
        capture = find_capture(options.data, place)
        if capture is None:
            print(f"{name}: left out, {options.data} has none of {', '.join(place.folders)}")
            continue
        yield name, with_protocol(place, options.protocol), capture


@dataclass(frozen=True)
class CellSpec:
    """A requested cell."""

    row: str
    seed: int
    scene: str
    place: BenchCapture
    options: argparse.Namespace

    @property
    def folder(self) -> Path:
        """The folder of the cell."""
        return folder_of(self.row, self.scene, self.place, self.seed, self.options)

    def identity(self) -> dict:
        """The fields that identify the cell."""
        return cell_identity(self.row, self.scene, self.place, self.seed, self.options)

    def recipe(self) -> dict:
        """Everything that the cell depends on."""
        recipe = recipe_of(self.place, ROWS[self.row], self.options)
        seeds = {"protocol": self.place.protocol, "seed": self.seed}
        if ROWS[self.row].student:
            seeds["teacher_seed"] = self.options.teacher_seed
        return as_json(recipe, ROWS[self.row], **seeds)

    def is_done(self) -> bool:
        """Return whether the cell exists; raises InputError if another one has its folder."""
        return is_done(self.folder, self.identity(), self.recipe())


def measure(wanted: CellSpec, work: Work, lpips: LpipsSuite | None) -> None:
    """Make a cell and write its figures into its folder."""
    folder = wanted.folder
    begin_folder(folder, wanted.recipe())
    known = reset_peak_memory(work.team.device)
    found = wanted.identity() | cell(wanted.row, wanted.seed, folder, work, lpips)
    found |= {"device": device_name(work.team), "date": time.strftime("%Y-%m-%d")}
    found["commit"] = commit()
    if known:
        found["cell_peak_memory_mib"] = peak_memory_mib()
    atomic_write(folder / CELL, to_json(found) + "\n")
    (folder / ERROR).unlink(missing_ok=True)
    print(f"{folder}: {found['psnr']:.2f} dB, {found['bytes']:,} bytes", flush=True)


def reset_peak_memory(device: torch.device) -> bool:
    """Reset the process's peak memory; return False where the system does not allow it."""
    if device.type == "cuda":
        torch.cuda.reset_peak_memory_stats(device)
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return False
    return True


@contextmanager
def noting_failure(name: str, folder: Path | None, failed: list[str]) -> Iterator[None]:
    """Note an exception, in the folder too, and go on."""
    try:
        yield
    except Exception as error:  # whatever breaks one cell must not cost the others
        failed.append(name)
        print(f"{name}: {error}", file=sys.stderr)
        if folder is not None:
            atomic_write(folder / ERROR, traceback.format_exc())


def run(options: argparse.Namespace) -> list[str]:
    """Make all requested cells that are missing; return the names of those that failed."""
    weights = options.data / "lpips" if (options.data / "lpips").is_dir() else None
    lpips = lpips_from(None if weights is None else str(weights))
    team = Team(choose_device("auto"))
    rows = options.rows
    if rows == ["all"]:
        rows = [name for name, row in ROWS.items() if not row.archived]
    if archived := [name for name in rows if ROWS[name].archived]:
        raise InputError(f"archived: make {', '.join(archived)} with the commit {ARCHIVED}")
    begun, failed = time.monotonic(), []
    for name, place, capture in present_captures(options):
        missing: list[CellSpec] = []
        for row in rows:
            for seed in options.seeds:
                wanted = CellSpec(row, seed, name, place, options)
                with noting_failure(f"{name} {row} {seed}", None, failed):
                    if not wanted.is_done():
                        missing.append(wanted)
        if not missing:
            continue
        with noting_failure(name, None, failed):
            dataset = load_capture(capture, downscale=place.downscale)
            dataset = hold_arc(dataset) if place.arc else dataset
            with ViewLoader(dataset.train) as loader:
                work = Work(name, place, capture, dataset, loader, team, options)
                for wanted in missing:
                    if options.minutes and time.monotonic() - begun > 60 * options.minutes:
                        return failed
                    with noting_failure(
                        f"{name} {wanted.row} {wanted.seed}", wanted.folder, failed
                    ):
                        measure(wanted, work, lpips)
    return failed


def device_name(team: Team) -> str:
    """Return the name of the device."""
    if team.device.type == "cuda":
        return torch.cuda.get_device_name(team.device)
    return f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_build()}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--runs", type=Path, default=Path("runs/paper"))
    parser.add_argument("--json", type=Path, help="collect all cells here")
    groups = sorted({place.group for place in CAPTURES.values()})
    parser.add_argument(
        "--scenes", nargs="+", default=["small"], choices=[*CAPTURES, *groups], metavar="SCENE"
    )
    parser.add_argument("--rows", nargs="+", default=USUAL, choices=["all", *ROWS], metavar="ROW")
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--teacher-seed", type=int, default=0)
    parser.add_argument("--steps", type=int, help="of teacher and student together")
    parser.add_argument("--set", nargs="+", default=[], metavar="PATH=VALUE")
    parser.add_argument("--protocol", choices=["paper", "standard"], default="paper")
    parser.add_argument("--few-lpips", action="store_true", help="LPIPS of one photo in four")
    parser.add_argument("--minutes", type=float, help="start no cell after this time")
    parser.add_argument("--list", action="store_true", help="say which scenes and rows there are")
    options = parser.parse_args()
    if options.list:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` ends it without a word
        for name, place in CAPTURES.items():
            print(f"{place.group:<11} {name:<12} {place.folders[0]}")
        for name, row in ROWS.items():
            more = f" (archived: commit {ARCHIVED})" if row.archived else ""
            print(f"{row.table:<11} {name:<26} {row.about}{more}")
        return
    if options.data is None:
        sys.exit("say where the captures are: --data DIR, or MOBILEGS_DATA")
    options.data = Path(options.data)
    failed = []
    keep_freed_memory()  # as `mobilegs train` does
    try:
        failed = run(options)
    except InputError as error:
        sys.exit(str(error))
    finally:
        if options.json:
            collect(options.runs, options.json)
    if failed:
        sys.exit(f"not done, see {ERROR} in their folders: {', '.join(failed)}")


if __name__ == "__main__":
    main()
