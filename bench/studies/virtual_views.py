"""Draw a scene between its training cameras: frames of a path, a contact sheet, flicker.

    python -m bench.studies.virtual_views CAPTURE TEACHER.ply SCENE.mgs [MORE.mgs ...] -o FOLDER
        [--downscale N] [--stops 12] [--between 9]

The path runs through evenly chosen training cameras in the order of their names, on straight
lines and shortest rotations. FOLDER gets path.png (rows of frames midway between two cameras: the
teacher, then each scene), path.json, and one animated WebP per scene. path.json has each scene's
PSNR against the teacher, on the stops and between them, and its flicker: the mean absolute
difference between its change from frame to frame and the teacher's, in 1/255.
"""

import argparse
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.data import load_capture
from mobilegs.evaluate.metrics import as_displayed, psnr, to_bytes
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene

SHOWN = 8  # frames in a row of the sheet


def path_through(cameras: list[Camera], between: int) -> list[Camera]:
    """Return `between` cameras on the way from each camera to the next."""
    shares = [step / (between + 1) for step in range(between + 1)]
    return [one.interpolate(other, share) for one, other in pairwise(cameras) for share in shares]


@torch.inference_mode()
def frames_of(scene: Scene, cameras: list[Camera]) -> list[torch.Tensor]:
    return [as_displayed(scene.render(camera).image) for camera in cameras]


def write_video(path: Path, frames: list[torch.Tensor]) -> None:
    """Write an animated WebP, which every browser plays."""
    first, *others = [Image.fromarray(to_bytes(image).numpy()) for image in frames]
    first.save(path, save_all=True, append_images=others, duration=50, loop=0, quality=80, method=2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("scenes", type=Path, nargs="+", metavar="SCENE")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--stops", type=int, default=12)
    parser.add_argument("--between", type=int, default=9)
    options = parser.parse_args()
    if options.stops < 2 or options.between < 1:
        parser.error("a path needs two stops and a frame between them")
    dataset = load_capture(options.capture, downscale=options.downscale)
    cameras = [frame.camera for frame in dataset.train]
    stops = cameras[:: max(1, len(cameras) // options.stops)]
    path = path_through(stops, options.between)
    options.output.mkdir(parents=True, exist_ok=True)
    middles = range(options.between // 2 + 1, len(path), options.between + 1)
    shown = list(middles)[:: max(1, len(middles) // SHOWN)][:SHOWN]
    rows, figures, reference = [], {}, None
    for file in options.scenes:
        scene = open_scene(file, torch.device("cpu"))
        if scene.blend == "sorted":  # a .ply does not say
            scene = replace(scene, background=dataset.background, near=dataset.near)
        frames = frames_of(scene, path)
        rows.append(torch.cat([frames[i] for i in shown], dim=1))
        write_video(options.output / f"{len(rows)}_{file.stem}.webp", frames)
        if reference is None:
            reference = frames
            continue
        quality = [psnr(a, b) for a, b in zip(frames, reference, strict=True)]
        at = [q for i, q in enumerate(quality) if i % (options.between + 1) == 0]
        off = [q for i, q in enumerate(quality) if i % (options.between + 1)]
        changes = [[b - a for a, b in pairwise(some)] for some in (frames, reference)]
        steps = [(a - b).abs().mean() for a, b in zip(*changes, strict=True)]
        figures[str(file)] = {
            "psnr_to_teacher_at_stops": round(sum(at) / len(at), 3),
            "psnr_to_teacher_between": round(sum(off) / len(off), 3),
            "worst_between": round(min(off), 3),
            "flicker": round(float(255 * sum(steps) / len(steps)), 4),
        }
        print(file, json.dumps(figures[str(file)]))
    Image.fromarray(to_bytes(torch.cat(rows)).numpy()).save(options.output / "path.png")
    (options.output / "path.json").write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
