"""Profile training steps on CUDA: milliseconds, the GPU's share of them, and kernels started.

    python -m bench.gpu.steps CAPTURE [--max-splats 200000] [--steps 800] [--json OUT]

A short run with the preset long is profiled for 15 steps of the teacher after its densification,
and for 15 steps of the student with latents. The 30 steps before them are timed without the
profiler, which slows them down.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch._C._autograd import DeviceType
from torch.autograd.profiler_util import EventList
from torch.profiler import ProfilerActivity, profile

from bench.record import Figures
from mobilegs.pipeline.options import TrainRun
from mobilegs.pipeline.train import train_capture
from mobilegs.train.stage import StepResult
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher

TIMED, PROFILED = 30, 15  # with the usual steps, no preview is written meanwhile
STARTS = {"teacher": 0.86, "student": 0.62}  # shares of a stage's steps before the profile
LAUNCHES = ("cudaLaunchKernel", "cudaLaunchKernelExC", "cuLaunchKernel")
RENDERING = ("CudaRaster", "CudaRasterBackward")


def figures_of(events: EventList) -> dict[str, float]:
    """Return milliseconds of the GPU and kernels started, for each step."""
    by_name = {event.key: event for event in events}
    kernels = [each for each in events if each.device_type == DeviceType.CUDA]
    busy = sum(each.self_device_time_total for each in kernels if not each.is_user_annotation) / 1e3
    rendering = sum(by_name[name].device_time_total for name in RENDERING if name in by_name) / 1e3
    launches = sum(by_name[name].count for name in LAUNCHES if name in by_name)
    return {
        "gpu_ms": round(busy / PROFILED, 2),
        "rendering_gpu_ms": round(rendering / PROFILED, 2),
        "kernel_launches": round(launches / PROFILED),
    }


class Watch:
    """Times and profiles some steps of a stage."""

    def __init__(self, name: str, steps: int, figures: Figures) -> None:
        self.name, self.figures = name, figures
        self.first = round(STARTS[name] * steps)
        self.began = 0.0
        self.milliseconds = 0.0
        self.profiler = profile(activities=[ProfilerActivity.CPU, ProfilerActivity.CUDA])

    def step(self, done: int, count: int, advance: Callable[[], StepResult]) -> StepResult:
        """Take the step after `done` others, of a stage with `count` Gaussians."""
        if done == self.first - TIMED:
            torch.cuda.synchronize()
            self.began = time.perf_counter()
        if done == self.first:
            torch.cuda.synchronize()
            self.milliseconds = 1e3 * (time.perf_counter() - self.began) / TIMED
            self.profiler.start()
        result = advance()
        if done == self.first + PROFILED - 1:
            torch.cuda.synchronize()
            self.profiler.stop()
            found = figures_of(self.profiler.key_averages())
            ms = round(self.milliseconds, 1)
            self.figures.add(self.name, gaussians=count, ms=ms, **found)
        return result


def watched(stage: type, watch: Watch) -> None:
    """Make every step of a kind of stage go through a watch."""
    advance = stage.advance

    def taken(self: Any, views: Any) -> StepResult:
        return watch.step(self.done, self.count, lambda: advance(self, views))

    stage.advance = taken


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("--max-splats", type=int, default=200_000)
    parser.add_argument("--steps", type=int, default=800, help="of both stages")
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    options = parser.parse_args()
    figures = Figures(options.json, device=torch.cuda.get_device_name())
    for name, stage in (("teacher", Teacher), ("student", Student)):
        watched(stage, Watch(name, options.steps // 2, figures))
    with tempfile.TemporaryDirectory() as folder:
        train_capture(
            TrainRun(
                options.capture,
                Path(folder) / "run",
                preset="long",
                steps=options.steps,
                max_splats=options.max_splats,
                device="cuda",
            )
        )


if __name__ == "__main__":
    main()
