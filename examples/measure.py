"""Compare scenes with the photos of a capture that were held back, and name the worst views.

    python examples/measure.py my_capture runs/a/scene.mgs runs/b/scene.mgs --downscale 2

A .mgs brings its background along. Plain scenes are given the capture's.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from mobilegs import Scene, evaluate_side_by_side, load_capture, lpips_from, open_scene


def main() -> None:
    options = argparse.ArgumentParser(description="Measure scenes against a capture.")
    options.add_argument("capture", type=Path)
    options.add_argument("scenes", type=Path, nargs="+")
    options.add_argument("--downscale", type=int)
    given = options.parse_args()

    dataset = load_capture(given.capture, downscale=given.downscale)
    scenes: dict[str, Scene] = {}
    for path in given.scenes:
        scene = open_scene(path)
        if path.suffix != ".mgs":
            scene = replace(scene, background=dataset.background, near=dataset.near)
        scenes[str(path)] = scene

    lpips = lpips_from(None)  # the weights that MOBILEGS_LPIPS names, or none
    figures = evaluate_side_by_side(scenes, dataset, lpips=lpips)
    print(f"{len(dataset.test)} photos held back of {dataset.name}")
    for name, found in figures.items():
        worst = min(found["views"], key=lambda view: view["psnr"])
        distance = "-" if found["lpips_vgg"] is None else f"{found['lpips_vgg']:.4f}"
        print(f"{name}: {found['psnr']:.2f} dB, SSIM {found['ssim']:.4f}, LPIPS {distance}")
        print(f"  worst: {worst['name']} with {worst['psnr']:.2f} dB")


if __name__ == "__main__":
    main()
