"""Make a scene of another tool small enough for a phone, and see what it lost.

    python examples/compress.py scene.ply runs/small --mb 3

No photos are needed: pictures are taken of the scene itself. Some of them are not learned from, and
the decibels are of those.
"""

import argparse
from pathlib import Path

from mobilegs import CompressRun, compress_run, export_html


def main() -> None:
    options = argparse.ArgumentParser(description="Compress a trained 3DGS scene.")
    options.add_argument("scene", type=Path)
    options.add_argument("run", type=Path)
    options.add_argument("--mb", type=float, help="megabytes that the file shall have")
    options.add_argument("--views", type=int, help="pictures to take")
    options.add_argument("--size", type=int, help="their longer side, in pixels")
    options.add_argument("--steps", type=int)
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
    student = compress_run(run)["student"]
    before, after = given.scene.stat().st_size, student["file_bytes"]
    print(f"{before:,} bytes became {after:,}, {before / after:.1f} times smaller")
    print(f"{student['psnr']:.2f} dB to the scene, from places that were held back")

    page = given.run / "scene.html"
    size = export_html(given.run / "scene.mgs", page, title=given.scene.stem)
    print(f"{page}: {size:,} bytes, with the viewer")


if __name__ == "__main__":
    main()
