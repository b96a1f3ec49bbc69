"""Measure how much of first views, and of views inside the limits, no training camera saw.

    python -m bench.studies.framing --runs FOLDER [--json OUT] [--pictures FOLDER] [--minutes 1.2]

FOLDER/NAME is a run on a capture of MOBILEGS_DATA; runs that do not exist are trained for
`--minutes`. Of each scene and screen it measures the first view that its file notes, the view that
it would have without notes (the first training camera), and random views inside the limits:
directions, distances and targets anywhere that they allow. A pixel is unseen if its surface lies in
no training photo (`mobilegs.synthetic_capture.first_view`). `subject` is the share of the subject's
points that the picture holds. Two scenes of other tools are shown without cameras, as viewers show
any .ply; the cameras that come with them tell what was seen.
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

import numpy as np
import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.cli.main import main as command
from mobilegs.data import load_capture
from mobilegs.data.demo.capture import write_capture
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.framing import SECTORS, Framing, Limits, Start, direction_of
from mobilegs.mgs.codec import read_mgs
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene
from mobilegs.synthetic_capture.cameras_json import read_cameras_json
from mobilegs.synthetic_capture.first_view import Coverage, find_framing, find_subject
from mobilegs.up import USUAL
from mobilegs.view.orbit import Pose, camera_of, first_pose

SAMPLE = "sample"
CAPTURES = (SAMPLE, "bonsai", "stitch", "llff_horns", "lego", "tiny_fern")
PLAIN = {"playbot": "playbot_125k_sh3pad", "flowers": "flowers_lod1"}  # cameras and scene
SCREENS = ((390, 844), (820, 1180), (1440, 900), (844, 390))
PIXELS = 96  # of the longer side of measured pictures
RANDOM = 64  # views inside the limits, on each screen


def run_of(folder: Path, name: str, minutes: float) -> tuple[Path, Path]:
    """Return the run on a capture and the capture; train it first if it does not exist."""
    run = folder / name
    capture = Path(os.environ["MOBILEGS_DATA"]) / name
    if name == SAMPLE:
        capture = folder / "sample_capture"
        if not capture.exists():
            write_capture(capture)
    words = ["train", str(capture), "--output", str(run), "--minutes", str(minutes)]
    if not (run / "scene.mgs").exists() and command(words):
        sys.exit(f"{name} could not be trained")
    return run / "scene.mgs", capture


def small(camera: Camera) -> Camera:
    share = PIXELS / max(camera.width, camera.height)
    return camera.resized(round(share * camera.width), round(share * camera.height))


def anywhere(limits: Limits, start: Start, up: np.ndarray, rng: np.random.Generator) -> Pose:
    """Return a random pose inside the limits."""
    sector = int(rng.choice(np.flatnonzero(limits.open)))
    azimuth, low, high = limits.range_at(360 * (sector + rng.random()) / SECTORS)
    distance = math.exp(rng.uniform(math.log(limits.nearest), math.log(limits.farthest)))
    away = rng.normal(size=3)
    target = limits.pivot + limits.pan * rng.random() ** (1 / 3) * away / np.linalg.norm(away)
    eye = target + distance * direction_of(azimuth, rng.uniform(low, high), up)
    return Pose.from_start(replace(start, eye=eye, target=target), up)


def former_pose(scene: Scene, views: list[Camera], up: np.ndarray) -> Pose:
    """Return the first view without notes: without cameras, at 50 degrees."""
    if views:
        return Pose.from_views(views, up=up)
    pose = Pose.around(scene.gaussians.means.numpy(), up)
    pose.box = None
    return pose


@torch.no_grad()
def measure(
    scene: Scene, cameras: list[Camera], framing: Framing, pictures: Path | None, *, plain: bool
) -> dict:
    """Return unseen shares of a scene by screen; a plain one is shown without its cameras."""
    up = USUAL if scene.up is None else scene.up
    views = [] if plain else cameras
    coverage = Coverage(scene, cameras)
    subject = find_subject(coverage)
    found: dict[str, dict] = {}
    for width, height in SCREENS:

        def camera(pose: Pose, size: tuple[int, int] = (width, height)) -> Camera:
            return camera_of(pose, views[0] if views else None, *size, scene.near)

        def unseen(pose: Pose, camera=camera) -> float:
            return float(coverage.unseen(small(camera(pose))).float().mean())

        pose = first_pose(replace(scene, framing=framing), views, size=(width, height))
        shown = camera(pose)
        row = {"first_view": unseen(pose), "before": unseen(former_pose(scene, views, up))}
        found[f"{width}x{height}"] = row
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            image = to_bytes(scene.render(shown).image).numpy()
            Image.fromarray(image).save(pictures / f"{width}x{height}.png")
        if subject is None:
            continue
        local = subject @ shown.viewmat[:3, :3].T + shown.viewmat[:3, 3]
        x, y, _ = (local @ shown.K.T / local[:, 2:]).T
        inside = (x > 0) & (x < width) & (y > 0) & (y < height)
        row["subject"] = float(inside.float().mean())
        limits = framing.limits_for(width, height)
        if limits is None:
            continue
        rng = np.random.default_rng(0)
        start = framing.start_for(width, height)
        assert start is not None
        shares = [unseen(anywhere(limits, start, up, rng)) for _ in range(RANDOM)]
        row["inside_mean"] = float(np.mean(shares))
        row["inside_p90"] = float(np.quantile(shares, 0.9))
        row["inside_most"] = max(shares)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--pictures", type=Path, help="write the first views here")
    parser.add_argument("--minutes", type=float, default=1.2)
    options = parser.parse_args()
    if not os.environ.get("MOBILEGS_DATA"):
        sys.exit("set MOBILEGS_DATA to the folder that holds the captures")
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
        "scenes": {},
    }
    for name in CAPTURES:
        path, capture = run_of(options.runs, name, options.minutes)
        coded = read_mgs(path)
        scene = coded.decode("cpu")
        views = [frame.camera for frame in load_capture(capture).train]
        began = time.perf_counter()
        framing = find_framing(scene, views)
        seconds = time.perf_counter() - began
        pictures = options.pictures / name if options.pictures else None
        found = {
            "gaussians": len(coded),
            "cameras": len(views),
            "seconds": seconds,
            "note_bytes": sum(len(text) for text in framing.notes.values()),
            "open_sectors": [
                sum(limits.open) if limits else 0
                for limits in (framing.limits, framing.portrait_limits)
            ],
            "screens": measure(scene, views, framing, pictures, plain=False),
        }
        result["scenes"][name] = found
        print(name, json.dumps(found), flush=True)
    folder = Path(os.environ["MOBILEGS_DATA"]) / "splats"
    for name, file in PLAIN.items():
        scene = open_scene(folder / f"{file}.ply")
        cameras = read_cameras_json(folder / f"{name}_cameras.json")
        pictures = options.pictures / name if options.pictures else None
        screens = measure(scene, cameras, Framing(), pictures, plain=True)
        found = {"gaussians": len(scene.gaussians), "cameras": len(cameras), "screens": screens}
        result["scenes"][name] = found
        print(name, json.dumps(found), flush=True)
    if options.json:
        options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
