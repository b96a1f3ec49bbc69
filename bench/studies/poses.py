"""Train teachers on photos with wrong poses, and with poses that are refined.

    python -m bench.studies.poses [--json OUT] [--steps 2000]

Bonsai at 200x133, from MOBILEGS_DATA, with at most 30,000 Gaussians. All cameras, held-back ones
too, turn by a random vector of 0.3 degrees per axis and move by 0.5 % of the scene's extent per
axis. Every third held-back photo is measured, in all rows with a pose of its own, which it finds in
the finished teacher as with `teacher.pose.learned`.
"""

import argparse
import json
import math
import os
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

import torch

from bench.studies.off_path import run
from mobilegs.camera import Camera
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.data.dataset import Frame
from mobilegs.evaluate.metrics import as_displayed, psnr
from mobilegs.train.poses import Poses, refined_camera, rotation_matrix
from mobilegs.train.recipes import cpu_recipe, rates_for, with_settings
from mobilegs.train.teacher.trainer import Teacher

TURN, SHIFT = math.radians(0.3), 0.005
SEED = 3
EVERY = 3  # of the held-back photos, that are measured


def perturbed(dataset: Dataset) -> Dataset:
    """Return the capture with wrong poses."""
    generator = torch.Generator().manual_seed(SEED)

    def wrong(frame: Frame) -> Frame:
        camera = frame.camera
        turn, shift = torch.randn(2, 3, generator=generator)
        rotation = camera.viewmat[:3, :3] @ rotation_matrix(TURN * turn).T
        viewmat = camera.viewmat.clone()
        viewmat[:3, :3] = rotation
        viewmat[:3, 3] = -rotation @ (camera.position + SHIFT * dataset.extent * shift)
        return replace(frame, camera=replace(camera, viewmat=viewmat))

    train, test = ([wrong(frame) for frame in each] for each in (dataset.train, dataset.test))
    return replace(dataset, train=train, test=test)


def pixel_error(cameras: list[Camera], true: list[Camera], points: torch.Tensor) -> float:
    """Return the median distance in pixels between projections of points, over all cameras."""
    distances = []
    for one, other in zip(cameras, true, strict=True):
        inside = [points @ c.viewmat[:3, :3].T + c.viewmat[:3, 3] for c in (one, other)]
        seen = (inside[0][:, 2] > 0.2) & (inside[1][:, 2] > 0.2)
        pixels = [(each[seen, :2] / each[seen, 2:]) * one.K[0, 0] for each in inside]
        distances.append((pixels[0] - pixels[1]).norm(dim=1))
    return float(torch.cat(distances).median())


def train(dataset: Dataset, true: Dataset, steps: int, learned: bool) -> dict:
    settings = [f"teacher.pose.learned={str(learned).lower()}", f"teacher.steps={steps}"]
    config = with_settings(cpu_recipe(), settings).teacher
    config = replace(config, max_splats=30_000, init_splats=20_000, lr=rates_for(steps))
    teacher = Teacher(config, dataset, seed=0, device=torch.device("cpu"))
    run(teacher, dataset, 0)
    scene, values = teacher.scene(), []
    for frame in dataset.test[::EVERY]:
        view = load_view(frame)
        camera = refined_camera(scene, view, dataset.extent)
        with torch.inference_mode():
            values.append(psnr(as_displayed(scene.render(camera).image), view.image))
    cameras = [frame.camera for frame in dataset.train]
    if isinstance(teacher.poses, Poses):
        with torch.no_grad():
            cameras = [teacher.poses.camera(i, camera) for i, camera in enumerate(cameras)]
    error = pixel_error(cameras, [frame.camera for frame in true.train], dataset.points[::50])
    return {"psnr": sum(values) / len(values), "median_pixels": error}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--steps", type=int, default=2000)
    options = parser.parse_args()
    if not os.environ.get("MOBILEGS_DATA"):
        sys.exit("set MOBILEGS_DATA to the folder that holds bonsai")
    true = load_capture(Path(os.environ["MOBILEGS_DATA"]) / "bonsai", downscale=4)
    wrong = perturbed(true)
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "steps": options.steps,
        "rows": {},
    }
    for name, dataset, learned in (
        ("as given", true, False),
        ("as given, refined", true, True),
        ("perturbed", wrong, False),
        ("perturbed, refined", wrong, True),
    ):
        result["rows"][name] = train(dataset, true, options.steps, learned)
        print(name, result["rows"][name], flush=True)
        if options.json:
            options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
