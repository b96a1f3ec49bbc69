"""Measure scenes drawn at other sizes than that of training, and with levels.

    python -m bench.studies.sizes --capture CAPTURE [--downscale N] --scenes A.mgs B.mgs ...
        [--views N] [--json OUT]

Sizes: the images of a smaller camera, supersampled as viewers do and with one sample per pixel, are
compared with the photos' area average, beside the area average of the image at the training size.
Those of a camera of twice the size are compared with the larger photos, beside the bicubic
enlargement, which needs photos of twice the size (a downscale of 2 or more).

Levels: for each screen (times the training size) and each `level_sigma`, fragments per pixel by
level, the distance to the image with all at full size, and the largest change of a pixel, in 8
bits, between two frames 0.1 degrees apart, beside that of full size ("popping"). An existing JSON
keeps its other captures and scenes.
"""

import argparse
import json
import math
import statistics
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import interpolate

from mobilegs.atomic import atomic_write
from mobilegs.camera import Camera
from mobilegs.data import Dataset, load_capture
from mobilegs.data.dataset import load_view
from mobilegs.evaluate.fragments import mean_fragments
from mobilegs.render.levels import usual_level_sigma
from mobilegs.render.scene import Scene
from mobilegs.render.supersampling import supersampling_for
from mobilegs.scene_file import open_scene

SMALLER = (2, 4)
SCREENS = (1, 2, 3)
SIGMAS = (0.8, 1.0, 1.4)
TURN = math.radians(0.1)


def psnr(image: Tensor, target: Tensor) -> float:
    """Return the PSNR of an image in [0, 1], clamped."""
    return float(-10 * (image.clamp(0, 1) - target).square().mean().log10())


def averaged(image: Tensor, factor: int) -> Tensor:
    """Return means of `factor` x `factor` pixels; drops the rows and columns that are left over."""
    height, width = (side // factor for side in image.shape[:2])
    blocks = image[: height * factor, : width * factor].unflatten(1, (width, factor))
    return blocks.unflatten(0, (height, factor)).mean((1, 3))


def reduced(camera: Camera, factor: int) -> Camera:
    """Return the camera whose pixels are those of `averaged`."""
    k = camera.K.clone()
    k[:2] /= factor
    return replace(camera, K=k, width=camera.width // factor, height=camera.height // factor)


def bicubic(image: Tensor, size: tuple[int, int]) -> Tensor:
    """Return `[h, w, 3]` enlarged to a size."""
    planes = image.permute(2, 0, 1)[None]
    found = interpolate(planes, size=size, mode="bicubic", align_corners=False)
    return found[0].permute(1, 2, 0)


def enlarged(camera: Camera, factor: float) -> Camera:
    """Return the camera with `factor` times the size."""
    return camera.resized(round(camera.width * factor), round(camera.height * factor))


def turned(camera: Camera, angle: float) -> Camera:
    """Return the camera after a turn about its own vertical axis."""
    c, s = math.cos(angle), math.sin(angle)
    turn = torch.tensor([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])
    return replace(camera, viewmat=turn.to(camera.viewmat) @ camera.viewmat)


@torch.inference_mode()
def of_sizes(scene: Scene, dataset: Dataset, larger: Dataset | None, views: int) -> dict[str, Any]:
    """Return PSNR in dB by size: drawn at that size, and resized from the training size."""
    rows: dict[str, list[float]] = {}

    def add(name: str, value: float) -> None:
        rows.setdefault(name, []).append(value)

    for number, frame in enumerate(dataset.test[:views]):
        photo, camera = load_view(frame).image, frame.camera
        full = scene.render(camera).image.clamp(0, 1)
        add("1", psnr(full, photo))
        for factor in SMALLER:
            smaller = reduced(camera, factor)
            target = averaged(photo, factor)
            n = supersampling_for(smaller, [camera])
            add(f"1/{factor}", psnr(scene.render(smaller, supersampling=n).image, target))
            add(f"1/{factor}, one sample", psnr(scene.render(smaller).image, target))
            add(f"1/{factor}, area average", psnr(averaged(full, factor), target))
        if larger is not None:
            photo = load_view(larger.test[number]).image
            size = photo.shape[:2]
            drawn = scene.render(camera.resized(size[1], size[0])).image
            add("2", psnr(drawn, photo))
            add("2, bicubic", psnr(bicubic(full, (size[0], size[1])), photo))
    return {name: round(statistics.mean(values), 3) for name, values in rows.items()}


@torch.inference_mode()
def of_levels(scene: Scene, cameras: list[Camera], screen: int) -> dict[str, Any]:
    """Return fragments, errors and popping at a screen, by `level_sigma`."""
    found: dict[str, Any] = {}
    for sigma in (0.0, *SIGMAS):
        errors, tails, jumps = [], [], []
        for trained in cameras:
            camera = enlarged(trained, screen)
            image, next_image = (
                scene.render(view, level_sigma=sigma).image.clamp(0, 1)
                for view in (camera, turned(camera, TURN))
            )
            jumps.append(float((image - next_image).abs().max()) * 255)
            if sigma:
                error = image - scene.render(camera).image.clamp(0, 1)
                errors.append(float(error.square().mean()))
                tails.append(float(error.abs().amax(2).flatten().quantile(0.999)) * 255)
        screens = [enlarged(camera, screen) for camera in cameras]
        levels = mean_fragments(scene, screens, level_sigma=sigma)
        row: dict[str, Any] = {
            "fragments": round(sum(levels), 3),
            "by_level": [round(value, 3) for value in levels],
            "largest_change": round(max(jumps), 1),
        }
        if sigma:
            row |= {
                "psnr": round(-10 * math.log10(statistics.mean(errors)), 2),
                "p99.9": round(max(tails), 2),
            }
        found[f"{sigma:g}"] = row
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--capture", type=Path, required=True)
    parser.add_argument("--downscale", type=int, default=1)
    parser.add_argument("--scenes", type=Path, nargs="+", required=True)
    parser.add_argument("--names", nargs="+", help="names of the scenes in the JSON")
    parser.add_argument("--views", type=int, default=6)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    dataset = load_capture(options.capture, downscale=options.downscale)
    larger = None
    if options.downscale > 1 and options.downscale % 2 == 0:
        larger = load_capture(options.capture, downscale=options.downscale // 2)
    camera = dataset.test[0].camera
    content = {"image_size": [camera.width, camera.height], "scenes": {}}
    for path, name in zip(options.scenes, options.names or map(str, options.scenes), strict=True):
        scene = open_scene(path)
        cameras = [frame.camera for frame in dataset.test[: options.views]]
        found: dict[str, Any] = {
            "gaussians": len(scene.gaussians),
            "level_sigma": usual_level_sigma(soft_edge=scene.footprint.soft_edge),
            "psnr_by_size": of_sizes(scene, dataset, larger, options.views),
        }
        if scene.blend == "sortfree":
            found["levels"] = {
                str(screen): of_levels(scene, cameras[:2], screen) for screen in SCREENS
            }
        content["scenes"][name] = found
        print(name, json.dumps(found, indent=1), flush=True)
    if options.json:
        before = json.loads(options.json.read_text()) if options.json.exists() else {}
        key = f"{dataset.name}-{camera.width}"
        content["scenes"] = before.get(key, {}).get("scenes", {}) | content["scenes"]
        atomic_write(options.json, json.dumps(before | {key: content}, indent=1) + "\n")


if __name__ == "__main__":
    main()
