"""Time the wgpu renderer (Vulkan, Metal, DirectX 12) off screen, pass by pass.

    python -m bench.viewers.wgpu --mgs RUN/scene.mgs [--ply RUN/teacher.ply] [--json OUT]
        [--sizes 800x533 1600x1063] [--frames 30]

The script draws the student sort-free, in float16 and in float32, the same Gaussians with the
paper's network of random weights, and the sorted teacher, in turns, through the cameras in the
student's file. The device times the passes (a software device
may not). `frame` lasts from the call until the device has finished; for a sorted scene it
includes the CPU's sort. Each picture is compared with that of the CPU kernels.
"""

import argparse
import json
import platform
import statistics
import time
from dataclasses import replace
from pathlib import Path

import torch

from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import psnr
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.view_network import ViewNetwork
from mobilegs.scene_file import open_scene
from mobilegs.view.wgpu_device import PASSES
from mobilegs.view.wgpu_renderer import WgpuRenderer, usable_gpu

WARM = 3  # frames that are not counted
CPU = torch.device("cpu")


def timed(renderer: WgpuRenderer, views: list[Camera], frames: int) -> dict[str, float]:
    """Return medians over frames, in milliseconds."""
    import wgpu

    view = views[0]
    device = renderer.program.device
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC
    size = (view.width, view.height, 1)
    target = device.create_texture(size=size, format="rgba8unorm", usage=usage)
    rows: list[dict[str, float]] = []
    for frame in range(WARM + frames):
        started = time.perf_counter()
        renderer.render_into(target.create_view(), "rgba8unorm", views[frame % len(views)])
        _finish(device, target)
        row = {"frame": 1e3 * (time.perf_counter() - started)}
        rows.append(row | (renderer.milliseconds() or {}))
    return {
        name: round(statistics.median(row[name] for row in rows[WARM:]), 3)
        for name in ("frame", *PASSES)
        if name in rows[0]
    }


def _finish(device, target) -> None:
    """Wait for the device by reading one pixel."""
    device.queue.read_texture(
        {"texture": target}, {"bytes_per_row": 4, "rows_per_image": 1}, (1, 1, 1)
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mgs", type=Path, required=True)
    parser.add_argument("--ply", type=Path)
    parser.add_argument("--json", type=Path, default=Path("native.json"))
    parser.add_argument("--sizes", nargs="+", default=["800x533", "1600x1063"])
    parser.add_argument("--frames", type=int, default=30)
    options = parser.parse_args()
    student = open_scene(options.mgs, device=CPU)
    cameras = read_mgs(options.mgs).views
    scenes = {
        "sort-free, halves": (student, False),
        "sort-free, floats": (student, True),
    }
    # the time of a network does not depend on its weights
    network = ViewNetwork(torch.Generator().manual_seed(0)).requires_grad_(False)
    scenes["sort-free with the paper's network, halves"] = (
        replace(student, lobes=None, network=network),
        False,
    )
    if options.ply:
        scenes["sorted, halves"] = (open_scene(options.ply, device=CPU), False)
    info = usable_gpu(False, False).info
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": platform.machine(),
        "adapter": {name: str(info[name]) for name in ("device", "description", "backend_type")},
        "rows": [],
    }
    for size in options.sizes:
        width, height = (int(side) for side in size.split("x"))
        views = [camera.resized(width, height) for camera in cameras]
        for name, (scene, floats) in scenes.items():
            renderer = WgpuRenderer(scene, full_precision=floats)
            row: dict = {"size": size, "drawing": name, "gaussians": renderer.count}
            row |= timed(renderer, views, options.frames)
            reference = scene.render(views[0]).image
            row["psnr_to_cpu"] = round(psnr(renderer.render(views[0]).image, reference), 1)
            result["rows"].append(row)
            print(json.dumps(row), flush=True)
    options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
