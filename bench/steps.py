"""Profile steps in the middle of a long run, each part of it by itself.

    python -m bench.steps CAPTURE TEACHER.ply [--downscale 2] [--device cuda] [--beside 6 8]
        [--json OUT]

Each stage has 30,000 steps of the preset `--preset`, and starts from the Gaussians of TEACHER.ply.
Nothing is trained: a part begins at its time, between two votes, with what the schedule brings
then. The steps are a multiple of 4, so that rarer terms have their usual share.

| figure | meaning |
|---|---|
| ms | of a step, the median of 5 rounds of `--steps` steps |
| reference_ms | on a CPU: of the same step through the reference in PyTorch, in turn with it |
| beside_N | beside N busy programs: the speed as a share of k / (k + N) of that alone |
| operations | of torch that read or write memory; nearly the same on every device |
| native | calls of the C++ library; 0 on a GPU |
| megabytes | that operations of torch read and write |
| host_reads | values that Python waits for: on a GPU each empties its queue |
| launches, gpu_ms | on a GPU: kernels started, and their time |
"""

import argparse
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import torch
from torch import Tensor
from torch._C._autograd import DeviceType
from torch.profiler import ProfilerActivity, profile
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from bench.record import Figures
from mobilegs import load_capture
from mobilegs.csrc import binding
from mobilegs.data.dataset import Dataset, ViewLoader
from mobilegs.formats.ply import read_ply_scene
from mobilegs.render.kernels import cpu
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import Team
from mobilegs.train.loop import next_views
from mobilegs.train.recipes import RECIPES, Recipe
from mobilegs.train.stage import Stage
from mobilegs.train.student import trainer
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.threads import all_threads, torch_on_one_thread

LENGTH = 30_000  # steps of a stage
PERIOD = 4  # steps after which terms that are not in every step repeat
WARM, ROUNDS = 8, 5
SETTLE_SECONDS, BESIDE_SECONDS = 3, 10
PARTS = {"teacher": 0.75, "explicit": 0.08, "latents": 0.3, "rate": 0.65, "quantized": 0.95}
READS = ("_local_scalar_dense", "nonzero", "equal", "is_nonzero", "masked_select")
INDEXED = ("index", "index_put", "index_put_")  # which read the size of a mask
LAUNCHES = ("cudaLaunchKernel", "cudaLaunchKernelExC", "cuLaunchKernel")


class OperationCount(TorchDispatchMode):
    """Counts operations of torch, the bytes that they read and write, and the host's reads."""

    def __init__(self) -> None:
        super().__init__()
        self.operations: Counter[str] = Counter()
        self.bytes = 0
        self.host_reads = 0

    def __torch_dispatch__(
        self, func: Any, types: object, args: tuple = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        result = func(*args, **(kwargs or {}))
        name = func.overloadpacket.__name__
        returned = func._schema.returns
        shared = [each.alias_info for each in returned if each.alias_info is not None]
        if name.removeprefix("new_").startswith("empty") or (
            shared and not any(each.is_write for each in shared)
        ):
            return result  # a view, or memory that nobody has written yet
        tensors = [t for t in tree_leaves((args, kwargs, result)) if isinstance(t, Tensor)]
        self.operations[name] += 1
        self.bytes += sum(tensor.nbytes for tensor in tensors)
        devices = {tensor.device.type for tensor in tensors}
        copies = len(devices) > 1 and result.device.type == "cpu"
        waits = copies and (name != "copy_" or args[2:] != (True,))  # True: it does not block
        masked = name in INDEXED and any(
            each is not None and each.dtype == torch.bool for each in args[1]
        )
        self.host_reads += name in READS or masked or waits
        return result


def begin(part: str, recipe: Recipe, dataset: Dataset, teacher: Scene) -> Stage:
    """Return the stage of a part, at its beginning."""
    if part == "teacher":
        config = replace(recipe.teacher, steps=LENGTH)
        device, start = teacher.background.device, teacher.gaussians
        stage = Teacher(config, dataset, seed=0, device=device, start=start)
    else:
        config = replace(recipe.student, steps=LENGTH)
        cameras = [frame.camera for frame in dataset.train]
        stage = Student(config, teacher, cameras, extent=dataset.extent, seed=0)
        for index, camera in enumerate(stage.virtual_cameras):  # as after some thousand steps
            stage.teacher_images.get(len(cameras) + index, camera)
            stage.teacher_images.front(index, camera)
    stage.done = round(PARTS[part] * LENGTH / PERIOD) * PERIOD
    while isinstance(stage, Student) and _holds_vote(stage, WARM + PERIOD):
        stage.done += PERIOD
    return stage


def _holds_vote(stage: Student, steps: int) -> bool:
    """Return whether one of the next steps holds a vote."""
    return any(stage.votes.votes_at(stage.done + step) for step in range(1, steps + 1))


@contextmanager
def native_calls() -> Iterator[Counter[str]]:
    """Count calls of the C++ library's functions that were used before."""
    counted: Counter[str] = Counter()
    libraries = {id(each): each for each in (binding.library(), cpu.library())}.values()
    used = [
        (library, name, function)
        for library in libraries
        for name, function in vars(library).items()
        if name.startswith("mgs_")
    ]

    def counting(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any) -> Any:
            counted[name] += 1
            return function(*args)

        return call

    for library, name, function in used:
        setattr(library, name, counting(name, function))
    try:
        yield counted
    finally:
        for library, name, function in used:
            setattr(library, name, function)


def count_steps(advance: Callable[[], object], steps: int = PERIOD) -> dict[str, float]:
    """Return what a step counts, the mean of `steps`."""
    with native_calls() as native, OperationCount() as operations:
        for _ in range(steps):
            advance()
    return {
        "operations": round(operations.operations.total() / steps, 1),
        "native": round(native.total() / steps, 1),
        "megabytes": round(operations.bytes / steps / 1e6, 1),
        "host_reads": round(operations.host_reads / steps, 2),
    }


def gpu_figures(advance: Callable[[], object], steps: int) -> dict[str, float]:
    """Return the kernels that a step starts, and their milliseconds."""
    with profile(activities=[ProfilerActivity.CPU, ProfilerActivity.CUDA]) as profiler:
        for _ in range(steps):
            advance()
        torch.cuda.synchronize()
    events = profiler.key_averages()
    kernels = [each for each in events if each.device_type == DeviceType.CUDA]
    busy = sum(each.self_device_time_total for each in kernels if not each.is_user_annotation)
    launches = sum(event.count for event in events if event.key in LAUNCHES)
    return {"launches": round(launches / steps), "gpu_ms": round(busy / 1e3 / steps, 2)}


@contextmanager
def reference_only() -> Iterator[None]:
    """Make students take their steps through the reference in PyTorch."""
    program = trainer.runs_program
    trainer.runs_program = lambda model: False
    try:
        with all_threads():
            yield
    finally:
        trainer.runs_program = program


def time_steps(advance: Callable[[], object], steps: int, *, on_gpu: bool) -> float:
    """Return the milliseconds of a step, the mean of `steps`."""
    if on_gpu:
        torch.cuda.synchronize()
    began = time.perf_counter()
    for _ in range(steps):
        advance()
    if on_gpu:
        torch.cuda.synchronize()
    return 1e3 * (time.perf_counter() - began) / steps


@contextmanager
def busy_programs(count: int) -> Iterator[None]:
    """Keep so many other programs busy."""
    command = [sys.executable, "-c", "while True: pass"]
    programs = [subprocess.Popen(command) for _ in range(count)]
    try:
        time.sleep(SETTLE_SECONDS)
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


def share_beside(advance: Callable[[], object], programs: int) -> float:
    """Return the speed beside busy programs as a share of what is fair on this machine's cores."""
    with all_threads():
        cores = torch.get_num_threads()

    def speed() -> float:
        done, began = 0, time.perf_counter()
        while (passed := time.perf_counter() - began) < BESIDE_SECONDS:
            advance()
            done += 1
        return done / passed

    alone = speed()
    with busy_programs(programs):
        return speed() / alone * (cores + programs) / cores


def measure(
    dataset: Dataset,
    recipe: Recipe,
    teacher: Scene,
    parts: list[str],
    steps: int,
    beside: list[int],
    to: Figures,
) -> None:
    """Add a row for each part."""
    camera, device = dataset.train[0].camera, teacher.background.device
    on_gpu, team = device.type == "cuda", Team(device)
    with ViewLoader(dataset.train) as loader, torch_on_one_thread():
        for index in range(len(loader)):
            loader.get(index)  # as in a long run, where they are decoded
        for part in parts:

            def begun(part: str = part) -> tuple[Stage, Callable[[], object]]:
                stage = begin(part, recipe, dataset, teacher)
                return stage, lambda: stage.advance(next_views(stage, loader, team, 0))

            stage, advance = begun()
            time_steps(advance, WARM, on_gpu=on_gpu)
            counts = count_steps(advance)
            ways = {"ms": (advance, nullcontext)}
            if part != "teacher" and not on_gpu:
                ways["reference_ms"] = begun()[1], reference_only
            times: dict[str, list[float]] = {name: [] for name in ways}
            for _ in range(1 + ROUNDS):
                for name, (step, way) in ways.items():
                    with way():
                        times[name].append(time_steps(step, steps, on_gpu=on_gpu))
            # the first round warms caches
            found = {name: round(median(each[1:]), 2) for name, each in times.items()}
            found |= {f"beside_{n}": round(share_beside(advance, n), 2) for n in beside} | counts
            if on_gpu:
                found |= gpu_figures(advance, PERIOD)
            size = f"{camera.width}x{camera.height}"
            to.add(f"{part} {size}", gaussians=stage.count, steps=steps, **found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("teacher", type=Path)
    parser.add_argument("--downscale", type=int, default=1)
    parser.add_argument("--preset", default="short", choices=RECIPES)
    parser.add_argument("--device", default="cpu", choices=("cpu", "cuda"))
    parser.add_argument("--only", nargs="+", default=list(PARTS), choices=PARTS, metavar="PART")
    parser.add_argument("--steps", type=int, default=16, help="of a round; default: 16")
    parser.add_argument("--beside", type=int, nargs="+", default=[], metavar="N")
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    device = torch.device(options.device)
    dataset = load_capture(options.capture, downscale=options.downscale)
    gaussians, footprint = read_ply_scene(options.teacher)
    teacher = Scene(
        gaussians.to(device),
        background=dataset.background.to(device),
        near=dataset.near,
        footprint=footprint,
    )
    about = {"device": torch.cuda.get_device_name()} if device.type == "cuda" else {}
    recipe, figures = RECIPES[options.preset](), Figures(options.json, **about)
    measure(dataset, recipe, teacher, options.only, options.steps, options.beside, figures)


if __name__ == "__main__":
    main()
