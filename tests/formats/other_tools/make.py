r"""Makes the files beside this one: scenes that splat-transform wrote, or read of ours.

In the folder `tests`, once `npm install @playcanvas/splat-transform@3.7.0` was run in another one:

    ../.venv/bin/python -m other_tools.make \
        OTHER/node_modules/@playcanvas/splat-transform/bin/cli.mjs

`theirs.*` it made of `scene.ply`; `*.back.ply` is what it reads of the file before that ending.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

from mobilegs.formats.ply import write_ply
from mobilegs.formats.sog import write_sog
from mobilegs.formats.splat import ROW
from mobilegs.formats.spz import write_spz
from tests.support.plain import plain_scene
from tests.web.test_decoder import node_program

HERE = Path(__file__).parent
COUNT = 12


def main() -> None:
    def convert(*words: str) -> None:
        command = [node_program(), sys.argv[1], "-q", "-w", *words]
        subprocess.run(command, check=True, cwd=HERE)

    scene = plain_scene(COUNT, 3)
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
