"""Measure antialiased teachers as tools draw them that have another blur, or none to compensate.

    python -m bench.studies.footprints --captures CAPTURE ... --downscales N ...
        --teachers A.ply ... [--json OUT]

Each teacher is drawn with its own footprint, with a blur of 0.3 px^2 that is compensated, as many
tools draw the mode, and as 3DGS does. PSNR in dB, the mean over the held-back photos.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

from mobilegs.atomic import atomic_write
from mobilegs.data import load_capture
from mobilegs.evaluate.report import evaluate
from mobilegs.render.project import CLASSIC, Footprint
from mobilegs.scene_file import open_scene


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--captures", type=Path, nargs="+", required=True)
    parser.add_argument("--downscales", type=int, nargs="+", required=True)
    parser.add_argument("--teachers", type=Path, nargs="+", required=True)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    found = {}
    for capture, downscale, teacher in zip(
        options.captures, options.downscales, options.teachers, strict=True
    ):
        dataset = load_capture(capture, downscale=downscale)
        scene = open_scene(teacher)
        drawn = {"own": scene.footprint, "mip": Footprint(antialiased=True), "3dgs": CLASSIC}
        row = {}
        for name, footprint in drawn.items():
            seen = replace(
                scene, footprint=footprint, background=dataset.background, near=dataset.near
            )
            row[name] = round(evaluate(seen, dataset)["psnr"], 3)
        camera = dataset.test[0].camera
        found[f"{dataset.name}-{camera.width}"] = row
        print(dataset.name, json.dumps(row), flush=True)
    if options.json:
        atomic_write(options.json, json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
