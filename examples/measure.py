"""Compare scenes with the held-back photos of a capture, and name their worst views.

    python examples/measure.py my_capture runs/a/scene.mgs runs/b/scene.mgs --downscale 2

A .mgs has its own background; scenes in other formats use that of the capture.
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

    lpips = lpips_from(None)  # weights from the path in MOBILEGS_LPIPS, if it is set
    results = evaluate_side_by_side(scenes, dataset, lpips=lpips)
    print(f"{len(dataset.test)} held-back photos of {dataset.name}")
    for name, metrics in results.items():
        worst = min(metrics["views"], key=lambda view: view["psnr"])
        distance = "-" if metrics["lpips_vgg"] is None else f"{metrics['lpips_vgg']:.4f}"
        print(f"{name}: {metrics['psnr']:.2f} dB, SSIM {metrics['ssim']:.4f}, LPIPS {distance}")
        print(f"  worst view: {worst['name']} with {worst['psnr']:.2f} dB")


if __name__ == "__main__":
    main()
