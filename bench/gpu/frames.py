"""Time whole frames of trained scenes on CUDA through the held-back cameras of a capture.

    python -m bench.gpu.frames --capture DIR --mgs SCENE --ply TEACHER [--downscale N]
                               [--json OUT] [--by gsplat]

The CUDA kernels draw the student as its file says (lobes or network evaluated within the time)
and the teacher sorted. With `--by gsplat` that package draws the teacher and, sorted, the
student's Gaussians: the same number, the same shapes. Its times join the same rows. A time is the
median over cameras of milliseconds between two events on the GPU. OUT is written after every row.
"""

import argparse
import statistics
from collections.abc import Callable
from pathlib import Path

import torch

from bench.gpu.kernels import timed
from bench.record import Figures
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
    view = (camera.viewmat.float()[None], camera.K.float()[None], camera.width, camera.height)
    degree = gaussians.sh_degree
    return lambda: rasterization(*given, *view, sh_degree=degree, packed=False)


@torch.inference_mode()
def median_ms(frame_of: Callable[[Camera], Callable[[], object]], cameras: list[Camera]) -> float:
    """Median over cameras of the median over rounds."""
    medians = [statistics.median(timed(frame_of(camera))) for camera in cameras]
    return round(statistics.median(medians), 4)


def ours_of(scene: Scene, cameras: list[Camera]) -> dict:
    """Measure our kernels."""
    ms = median_ms(lambda camera: lambda: scene.render(camera), cameras)
    return {"gaussians": len(scene.gaussians), "blend": scene.blend, "ms": ms}


def gsplat_of(scene: Scene, cameras: list[Camera]) -> dict:
    """gsplat's median, or why there is none."""
    try:
        return {"gsplat_ms": median_ms(lambda view: by_gsplat(scene.gaussians, view), cameras)}
    except Exception as error:  # whatever breaks another package is a finding, too
        return {"gsplat_error": f"{type(error).__name__}: {error}"[:300]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--capture", type=Path, required=True)
    parser.add_argument("--mgs", type=Path, required=True)
    parser.add_argument("--ply", type=Path, required=True)
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--json", type=Path, help="add the figures to this file")
    parser.add_argument("--by", choices=["ours", "gsplat"], default="ours")
    options = parser.parse_args()
    test = load_capture(options.capture, downscale=options.downscale).test
    cameras = [frame.camera.to(DEVICE) for frame in test[:: max(1, len(test) // CAMERAS)]]
    figures = Figures(
        options.json,
        device=torch.cuda.get_device_name(),
        image_size=[cameras[0].width, cameras[0].height],
        cameras=len(cameras),
    )
    for name, path in (("student", options.mgs), ("teacher", options.ply)):
        scene = open_scene(path, DEVICE)
        figures.add(name, **(ours_of if options.by == "ours" else gsplat_of)(scene, cameras))


if __name__ == "__main__":
    main()
