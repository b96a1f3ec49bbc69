"""Measure `mobilegs compress` on trained scenes without photos.

    python -m bench.studies.existing [--data DIR] [--runs RUNS] [--json OUT] [--steps N]
        [--size 640]

DIR (default: MOBILEGS_DATA) holds splats/NAME.ply and splats/NAME_cameras.json. The preset cpu
compresses each scene on renders from cameras that the program places. The student is compared
with the scene from the held-back cameras, from cameras placed with another seed, and from the
orbit in the cameras file, which training never used. A finished run under RUNS is not repeated.
"""

import argparse
import json
import os
import platform
import statistics
import time
from pathlib import Path
from typing import Any

import torch

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera
from mobilegs.evaluate.metrics import as_displayed, psnr
from mobilegs.mgs.codec import read_mgs
from mobilegs.pipeline.compress import CompressRun, compress_run
from mobilegs.render.scene import Scene
from mobilegs.scene_file import read_plain_scene
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.placement import interpolate_cameras, place_cameras
from mobilegs.synthetic_capture.scene_bounds import find_scene_bounds

SCENES = {"flowers": "flowers_lod1", "playbot": "playbot_125k_sh3pad"}
ANEW = 24  # cameras placed with another seed
OTHER_SEED = 1


@torch.inference_mode()
def apart(teacher: Scene, student: Scene, cameras: list[Camera]) -> dict[str, float]:
    """Return the PSNR of the student's renders against the teacher's."""
    found = [
        psnr(as_displayed(student.render(view).image), as_displayed(teacher.render(view).image))
        for view in cameras
    ]
    return {"psnr": statistics.mean(found), "worst": min(found), "views": len(found)}


def compressed(
    name: str, data: Path, runs: Path, steps: int | None, picture: int | None
) -> dict[str, Any]:
    source, run = data / "splats" / f"{SCENES[name]}.ply", runs / name
    cameras = data / "splats" / f"{name}_cameras.json"
    began = time.monotonic()
    resume = (run / "config.json").exists()
    how = {"preset": "cpu", "steps": steps, "size": picture, "resume": resume}
    metrics = compress_run(CompressRun(source, run, **how))
    seconds = metrics["seconds"]
    teacher = read_plain_scene(source)
    student = read_mgs(run / "scene.mgs").decode("cpu")
    bounds = find_scene_bounds(teacher.gaussians)
    generator = torch.Generator().manual_seed(OTHER_SEED)
    width, height = metrics["image_size"]
    anew = place_cameras(teacher, bounds, ANEW, width=width, height=height, generator=generator)
    given = read_cameras_json(cameras)
    orbit = interpolate_cameras(given, bounds, len(given), size=width, generator=generator)
    size, before = metrics["student"]["file_bytes"], source.stat().st_size
    return {
        "ply_bytes": before,
        "ply_gaussians": len(teacher.gaussians),
        "bytes": size,
        "gaussians": metrics["student"]["gaussians"],
        "smaller": before / size,
        "held_back": {key: metrics["student"][key] for key in ("psnr", "ssim")},
        "anew": apart(teacher, student, anew),
        "orbit": apart(teacher, student, orbit),
        "pictures": len(list((run / "capture" / "images").iterdir())),
        "image_size": [width, height],
        "steps": json.loads((run / "config.json").read_text())["recipe"]["student"]["steps"],
        "seconds": seconds,
        "seconds_here": time.monotonic() - began,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--runs", type=Path, default=Path("runs/existing"))
    parser.add_argument("--json", type=Path, default=Path("existing.json"))
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--steps", type=int, help="of the student; 5,000 are the preset's")
    parser.add_argument("--size", type=int, help="of pictures, in pixels; 640 is the preset's")
    options = parser.parse_args()
    if options.data is None:
        parser.error("--data, or MOBILEGS_DATA, must name the folder of splats")
    found = json.loads(options.json.read_text()) if options.json.exists() else {}
    for name in options.scenes:
        row = compressed(name, options.data, options.runs, options.steps, options.size)
        row["device"] = f"{platform.machine()}, {os.cpu_count()} cores"
        row["threads"] = torch.get_num_threads()
        row["date"] = time.strftime("%Y-%m-%d")
        found[name] = row
        atomic_write(options.json, json.dumps(found, indent=1) + "\n")
        print(name, json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
