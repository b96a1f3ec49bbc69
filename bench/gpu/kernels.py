"""Time the CUDA kernels, forward and forward + backward, on the scene of bench/kernels.py.

    python -m bench.gpu.kernels [--json OUT] [--by gsplat] [--counts 100000 400000 1000000]

A row also has the time of each kernel; the rest are launches.
With `--by gsplat` that package's sorted rasteriser is timed on the same scenes, and its times
join the same rows. OUT is written after every row.
"""

import argparse
import statistics
from collections.abc import Callable
from pathlib import Path

import torch

from bench.kernels import INPUTS, Ours, study_scene
from bench.record import Figures
from mobilegs.render.kernels import cuda

DEVICE = "cuda"
SIZES = ((800, 533), (1600, 1066))
WARM_UP = 3
ROUNDS = 20


class Gsplat:
    """The rasteriser of the package gsplat."""

    def __init__(self, ours: Ours) -> None:
        from gsplat import rasterization

        self.rasterization, self.ours = rasterization, ours
        self.viewmats = ours.camera.viewmat.to(DEVICE)[None]
        self.intrinsics = ours.camera.K.float().to(DEVICE)[None]

    def forward(self, path: str) -> torch.Tensor:
        means, quats, scales, opacities, sh = (self.ours.leaves[name] for name in INPUTS["sorted"])
        camera = self.ours.camera
        image, _, _ = self.rasterization(
            means,
            quats,
            scales,
            opacities,
            sh,
            self.viewmats,
            self.intrinsics,
            camera.width,
            camera.height,
            sh_degree=1,
            packed=False,
        )
        return image[0]

    both = Ours.both

    @property
    def leaves(self) -> dict[str, torch.Tensor]:
        return self.ours.leaves

    @property
    def grad(self) -> torch.Tensor:
        return self.ours.grad


def timed(call: Callable[[], object]) -> list[float]:
    """Milliseconds of each round between two events on the GPU, after a warm-up."""
    for _ in range(WARM_UP):
        call()
    found = []
    for _ in range(ROUNDS):
        start, end = (torch.cuda.Event(enable_timing=True) for _ in range(2))
        torch.cuda.synchronize()
        start.record()
        call()
        end.record()
        torch.cuda.synchronize()
        found.append(start.elapsed_time(end))
    return found


def by_kernel(call: Callable[[], object]) -> dict[str, float]:
    """Milliseconds of each kernel in one call, the median of some."""
    kernels, samples = cuda.kernels_for(torch.empty(0, device=DEVICE)), {}
    launch = kernels.launch

    def watched(name: str, *arguments) -> None:
        start, end = (torch.cuda.Event(enable_timing=True) for _ in range(2))
        start.record()
        launch(name, *arguments)
        end.record()
        samples.setdefault(name, []).append((start, end))

    kernels.launch = watched  # pyright: ignore[reportAttributeAccessIssue]
    try:
        for _ in range(5):
            call()
        torch.cuda.synchronize()
    finally:
        kernels.launch = launch
    medians = {
        name: statistics.median(start.elapsed_time(end) for start, end in events)
        for name, events in samples.items()
    }
    return {name: round(value, 4) for name, value in medians.items()}


def studied(count: int, width: int, height: int) -> Ours:
    """Our kernels on the study's scene at a size."""
    scene, camera = study_scene(count)
    generator = torch.Generator().manual_seed(7)
    grad = torch.randn(height, width, 3, generator=generator).to(DEVICE)
    scene = {name: value.to(DEVICE) for name, value in scene.items()}
    return Ours(scene, camera.resized(width, height), grad)


def ours_of(ours: Ours, path: str, kind: str) -> dict:
    """Measure our kernels."""

    def call() -> object:
        return getattr(ours, kind)(path)

    torch.cuda.reset_peak_memory_stats()
    found = timed(call)
    row: dict = {"ms": round(statistics.median(found), 3), "min_ms": round(min(found), 3)}
    row["peak_memory_mib"] = torch.cuda.max_memory_allocated() // 2**20
    return row | {"kernels_ms": by_kernel(call)}


def gsplat_of(ours: Ours, kind: str) -> dict:
    """gsplat's median on the same scene, or why there is none."""
    try:
        other = Gsplat(ours)
        found = timed(lambda: getattr(other, kind)("sorted"))
    except Exception as error:  # whatever breaks another package is a finding, too
        return {"gsplat_error": f"{type(error).__name__}: {error}"[:300]}
    return {"gsplat_ms": round(statistics.median(found), 3)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    parser.add_argument("--by", choices=["ours", "gsplat"], default="ours")
    parser.add_argument("--counts", type=int, nargs="+", default=[100_000, 400_000, 1_000_000])
    options = parser.parse_args()
    device = {"device": torch.cuda.get_device_name(), "torch": torch.__version__}
    figures = Figures(options.json, **device)
    for count in options.counts:
        for width, height in SIZES:
            ours = studied(count, width, height)
            for path in ("sortfree", "sorted") if options.by == "ours" else ("sorted",):
                for kind in ("forward", "both"):
                    name = f"{count} {width}x{height} {path} {kind}"
                    found = ours_of(ours, path, kind) if options.by == "ours" else None
                    figures.add(name, **(found or gsplat_of(ours, kind)))


if __name__ == "__main__":
    main()
