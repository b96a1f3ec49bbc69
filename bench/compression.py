"""Compare the formats that hold one teacher, and a student of it: bytes, quality, seconds.

    python -m bench.compression NAME --capture DIR --ply TEACHER.ply [--mgs STUDENT.mgs]
        [--downscale N] [--peers FOLDER/node_modules/.bin/splat-transform] [--json OUT]

@playcanvas/splat-transform (npm, 2.7.1 or newer) writes `.spz`, `.sog` and compressed `.ply` files
of the teacher and reads them back; mobilegs writes and reads another `.sog`, and reads the `.mgs`.
Figures are of the capture's held-back photos, LPIPS (VGG) of every fourth. *encode* and *decode*
are seconds of whole commands, or of mobilegs's functions. The formats hold another kind of scene
than the `.mgs` (sorted, all harmonics), so compare whole rows.
"""

import argparse
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from bench.record import RESULTS, Figures, data_folder
from mobilegs.data import Dataset, load_capture
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.ply import read_ply
from mobilegs.formats.sog import read_sog, write_sog
from mobilegs.formats.spz import read_spz
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.scene_file import open_scene

LPIPS_EVERY = 4
OWN = "sog by mobilegs"
# suffix and options of splat-transform
PEERS = {"spz": (".spz",), "sog": (".sog", "-g", "cpu"), "compressed.ply": (".compressed.ply",)}
CPU = torch.device("cpu")


def quality(scene: Scene, dataset: Dataset, lpips: LpipsSuite | None) -> dict[str, Any]:
    """Return PSNR and SSIM of all held-back photos, LPIPS of a few."""
    found = evaluate(scene, dataset)
    row = {"gaussians": len(scene.gaussians), "psnr": found["psnr"], "ssim": found["ssim"]}
    if lpips is not None:
        some = replace(dataset, test=dataset.test[::LPIPS_EVERY])
        row["lpips_vgg"] = evaluate(scene, some, lpips=lpips)["lpips_vgg"]
    return row


def seconds(work: Callable[[], object]) -> float:
    """Return the seconds that a call takes."""
    started = time.perf_counter()
    work()
    return round(time.perf_counter() - started, 3)


def peer(program: Path, source: Path, suffix: str, more: tuple[str, ...]) -> tuple[Gaussians, dict]:
    """Convert a `.ply` to a format and back; return what came back, its bytes and the seconds."""
    with tempfile.TemporaryDirectory() as folder:
        there, back = Path(folder) / f"there{suffix}", Path(folder) / "back.ply"

        def convert(*paths: Path) -> float:
            """Return the seconds of a conversion."""
            command = [program, "-q", "-w", *more, *paths]
            return seconds(lambda: subprocess.run(command, check=True))

        encode, decode = convert(source, there), convert(there, back)
        # fully opaque Gaussians of a .spz have no finite logit in a .ply
        found = read_spz(there) if suffix == ".spz" else read_ply(back)
        size = there.stat().st_size
    return found, {"bytes": size, "encode_seconds": encode, "decode_seconds": decode}


def own_sog(source: Gaussians) -> tuple[Gaussians, dict]:
    """Write a scene as a `.sog` of mobilegs and read it; return it, its bytes and the seconds."""
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder) / "there.sog"
        encode = seconds(lambda: write_sog(there, source))
        started = time.perf_counter()
        found = read_sog(there)
        decode = round(time.perf_counter() - started, 3)
        row = {"bytes": there.stat().st_size, "encode_seconds": encode, "decode_seconds": decode}
        return found, row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", help="of the capture, in the results")
    parser.add_argument("--capture", type=Path, required=True)
    parser.add_argument("--ply", type=Path, required=True, help="the sorted teacher")
    parser.add_argument("--mgs", type=Path, help="its student")
    parser.add_argument("--downscale", type=int)
    parser.add_argument("--peers", type=Path, help="the program splat-transform")
    parser.add_argument("--json", type=Path, default=RESULTS / "compression.json")
    options = parser.parse_args()
    dataset = load_capture(options.capture, downscale=options.downscale)
    figures = Figures(options.json)
    weights = data_folder() / "lpips"
    lpips = lpips_from(weights) if weights.exists() else None
    teacher = open_scene(options.ply, CPU)
    for kind, path in (("teacher", options.ply), ("mgs", options.mgs)):
        if path and f"{options.name}/{kind}" not in figures.rows:
            row = quality(open_scene(path, CPU), dataset, lpips)
            figures.add(f"{options.name}/{kind}", **row, bytes=path.stat().st_size)
    if f"{options.name}/{OWN}" not in figures.rows:
        found, row = own_sog(teacher.gaussians)
        scene = replace(teacher, gaussians=found)
        figures.add(f"{options.name}/{OWN}", **quality(scene, dataset, lpips), **row)
    for kind, (suffix, *more) in PEERS.items() if options.peers else ():
        if f"{options.name}/{kind}" not in figures.rows:
            found, row = peer(options.peers, options.ply, suffix, tuple(more))
            figures.add(
                f"{options.name}/{kind}",
                **quality(replace(teacher, gaussians=found), dataset, lpips),
                **row,
            )


if __name__ == "__main__":
    main()
