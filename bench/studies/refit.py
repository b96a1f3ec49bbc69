"""Measure the loss of students that are refitted for viewers that sort.

    python -m bench.studies.refit RUNS [--data DIR] [--json OUT] [--pictures DIR]
        [--scenes horns-250 ...]

RUNS holds NAME.mgs for each scene: students that bench/paper/run.py trained on the small captures
in DIR (default: MOBILEGS_DATA). Each is refitted twice: from the cameras of its photos, and
without its capture, from the four cameras that the file holds. Both are compared at the held-back
cameras, with the sort-free renders and with the photos. Training on its own renders only, or on
photos only, is measured as well.
"""

import argparse
import json
import os
import platform
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch
from PIL import Image

from bench.paper.run import CAPTURES, find_capture
from mobilegs.atomic import atomic_write
from mobilegs.data import load_capture
from mobilegs.data.dataset import Dataset, load_view
from mobilegs.evaluate.metrics import to_bytes
from mobilegs.evaluate.report import evaluate
from mobilegs.gaussians import Gaussians
from mobilegs.mgs.codec import read_mgs
from mobilegs.pipeline.refit import STEPS, Views, measure_fit, refit, views_around, views_from
from mobilegs.pipeline.train import FIRST_LOOKS
from mobilegs.render.scene import Scene
from mobilegs.scene_file import PLAIN, Kind, write_gaussians

SCENES = ("horns-250", "lego-200")
KINDS: tuple[Kind, ...] = ("ply", "spz", "sog", "glb")


def as_read(gaussians: Gaussians, kind: Kind) -> Gaussians:
    """Return Gaussians after a round trip through a file format."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"refitted.{kind}"
        write_gaussians(path, gaussians, kind)
        return PLAIN[path.suffix](path)


@torch.inference_mode()
def pictures(folder: Path, name: str, data: Dataset, scenes: list[Scene]) -> None:
    """A row for each of some held-back places: the photo, then every scene's picture."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for frame in data.test[:3]:
        drawn = [scene.render(frame.camera).image for scene in scenes]
        rows.append(torch.cat([load_view(frame).image, *drawn], dim=1))
    Image.fromarray(to_bytes(torch.cat(rows)).numpy()).save(folder / f"{name}.png")


def measured(name: str, path: Path, data: Path, folder: Path | None) -> dict[str, Any]:
    place = CAPTURES[name]
    capture = find_capture(data, place)
    if capture is None:
        raise SystemExit(f"{data} holds no capture for {name}")
    scene = read_mgs(path).decode("cpu")
    background = tuple(scene.background.tolist())
    dataset = load_capture(capture, downscale=place.downscale, background=background)
    views = views_from(scene, dataset)
    began = time.monotonic()
    found = refit(scene, views, seed=0)
    seconds = time.monotonic() - began
    files = {kind: asdict(measure_fit(scene, as_read(found, kind), views)) for kind in KINDS}
    looks = dataset.train[:: max(1, len(dataset.train) // FIRST_LOOKS)][:FIRST_LOOKS]
    alone = views_around(scene, [frame.camera for frame in looks], seed=0)
    began = time.monotonic()
    without = refit(scene, alone, seed=0)
    seconds_without = time.monotonic() - began

    def sorts(gaussians: Gaussians) -> Scene:
        return Scene(gaussians, background=scene.background, near=scene.near)

    if folder is not None:
        shown = [scene, sorts(scene.gaussians), sorts(found), sorts(without)]
        pictures(folder, name, views.photos or dataset, shown)
    targets = {"own": Views(views.renders)}
    if views.photos is not None:
        targets["photos"] = Views(views.photos)
    camera = views.renders.train[0].camera
    return {
        "gaussians": len(found),
        "bytes": path.stat().st_size,
        "image_size": [camera.width, camera.height],
        "steps": STEPS,
        "photos_before": evaluate(sorts(scene.gaussians), views.photos or dataset)["psnr"],
        "with_capture": {"seconds": seconds, "files": files},
        "learned_from": {
            what: asdict(measure_fit(scene, refit(scene, some, seed=0), views))
            for what, some in targets.items()
        },
        "without_capture": {
            "seconds": seconds_without,
            "from_the_capture's_places": asdict(measure_fit(scene, without, views)),
            "from_its_own": asdict(measure_fit(scene, without, alone)),
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("runs", type=Path)
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--json", type=Path, default=Path("refit.json"))
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(CAPTURES))
    options = parser.parse_args()
    if options.data is None:
        parser.error("--data, or MOBILEGS_DATA, must name the folder of captures")
    found = json.loads(options.json.read_text()) if options.json.exists() else {}
    for name in options.scenes:
        row = measured(name, options.runs / f"{name}.mgs", options.data, options.pictures)
        row["device"] = f"{platform.machine()}, {os.cpu_count()} cores"
        row["threads"] = torch.get_num_threads()
        row["date"] = time.strftime("%Y-%m-%d")
        found[name] = row
        atomic_write(options.json, json.dumps(found, indent=1) + "\n")
        print(name, json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
