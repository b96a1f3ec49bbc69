"""Measure what other formats keep of a scene, and whether splat-transform reads them alike.

    python -m bench.studies.formats --json bench/results/formats.json
        [--peers .../splat-transform/cli.mjs]

The script writes every scene of MOBILEGS_DATA/splats in each format, reads it back, and compares
numbers and renders. With --peers, splat-transform (3.7.0) writes and reads them too. Without a
GPU it needs over ten minutes to cluster spherical harmonics, so its .sog has none.
"""

import argparse
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

import torch
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.formats.ply import read_ply
from mobilegs.formats.sog import morton_order
from mobilegs.formats.spz import SH_SIGNS
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.scene_file import PLAIN, WRITERS

SCENES = {
    "flowers": ("flowers_lod1.ply", "flowers_cameras.json"),
    "playbot": ("playbot_125k_sh3pad.ply", "playbot_cameras.json"),
}
SIDE, EVERY = 400, 6  # longer side of a picture in pixels; every 6th camera


def cameras_of(path: Path) -> list[Camera]:
    """Return some of the cameras of an INRIA `cameras.json`, at `SIDE` pixels."""
    found = []
    for row in json.loads(path.read_text())[::EVERY]:
        turn, eye = torch.tensor(row["rotation"]), torch.tensor(row["position"])
        viewmat = torch.eye(4)
        viewmat[:3, :3], viewmat[:3, 3] = turn.T, -turn.T @ eye
        middle = row["width"] / 2, row["height"] / 2
        K = torch.tensor([[row["fx"], 0, middle[0]], [0, row["fy"], middle[1]], [0, 0, 1]])
        camera = Camera(viewmat, K, row["width"], row["height"])
        found.append(camera.resized(SIDE, round(SIDE * row["height"] / row["width"])))
    return found


def parts(one: Gaussians, other: Gaussians) -> dict[str, torch.Tensor]:
    """Return differences by name; for rotations the distance of unit quaternions up to the sign."""
    a, b = normalize(one.quats, dim=1), normalize(other.quats, dim=1)
    return {
        "means": one.means - other.means,
        "rotations": torch.minimum((a - b).norm(dim=1), (a + b).norm(dim=1)),
        "log_scales": one.log_scales - other.log_scales,
        "opacities": one.opacities - other.opacities,
        "colours": one.sh[:, 0] - other.sh[:, 0],
        "harmonics": one.sh[:, 1:] - other.sh[:, 1:],
    }


def largest(one: Gaussians, other: Gaussians) -> dict[str, float]:
    if len(one) != len(other):
        return {"count": len(one) - len(other)}
    return {n: float(v.abs().max()) if v.numel() else 0.0 for n, v in parts(one, other).items()}


def ordered_as(found: Gaussians, made: Gaussians) -> Gaussians:
    """Return the scene in the order that it had before it was written as `.sog`."""
    back = torch.empty(len(made), dtype=torch.long)
    back[morton_order(made.means)] = torch.arange(len(made))
    return found.select(back)


def turned(scene: Gaussians) -> Gaussians:
    """Turn by half around x: splat-transform reads the axes of a `.spz` as those of a `.ply`."""
    sh = scene.sh.clone()
    sh[:, 1:] *= torch.from_numpy(SH_SIGNS[: sh.shape[1] - 1])[:, None]
    means, quats = (
        scene.means * torch.tensor([1.0, -1, -1]),
        scene.quats * torch.tensor([1.0, 1, -1, -1]),
    )
    return Gaussians(means, quats, scene.log_scales, scene.logit_opacities, sh)


@torch.no_grad()
def psnr(one: Gaussians, other: Gaussians, cameras: list[Camera]) -> float:
    """Return the mean PSNR of one scene against the other, both blended sorted."""
    found = []
    for camera in cameras:
        a, b = (Scene(g).render(camera).image.clamp(0, 1) for g in (one, other))
        found.append(float(-10 * (a - b).square().mean().clamp_min(1e-12).log10()))
    return sum(found) / len(found)


def kept(source: Gaussians, kind: str, folder: Path, cameras: list[Camera]) -> dict:
    """Return the loss of a round trip through our writer and reader."""
    path = folder / f"ours.{kind}"
    begun = time.perf_counter()
    WRITERS[kind](path, source)
    written = time.perf_counter()
    found = PLAIN[path.suffix](path)
    read = time.perf_counter()
    if kind == "sog":
        found = ordered_as(found, source)
    rms = {name: float(v.square().mean().sqrt()) for name, v in parts(found, source).items()}
    return {
        "bytes_per_gaussian": path.stat().st_size / len(source),
        "write_seconds": written - begun,
        "read_seconds": read - written,
        "psnr": psnr(found, source, cameras),
        "rms": rms,
        "largest": largest(found, source),
    }


def agreement(program: Path, source: Path, folder: Path) -> dict:
    """Return the largest differences between splat-transform's reading of a file and ours."""

    def run(*words: Path | str) -> None:
        subprocess.run(["node", program, "-q", "-w", *words], check=True)

    cells: dict = {}
    theirs: dict[str, list[str]] = {
        "compressed.ply": [],
        "spz": [],
        "v3.spz": ["--spz-version", "3"],
        "sog": ["-H", "0", "-g", "cpu"],
    }
    for kind, words in theirs.items():
        path = folder / f"theirs.{kind}"
        run(source, *words, path)
        cells[f"theirs.{kind}"] = path
    cells |= {f"ours.{kind}": folder / f"ours.{kind}" for kind in ("spz", "sog")}
    for name, path in cells.items():
        back = folder / "back.ply"
        run(path, back)
        other = read_ply(back)
        ours = PLAIN[path.suffix](path)
        cells[name] = largest(ours, turned(other) if path.suffix == ".spz" else other)
    run(source, folder / "theirs.glb")
    glb = [PLAIN[".glb"](folder / f"{whose}.glb") for whose in ("theirs", "ours")]
    cells["theirs.glb, ours.glb"] = largest(*glb)
    return cells


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--json", type=Path, default=Path("formats.json"))
    parser.add_argument("--peers", type=Path, help="splat-transform's cli.mjs")
    options = parser.parse_args()
    result: dict = {"date": time.strftime("%Y-%m-%d"), "cells": {}}
    for name, (ply, views) in SCENES.items():
        path = options.data / "splats" / ply
        source, cameras = read_ply(path), cameras_of(options.data / "splats" / views)
        with tempfile.TemporaryDirectory() as folder:
            plain = path.stat().st_size / len(source)
            cell = {"gaussians": len(source), "ply_bytes_per_gaussian": plain}
            for kind in ("spz", "sog", "glb"):
                cell[kind] = kept(source, kind, Path(folder), cameras)
                print(name, kind, json.dumps(cell[kind]), flush=True)
            if options.peers:
                cell["agreement"] = agreement(options.peers, path, Path(folder))
                print(name, json.dumps(cell["agreement"]), flush=True)
            result["cells"][name] = cell
    options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
