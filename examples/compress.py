"""Compress a scene of another tool for a phone, and measure the loss of quality.

    python examples/compress.py scene.ply runs/small --mb 3

No photos are needed: training uses images that are rendered from the scene itself. Some of these
images are held back, and the PSNR is measured on them.
"""

import argparse
from pathlib import Path

from mobilegs import CompressRun, compress_scene, export_html


def main() -> None:
    options = argparse.ArgumentParser(description="Compress a trained 3DGS scene.")
    options.add_argument("scene", type=Path)
    options.add_argument("run", type=Path)
    options.add_argument("--mb", type=float, help="target size of the file in megabytes")
    options.add_argument("--views", type=int, help="number of images to render")
    options.add_argument("--size", type=int, help="longer side of an image, in pixels")
    options.add_argument("--steps", type=int, help="training steps")
    given = options.parse_args()

    run = CompressRun(
        given.scene,
        given.run,
        target_mb=given.mb,
        views=given.views,
        size=given.size,
        steps=given.steps,
        resume=True,
    )
    student = compress_scene(run)["student"]
    before, after = given.scene.stat().st_size, student["file_bytes"]
    print(f"{before:,} bytes became {after:,}, {before / after:.1f} times smaller")
    print(f"{student['psnr']:.2f} dB to the original scene, on held-back views")

    page = given.run / "scene.html"
    size = export_html(given.run / "scene.mgs", page, title=given.scene.stem)
    print(f"{page}: {size:,} bytes, viewer included")


if __name__ == "__main__":
    main()
