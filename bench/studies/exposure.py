"""Train captures whose photos have exposure steps and colour casts, with and without exposures.

    python -m bench.studies.exposure [--json OUT] [--runs FOLDER] [--only bonsai stitch]

A capture is trained as it is and with made steps: each training photo gets a gain of -1 to +1 EV in
light and one of three colour temperatures; or, of the sample, corners that are 40 % darker in
light. Held-back photos stay as they are. Captures come from
MOBILEGS_DATA; the sample is the program's own. Finished runs under FOLDER are not repeated, so the
script resumes.
"""

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

from mobilegs.csrc.binding import kernel_level
from mobilegs.data import load_capture
from mobilegs.data.demo.capture import write_capture

# name: (folder of the data, options of `mobilegs train`)
CAPTURES = {
    "bonsai": ("bonsai", ["--downscale", "4", "--max-splats", "30000"]),
    "stitch": ("stitch", ["--downscale", "4", "--max-splats", "30000"]),
    "sample": ("", ["--max-splats", "30000"]),  # which the program makes itself
}
TEMPERATURES = ((1.0, 1.0, 1.0), (1.12, 1.0, 0.85), (0.88, 1.0, 1.15))  # gains of R, G, B in light
# without steps, auto learns none on bonsai: then it is the same as never
MODES = {
    "as it is": ("auto", "always"),
    "with steps": ("never", "auto"),
    "with vignetting": ("never", "always", "vignetting"),
}
FALLOFF = 0.4  # share of the light that is missing in the corners of photos with vignetting
SEED = 5


def to_light(values: np.ndarray) -> np.ndarray:
    """Return linear light of sRGB in [0, 1]."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def to_srgb(light: np.ndarray) -> np.ndarray:
    """Return sRGB in [0, 1] of linear light."""
    light = light.clip(0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def with_steps(source: Path, target: Path) -> None:
    """Copy a capture, each training photo with a gain and a colour temperature of its own."""
    if (target / "sparse").exists():
        return
    dataset = load_capture(source)
    held_back = {frame.name for frame in dataset.test}
    stops = np.random.default_rng(SEED).permutation(np.linspace(-1, 1, len(dataset.train)))
    changes = {
        frame.name: 2**stop * np.array(TEMPERATURES[number % len(TEMPERATURES)])
        for number, (frame, stop) in enumerate(zip(dataset.train, stops, strict=True))
    }
    (target / "images").mkdir(parents=True, exist_ok=True)
    for photo in sorted((source / "images").iterdir()):
        copy = target / "images" / photo.name
        if photo.name in held_back:
            shutil.copyfile(photo, copy)
            continue
        pixels = np.asarray(Image.open(photo).convert("RGB")) / 255
        changed = to_srgb(to_light(pixels) * changes[photo.name])
        Image.fromarray((255 * changed).round().astype(np.uint8)).save(copy, quality=97)
    shutil.copytree(source / "sparse", target / "sparse")  # last: the copy is complete


def with_vignetting(source: Path, target: Path) -> None:
    """Copy a capture, the light of each training photo less towards the corners."""
    if (target / "sparse").exists():
        return
    held_back = {frame.name for frame in load_capture(source).test}
    (target / "images").mkdir(parents=True, exist_ok=True)
    for photo in sorted((source / "images").iterdir()):
        pixels = np.asarray(Image.open(photo).convert("RGB")) / 255
        height, width = pixels.shape[:2]
        y, x = np.mgrid[:height, :width] + 0.5
        squares = (x - width / 2) ** 2 + (y - height / 2) ** 2
        fall = 1 - FALLOFF * squares / ((width / 2) ** 2 + (height / 2) ** 2)
        fall = 1 if photo.name in held_back else fall[..., None]
        changed = (255 * to_srgb(to_light(pixels) * fall)).round().astype(np.uint8)
        Image.fromarray(changed).save(target / "images" / photo.name, quality=97)
    shutil.copytree(source / "sparse", target / "sparse")  # last: the copy is complete


def train(capture: Path, output: Path, options: list[str], learned: str, data: Path) -> dict:
    """Train through the command line and return the metrics."""
    command = [sys.executable, "-m", "mobilegs", "train", str(capture), "-o", str(output)]
    command += ["--preset", "cpu", "--resume", *options]
    for stage in ("teacher", "student"):
        if learned == "vignetting":
            command += ["--set", f"{stage}.exposure.learned=always"]
            command += ["--set", f"{stage}.exposure.vignetting=true"]
        else:
            command += ["--set", f"{stage}.exposure.learned={learned}"]
    if (data / "lpips").exists():
        command += ["--lpips-weights", str(data / "lpips")]
    subprocess.run(command, check=True)
    return json.loads((output / "metrics.json").read_text())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--runs", type=Path, default=Path("runs/exposure"), help="where runs are")
    parser.add_argument("--only", nargs="+", default=[*CAPTURES])
    parser.add_argument("--set", dest="settings", nargs="*", default=[], help="more settings")
    options = parser.parse_args()
    if not os.environ.get("MOBILEGS_DATA"):
        sys.exit("set MOBILEGS_DATA to the folder that holds the captures")
    data = Path(os.environ["MOBILEGS_DATA"])
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "settings": options.settings,
        "cells": {},
    }
    if options.json and options.json.exists():
        result["cells"] = json.loads(options.json.read_text())["cells"]
    for name in options.only:
        folder, train_options = CAPTURES[name]
        if options.settings:
            train_options = [*train_options, "--set", *options.settings]
        changed = options.runs / "captures" / name
        dark = options.runs / "captures" / f"{name}_vignetting"
        source = data / folder if folder else options.runs / "captures" / f"{name}_source"
        if not source.exists():
            write_capture(source)
        with_steps(source, changed)
        with_vignetting(source, dark)
        captures = {"as it is": source, "with steps": changed, "with vignetting": dark}
        for photos, modes in MODES.items():
            if name != "sample" and photos == "with vignetting":
                continue  # real photos have their own, which nobody knows
            for learned in modes:
                output = options.runs / f"{name}-{photos.replace(' ', '-')}-{learned}"
                found = train(captures[photos], output, train_options, learned, data)
                for who in ("teacher", "student"):
                    found[who].pop("views")
                result["cells"][f"{name}, {photos}, {learned}"] = found
                if options.json:
                    options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
