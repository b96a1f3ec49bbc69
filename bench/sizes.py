"""Compare a file with held-back photos of other sizes than that of training.

    python -m bench.sizes CAPTURE SCENE.mgs --downscale 2 --name "horns, 250x187" [--json OUT]

`--downscale` is that of training. Images smaller than those of training are averages of larger
ones, as viewers show them. Twice the size is also compared with a bicubic enlargement of the image
at the size of training.
"""

import argparse
from fractions import Fraction
from pathlib import Path
from statistics import mean

import torch
from torch.nn.functional import interpolate

from bench.record import RESULTS, Figures
from mobilegs import load_capture, open_scene
from mobilegs.data.dataset import load_view
from mobilegs.evaluate.metrics import psnr
from mobilegs.render.supersampling import supersampling_for

SIZES = tuple(map(Fraction, ("1/4", "1/2", "1", "2")))


def measure(capture: Path, scene_file: Path, downscale: int) -> dict[str, float]:
    """Return the mean PSNR by size, in dB, and that of the enlargement as `bicubic`."""
    scene = open_scene(scene_file)
    training = load_capture(capture, downscale=downscale)
    seen = [frame.camera for frame in training.train]
    found = {}
    for size in SIZES:
        own, enlarged = [], []
        frames = load_capture(capture, downscale=int(downscale / size)).test
        for frame, usual in zip(frames, training.test, strict=True):
            photo = load_view(frame).image
            supersampling = supersampling_for(frame.camera, seen)
            image = scene.render(frame.camera, supersampling=supersampling).image
            own.append(psnr(image.clamp(0, 1), photo))
            if size > 1:
                small = scene.render(usual.camera).image.movedim(-1, 0)[None]
                large = interpolate(small, size=photo.shape[:2], mode="bicubic")[0]
                enlarged.append(psnr(large.movedim(0, -1).clamp(0, 1), photo))
        found[str(size)] = round(mean(own), 2)
        if enlarged:
            found["bicubic"] = round(mean(enlarged), 2)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--downscale", type=int, required=True)
    parser.add_argument("--name", required=True, help="of the row")
    parser.add_argument("--json", type=Path, default=RESULTS / "sizes.json")
    options = parser.parse_args()
    with torch.no_grad():
        found = measure(options.capture, options.scene, options.downscale)
    Figures(options.json).add(options.name, **found)


if __name__ == "__main__":
    main()
