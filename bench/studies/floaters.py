"""Measure what the filters of `mobilegs edit` take from held-back photos.

    python -m bench.studies.floaters RUN ... [--json OUT]

Each RUN is the folder of a training with its scene.mgs, whose capture is still there. The cameras
of all its training photos are counted, and the held-back ones are compared before and after, at the
size of the training.
"""

import argparse
import json
import platform
import tempfile
import time
from pathlib import Path
from typing import Any

import torch

from mobilegs.cli.render import open_scene_and_capture
from mobilegs.edit.scene_edit import SceneEdit, edit_file
from mobilegs.edit.support import measure_support
from mobilegs.evaluate.report import evaluate
from mobilegs.scene_file import capture_of_run

EDITS = {
    "nothing": SceneEdit(),
    "floaters": SceneEdit(floaters=True),
    "min_cameras 1": SceneEdit(min_cameras=1),
    "min_cameras 3": SceneEdit(min_cameras=3),
    "min_cameras 6": SceneEdit(min_cameras=6),
}


def measure(run: Path, folder: Path) -> dict[str, Any]:
    """Return the removed Gaussians, the bytes and the held-back PSNR of each edit of a run."""
    scene = run / "scene.mgs"
    capture, downscale = capture_of_run(scene)
    assert capture is not None, f"{run} has no capture"
    opened, _, dataset = open_scene_and_capture(scene, capture, downscale, "cpu")
    began = time.perf_counter()
    support = measure_support(opened, [frame.camera for frame in dataset.train])
    found: dict[str, Any] = {
        "capture": capture.name,
        "gaussians": len(opened.gaussians),
        "cameras": support.cameras,
        "seconds_of_counting": round(time.perf_counter() - began, 1),
        "edits": {},
    }
    for name, edit in EDITS.items():
        output = folder / f"{capture.name}-{name}.mgs"
        report = edit_file(scene, output, edit, support=support)
        edited, views, _ = open_scene_and_capture(output, capture, downscale, "cpu")
        result = evaluate(edited, dataset, training_views=views)
        found["edits"][name] = {
            "removed": sum(report.removed.values()),
            "bytes": report.bytes_after,
            "psnr": result["psnr"],
            "ssim": result["ssim"],
        }
        print(capture.name, name, found["edits"][name], flush=True)
    return found


def main() -> None:
    """Measure the runs that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path, nargs="+")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [measure(run, Path(folder)) for run in options.runs]
    about = {"python": platform.python_version(), "torch": torch.__version__}
    if options.json:
        options.json.write_text(json.dumps(about | {"scenes": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
