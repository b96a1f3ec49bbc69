"""Measure size against quality: both quantisation methods, and other formats of the teacher.

    python -m bench.studies.compression [--json OUT] [--runs RUNS] [--steps 2000]
        [--scenes bonsai horns lego playbot] [--peers FOLDER/node_modules/.bin/splat-transform]

One student per scene learns without quantisation for 0.7 of its steps. From there each variant
goes on by itself:

- `plain`: without quantisation to the end; losses are measured against it;
- `sq-0.001`: scalar quantisation with a rate weight of 0.001;
- `sq-quality-2`: quality 2, that is step sizes half as large and a quarter of the rate weight;
- `nvq-large`: codebooks with four to eight times as many entries;
- `sq-early-2`: `sq-quality-2` with a rate term before quantisation, as the presets have it; this
  student learns by itself from the start.

Teachers are those of bench/paper/run.py under RUNS, trained if they are missing. `playbot` is a
`.ply` without photos; renders from an orbit around it take their place. Figures are of held-back
photos. *encode* and *decode* are the seconds of `pack`, and of `unpack` plus `decode`. *Levels*
are the bytes with two and three LOD levels, and the PSNR of the first levels. Peers are formats
that @playcanvas/splat-transform (npm) writes of the sorted teacher and reads back; their losses
are measured against the teacher. They hold another kind of scene (sorted, SH degree 3), so
compare whole lines.
"""

import argparse
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from bench.paper.rows import BASE, CODEBOOKS
from bench.paper.run import CAPTURES, ROWS, Work, recipe_of, teacher_of
from bench.studies.formats import turned
from mobilegs.camera import Camera
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import Dataset, ViewLoader, load_capture, load_view
from mobilegs.data.dataset import Frame, assemble, split_every_eighth
from mobilegs.evaluate.lpips import LpipsSuite, lpips_from
from mobilegs.evaluate.report import evaluate
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.formats.spz import read_spz
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.mgs.lod import with_lod_levels
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import Team
from mobilegs.train.recipes import cpu_recipe, with_settings
from mobilegs.train.stage import view_order
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.trainer import Student

SCENES = {"bonsai": "bonsai-400", "horns": "horns-250", "lego": "lego-200"}
SPLATS = {"playbot": ("playbot_125k_sh3pad.ply", "playbot_cameras.json")}
SIDE = 400  # pixels, of pictures of splats
LPIPS_EVERY = 4
RATE_WEIGHTS = (0.0003, 0.001, 0.003, 0.01)
CANONICAL = "ablation.canonical_rotations=true"
STEPS = ("quantization.method=sq", "schedule.quantize_from=0.9")
EARLY = (*STEPS, "schedule.rate_from=0.4")  # the others have a rate term from quantize_from on
LARGE = (
    "quantization.codebooks.scale=256",
    "quantization.codebooks.rotation=4096",
    "quantization.codebooks.appearance=4096",
    "quantization.codebooks.opacity=256",
    "view_dependence.codebook_size=512",
)
VARIANTS: dict[str, tuple[str, ...]] = {
    "plain": ("schedule.quantize_from=1",),
    "nvq": (),
    "nvq-canonical": (CANONICAL,),
    "sq-fixed": (*STEPS, "quantization.quality=1", "lr.step_sizes=0"),
    **{
        f"sq-{weight}": (*STEPS, "quantization.quality=1", f"quantization.rate_weight={weight}")
        for weight in RATE_WEIGHTS
    },
    **{f"sq-quality-{fine}": (*STEPS, f"quantization.quality={fine}") for fine in (1.5, 2, 3, 4)},
    **{f"sq-early-{fine}": (*EARLY, f"quantization.quality={fine}") for fine in (1.5, 2, 3)},
    "nvq-large": LARGE,
}
LAYERS = 3
LAYERED = ("nvq", "sq-0.001")  # whose layers are looked at
PEERS = {"spz": (".spz",), "sog": (".sog", "-g", "cpu"), "compressed.ply": (".compressed.ply",)}


def capture_of(name: str, options: argparse.Namespace) -> tuple[Dataset, Scene, StudentConfig]:
    """Return the photos, the sorted teacher, and the config of its student."""
    if name in SPLATS:
        dataset, teacher = orbited(name, options.data)
        config = with_settings(cpu_recipe(), CODEBOOKS).student
        return dataset, teacher, replace(config, steps=options.steps)
    place = CAPTURES[SCENES[name]]
    capture = options.data / place.folders[0]
    dataset = load_capture(capture, downscale=place.downscale)
    asked = argparse.Namespace(runs=options.runs, steps=None, set=())
    with ViewLoader(dataset.train) as loader:
        team = Team(torch.device("cpu"))
        work = Work(SCENES[name], place, capture, dataset, loader, team, asked)
        teacher, _, _ = teacher_of(ROWS[BASE], options.teacher_seed, work)
    config = recipe_of(place, ROWS[BASE], asked).student
    return dataset, teacher, replace(config, steps=options.steps)


def orbited(name: str, data: Path) -> tuple[Dataset, Scene]:
    """Return a scene without photos as a capture: renders from the cameras.json next to it."""
    ply, cameras = SPLATS[name]
    scene, frames = Scene(read_ply(data / "splats" / ply)), []
    for row in json.loads((data / "splats" / cameras).read_text()):
        turn, eye = torch.tensor(row["rotation"]), torch.tensor(row["position"])
        viewmat = torch.eye(4)
        viewmat[:3, :3], viewmat[:3, 3] = turn.T, -turn.T @ eye
        K = torch.tensor(
            [[row["fx"], 0, row["width"] / 2], [0, row["fy"], row["height"] / 2], [0, 0, 1]]
        )
        camera = Camera(viewmat, K, row["width"], row["height"])
        camera = camera.resized(SIDE, round(SIDE * row["height"] / row["width"]))
        with torch.no_grad():
            image = scene.render(camera).image.clamp(0, 1)
        pixels = (255 * image).round().to(torch.uint8)
        frames.append(Frame(row["img_name"], camera, pixels=pixels))
    train, test = split_every_eighth(frames)
    points = scene.gaussians.means[::100]
    colors = torch.full_like(points, 0.5).numpy()
    return assemble(
        name, train, test, points=points.numpy(), colors=colors, background=(0.0, 0.0, 0.0)
    ), scene


def trained(stage: Student, dataset: Dataset, until: int) -> None:
    views = [load_view(frame) for frame in dataset.train]
    while stage.done < until:
        [index] = view_order(len(views), stage.done, 1, 1)
        stage.advance([(index, views[index])])


def student_of(
    settings: tuple[str, ...], config: StudentConfig, dataset: Dataset, teacher: Scene
) -> Student:
    recipe = replace(cpu_recipe(), student=config)
    recipe = with_settings(recipe, (f"student.{setting}" for setting in settings))
    cameras = [frame.camera for frame in dataset.train]
    return Student(recipe.student, teacher, cameras, extent=dataset.extent, seed=0)


def figures(scene: Scene, dataset: Dataset, lpips: LpipsSuite | None) -> dict:
    """Return PSNR and SSIM of all held-back photos, LPIPS (VGG) of a few."""
    found = evaluate(scene, dataset)
    result = {"gaussians": len(scene.gaussians), "psnr": found["psnr"], "ssim": found["ssim"]}
    if lpips is not None:
        some = replace(dataset, test=dataset.test[::LPIPS_EVERY])
        result["lpips_vgg"] = evaluate(scene, some, lpips=lpips)["lpips_vgg"]
    return result


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    started = time.perf_counter()
    done = work()
    return done, round(time.perf_counter() - started, 3)


def lod_figures(coded: QuantizedScene, cameras: list[Camera], dataset: Dataset) -> dict:
    """Return the bytes with more LOD levels, and the PSNR of the first levels."""
    sizes = {}
    for count in range(2, LAYERS + 1):
        coded = with_lod_levels(coded, count, cameras)
        sizes[str(count)] = len(pack(coded))
    beginnings = []
    for rows in coded.lod_slices():
        scene = coded.select(slice(rows.stop)).decode()
        beginnings.append({"gaussians": rows.stop, "psnr": evaluate(scene, dataset)["psnr"]})
    return {"bytes": sizes, "beginnings": beginnings}


def cell(name: str, stage: Student, dataset: Dataset, lpips: LpipsSuite | None) -> dict:
    """Train a variant to its end and measure it."""
    trained(stage, dataset, stage.steps)
    if name == "plain":
        return figures(stage.scene(), dataset, lpips)
    coded = stage.quantized_scene()
    data, encode = timed(lambda: pack(coded))
    scene, decode = timed(lambda: unpack(data).decode())
    report = inspect(data)
    streams = {"header": report["header_bytes"] + report["padding_bytes"]}
    for row in report["streams"]:
        part = row["name"].split(".")[0]
        streams[part] = streams.get(part, 0) + row["bytes"]
    times = {"encode_seconds": encode, "decode_seconds": decode}
    made = {"bytes": len(data), "streams": streams, **times}
    if report["mode"] == "sq":
        made["steps"] = report["step_sizes"]
    if name in LAYERED:
        made["layers"] = lod_figures(coded, stage.cameras, dataset)
    return made | figures(scene, dataset, lpips)


def beginning(
    name: str,
    canonical: bool,
    config: StudentConfig,
    dataset: Dataset,
    teacher: Scene,
    options: argparse.Namespace,
) -> dict:
    """Return the state of the student that the variants share."""
    path = options.runs / "compression" / f"{name}-{options.steps}-{canonical:d}.pt"
    if path.exists():
        return torch.load(path)
    student = student_of((CANONICAL,) if canonical else (), config, dataset, teacher)
    trained(student, dataset, math.floor(config.schedule.quantize_from * config.steps))
    path.parent.mkdir(parents=True, exist_ok=True)
    torch.save(student.state(), path)
    return student.state()


def ours(
    name: str, options: argparse.Namespace, cells: dict, save: Callable[[], None]
) -> tuple[Dataset, Scene, LpipsSuite | None]:
    """Make the missing variants of a scene."""
    dataset, teacher, config = capture_of(name, options)
    weights = options.data / "lpips"
    lpips = lpips_from(str(weights)) if weights.exists() else None
    begun: dict[bool, dict] = {}  # by whether rotations are canonical
    for variant in options.variants:
        key = f"{name}/{options.steps}/{variant}"
        if key in cells:
            continue
        settings = VARIANTS[variant]
        stage = student_of(settings, config, dataset, teacher)
        uniform = stage.config.quantization.method == "sq"
        canonical = stage.config.ablation.canonical_rotations or uniform
        shared_until = config.schedule.quantize_from
        if not uniform or stage.config.schedule.rate_from >= shared_until:
            if canonical not in begun:
                begun[canonical] = beginning(name, canonical, config, dataset, teacher, options)
            stage.restore(begun[canonical])
        cells[key] = cell(variant, stage, dataset, lpips)
        save()
        print(key, json.dumps(cells[key]), flush=True)
    return dataset, teacher, lpips


def peers(name: str, options: argparse.Namespace, cells: dict, world: tuple) -> None:
    """Measure the missing other formats of the teacher."""
    if all(f"{name}/{peer}" in cells for peer in PEERS):
        return
    dataset, teacher, lpips = world
    # of a scene without photos the pictures are its own
    count = {"gaussians": len(teacher.gaussians)}
    cells[f"{name}/teacher"] = count if name in SPLATS else figures(teacher, dataset, lpips)
    cells[f"{name}/teacher"]["seed"] = options.teacher_seed
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "teacher.ply"
        write_ply(source, teacher.gaussians)
        cells[f"{name}/teacher"]["bytes"] = source.stat().st_size
        for peer, (suffix, *more) in PEERS.items():
            if f"{name}/{peer}" in cells:
                continue
            there, back = Path(folder) / f"there{suffix}", Path(folder) / f"{peer}.ply"
            times = []
            for command in ([str(source), str(there)], [str(there), str(back)]):
                program = [str(options.peers), "-q", "-w", *more, *command]
                _, seconds = timed(lambda program=program: subprocess.run(program, check=True))
                times.append(seconds)
            # what is fully opaque in a .spz has no finite logit in a .ply
            found = turned(read_spz(there)) if suffix == ".spz" else read_ply(back)
            scene = replace(teacher, gaussians=found)
            cells[f"{name}/{peer}"] = {
                "bytes": there.stat().st_size,
                "encode_seconds": times[0],
                "decode_seconds": times[1],
                **figures(scene, dataset, lpips),
            }
            print(f"{name}/{peer}", json.dumps(cells[f"{name}/{peer}"]), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("MOBILEGS_DATA"))
    parser.add_argument("--runs", type=Path, default=Path("runs/paper"))
    parser.add_argument("--json", type=Path, default=Path("compression.json"))
    parser.add_argument("--scenes", nargs="+", choices=[*SCENES, *SPLATS], default=[*SCENES])
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=[*VARIANTS])
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--teacher-seed", type=int, default=0)
    parser.add_argument("--peers", type=Path, help="the program splat-transform")
    options = parser.parse_args()
    if not options.data:
        sys.exit("set MOBILEGS_DATA to the folder that holds the captures")
    result: dict = {"cells": {}}
    if options.json.exists():
        result = json.loads(options.json.read_text())

    def save() -> None:
        result["date"] = time.strftime("%Y-%m-%d")
        result["machine"] = f"{platform.machine()}, {os.cpu_count()} cores, {kernel_level()}"
        ordered = {**result, "cells": dict(sorted(result["cells"].items()))}
        options.json.write_text(json.dumps(ordered, indent=1) + "\n")

    for name in options.scenes:
        world = ours(name, options, result["cells"], save)
        if options.peers:
            peers(name, options, result["cells"], world)
        save()


if __name__ == "__main__":
    main()
