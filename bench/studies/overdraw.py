"""Measure the overdraw of students, and the milliseconds per frame.

    python -m bench.studies.overdraw --capture CAPTURE [--downscale N] --mgs A.mgs B.mgs ...
        [--json OUT]

The training kernels draw the files in turns from the held-back cameras. A time is the median over
cameras of the fastest of a few frames. `ellipses` is the mean number of ellipses that cover a
pixel, cut off where alpha is too small to be drawn. An existing JSON keeps its other captures.
"""

import argparse
import json
import math
import os
import platform
import statistics
import time
from pathlib import Path
from typing import Any

import torch

from mobilegs.camera import Camera
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import load_capture
from mobilegs.evaluate.fragments import mean_fragments
from mobilegs.evaluate.report import evaluate
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene

FRAMES = 6  # per camera and scene


def milliseconds(scenes: list[Scene], cameras: list[Camera]) -> list[float]:
    """Return the milliseconds per frame of each scene; scenes are drawn in turns."""
    found: list[list[float]] = [[] for _ in scenes]
    for camera in cameras:
        least = [math.inf] * len(scenes)
        for _ in range(FRAMES):
            for i, scene in enumerate(scenes):
                started = time.perf_counter()
                scene.render(camera)
                least[i] = min(least[i], 1e3 * (time.perf_counter() - started))
        for times, one in zip(found, least, strict=True):
            times.append(one)
    return [round(statistics.median(times), 2) for times in found]


@torch.inference_mode()
def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--capture", type=Path, required=True)
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--mgs", type=Path, nargs="+", required=True)
    parser.add_argument(
        "--names", nargs="+", help="names of the files in the JSON; default: their paths"
    )
    parser.add_argument("--json", type=Path, default=Path("overdraw.json"))
    options = parser.parse_args()
    dataset = load_capture(options.capture, downscale=options.downscale)
    cameras = [frame.camera for frame in dataset.test]
    scenes = [open_scene(path) for path in options.mgs]
    rows = {}
    names = options.names or [str(path) for path in options.mgs]
    times = milliseconds(scenes, cameras)
    for name, path, scene, ms in zip(names, options.mgs, scenes, times, strict=True):
        figures = evaluate(scene, dataset)
        rows[name] = {
            "psnr": figures["psnr"],
            "ssim": figures["ssim"],
            "bytes": path.stat().st_size,
            "gaussians": len(scene.gaussians),
            "ellipses": round(sum(mean_fragments(scene, cameras)), 2),
            "frame_ms": ms,
        }
        print(name, json.dumps(rows[name]), flush=True)
    known: dict[str, Any] = {"captures": {}}
    if options.json.exists():
        known = json.loads(options.json.read_text())
    known["date"] = time.strftime("%Y-%m-%d")
    known["machine"] = f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}"
    size = [cameras[0].width, cameras[0].height]
    known["captures"][dataset.name] = {"image_size": size, "students": rows}
    options.json.write_text(json.dumps(known, indent=1) + "\n")


if __name__ == "__main__":
    main()
