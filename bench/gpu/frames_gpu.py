"""Whole frames of trained scenes on CUDA, from one capture's held-back cameras, beside gsplat.

    python bench/gpu/frames_gpu.py --capture DIR --mgs SCENE --ply TEACHER [--downscale N]
                                   [--json OUT]

Ours draws the student as its file says (opacity and weight from their lobes, or by the network,
within the time) and the teacher sorted; gsplat, if it can be imported, draws the teacher, and the
student's own Gaussians as if they were to be sorted: the same number, of the same shapes.
Milliseconds between events on the GPU, median over the cameras.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import torch
from kernels_gpu import timed

from mobilegs.camera import Camera
from mobilegs.data import load_capture
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene

DEVICE = torch.device("cuda")
CAMERAS = 12


def by_gsplat(gaussians: Gaussians, camera: Camera) -> Callable[[], object]:
    """One frame of gsplat's rasteriser."""
    from gsplat import rasterization

    given = (gaussians.means, gaussians.quats, gaussians.scales, gaussians.opacities, gaussians.sh)
    view = (camera.viewmat[None], camera.K[None], camera.width, camera.height)
    degree = gaussians.sh_degree
    return lambda: rasterization(*given, *view, sh_degree=degree, packed=False)


@torch.inference_mode()
def median_ms(frame_of: Callable[[Camera], Callable[[], object]], cameras: list[Camera]) -> float:
    """Median over cameras of the median over rounds."""
    medians = [statistics.median(timed(frame_of(camera))) for camera in cameras]
    return round(statistics.median(medians), 4)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--capture", type=Path, required=True)
    parser.add_argument("--mgs", type=Path, required=True)
    parser.add_argument("--ply", type=Path, required=True)
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    test = load_capture(options.capture, downscale=options.downscale).test
    cameras = [frame.camera.to(DEVICE) for frame in test[:: max(1, len(test) // CAMERAS)]]
    scenes = {
        "student": open_scene(options.mgs, DEVICE),
        "teacher": open_scene(options.ply, DEVICE),
    }
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "device": torch.cuda.get_device_name(),
        "image_size": [cameras[0].width, cameras[0].height],
        "cameras": len(cameras),
    }
    for name, scene in scenes.items():
        row: dict = {"gaussians": len(scene.gaussians), "blend": scene.blend}

        def frame(camera: Camera, scene: Scene = scene) -> Callable[[], object]:
            return lambda: scene.render(camera)

        row["ms"] = median_ms(frame, cameras)
        try:
            row["gsplat_ms"] = median_ms(
                lambda camera, scene=scene: by_gsplat(scene.gaussians, camera), cameras
            )
        except ImportError:
            row["gsplat_ms"] = None
        except Exception as error:  # whatever breaks another package must not end our measurement
            row["gsplat_error"] = f"{type(error).__name__}: {error}"[:300]
        result[name] = row
        print(name, json.dumps(row), flush=True)
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
