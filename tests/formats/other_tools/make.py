r"""Makes the files in this folder with splat-transform.

Run `npm install @playcanvas/splat-transform@3.7.0` in another folder OTHER, then here in the root:

    .venv/bin/python -m tests.formats.other_tools.make \
        OTHER/node_modules/@playcanvas/splat-transform/bin/cli.mjs

splat-transform writes `theirs.*` from `scene.ply`, and reads NAME to write NAME.back.ply.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

from mobilegs.formats.ply import write_ply
from mobilegs.formats.sog import write_sog
from mobilegs.formats.splat import ROW
from mobilegs.formats.spz import write_spz
from tests.support.node import node_program
from tests.support.random_scenes import random_scene

HERE = Path(__file__).parent
COUNT = 12


def main() -> None:
    def convert(*words: str) -> None:
        command = [node_program(), sys.argv[1], "-q", "-w", *words]
        subprocess.run(command, check=True, cwd=HERE)

    scene = random_scene(COUNT, 3)
    write_ply(HERE / "scene.ply", scene)
    write_spz(HERE / "ours.spz", scene)
    write_sog(HERE / "ours.sog", scene)
    rows = np.zeros(COUNT, ROW)
    rows["mean"], rows["scale"] = scene.means, scene.scales
    random = np.random.default_rng(0)
    rows["color"], rows["rotation"] = random.integers(1, 255, (2, COUNT, 4))
    (HERE / "rows.splat").write_bytes(rows.tobytes())
    convert("scene.ply", "theirs.compressed.ply")
    convert("scene.ply", "theirs.glb")
    convert("scene.ply", "theirs.spz")
    convert("--spz-version", "3", "scene.ply", "theirs_v3.spz")
    convert("-g", "cpu", "scene.ply", "theirs.sog")
    read = ["theirs.compressed.ply", "theirs.spz", "theirs_v3.spz", "theirs.sog"]
    for name in [*read, "ours.spz", "ours.sog", "rows.splat"]:
        convert(name, f"{name}.back.ply")


if __name__ == "__main__":
    main()
