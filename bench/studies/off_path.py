"""Compare students with their teacher beside the path of the photos, on bonsai.

    python -m bench.studies.off_path [--json OUT] [--teacher PLY] [--pictures FOLDER] [--steps 5000]

Students with and without virtual views beside the path learn from one teacher of the preset cpu at
400x267. Each is compared with the teacher's images on the photos' views, between them, and from
cameras moved towards the centre of the scene by 0.35 of the distance, away from it by 0.3, and up
and down by 0.25 and 0.2 extents. Bonsai comes from MOBILEGS_DATA; a teacher is trained unless
--teacher exists.
"""

import argparse
import json
import os
import platform
import sys
import time
from dataclasses import replace
from pathlib import Path

import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.csrc.binding import kernel_level
from mobilegs.data import Dataset, load_capture, load_view
from mobilegs.evaluate.metrics import as_displayed, psnr, to_bytes
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.mgs.codec import pack
from mobilegs.render.scene import Scene
from mobilegs.train.recipes import Recipe, cpu_recipe, with_settings
from mobilegs.train.stage import Stage, view_order
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher

SHARES = (0.0, 0.5)
EVERY = 8  # of the training cameras, that are compared
KINDS = ("photos", "between", "nearer", "farther", "higher", "lower")


def moved(camera: Camera, kind: str, dataset: Dataset, up: torch.Tensor) -> Camera:
    """Return a training camera moved beside the path."""
    eye = camera.position
    inwards = dataset.center - eye
    if kind == "between":
        eyes = torch.stack([frame.camera.position for frame in dataset.train])
        near = int((eyes - eye).norm(dim=1).argsort(stable=True)[3])
        return camera.interpolate(dataset.train[near].camera, 0.5)
    shift = {
        "photos": 0 * inwards,
        "nearer": 0.35 * inwards,
        "farther": -0.3 * inwards,
        "higher": 0.25 * dataset.extent * up,
        "lower": -0.2 * dataset.extent * up,
    }[kind]
    viewmat = camera.viewmat.clone()
    viewmat[:3, 3] = -viewmat[:3, :3] @ (eye + shift)
    return replace(camera, viewmat=viewmat)


def run(stage: Stage, dataset: Dataset, seed: int) -> None:
    views = [load_view(frame) for frame in dataset.train]
    while stage.done < stage.steps:
        [index] = view_order(len(views), stage.done, 1, seed)
        stage.advance([(index, views[index])])


def teacher_scene(path: Path, recipe: Recipe, dataset: Dataset) -> Scene:
    if not path.exists():
        stage = Teacher(recipe.teacher, dataset, seed=0, device=torch.device("cpu"))
        run(stage, dataset, 0)
        write_ply(path, stage.gaussians(), footprint=recipe.teacher.footprint)
    gaussians, footprint = read_ply_scene(path)
    return Scene(gaussians, background=dataset.background, near=dataset.near, footprint=footprint)


@torch.inference_mode()
def compare(scene: Scene, teacher: Scene, dataset: Dataset, sheet: Path | None) -> dict:
    """Return mean and least PSNR to the teacher's images by kind of view, and to the photos."""
    cameras = [frame.camera for frame in dataset.train]
    up = -torch.stack([camera.viewmat[1, :3] for camera in cameras]).mean(0)
    up = up / up.norm()
    found, rows = {}, []
    for kind in KINDS:
        values = []
        for number, camera in enumerate(cameras[EVERY // 2 :: EVERY]):
            there = moved(camera, kind, dataset, up)
            one, other = (as_displayed(each.render(there).image) for each in (teacher, scene))
            values.append(psnr(other, one))
            if number == 15:
                rows.append(torch.cat([one, other, ((other - one) * 3 + 0.5).clamp(0, 1)], dim=1))
        found[kind] = {"mean": sum(values) / len(values), "least": min(values)}
    if sheet is not None:
        Image.fromarray(to_bytes(torch.cat(rows)).numpy()).save(sheet)
    held_back = [load_view(frame) for frame in dataset.test]
    values = [psnr(as_displayed(scene.render(v.camera).image), v.image) for v in held_back]
    return {"held_back": sum(values) / len(values), "to_teacher": found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--teacher", type=Path, default=Path("off_path_teacher.ply"))
    parser.add_argument("--pictures", type=Path, help="write a sheet of each student here")
    parser.add_argument("--steps", type=int, default=5000)
    options = parser.parse_args()
    if not os.environ.get("MOBILEGS_DATA"):
        sys.exit("set MOBILEGS_DATA to the folder that holds bonsai")
    dataset = load_capture(Path(os.environ["MOBILEGS_DATA"]) / "bonsai", downscale=2)
    recipe = with_settings(cpu_recipe(), [f"student.steps={options.steps}"])
    teacher = teacher_scene(options.teacher, recipe, dataset)
    result = {
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, kernels {kernel_level()}",
        "size": [dataset.train[0].camera.width, dataset.train[0].camera.height],
        "steps": options.steps,
        "teacher_gaussians": len(teacher.gaussians),
        "students": {},
    }
    for share in SHARES:
        config = with_settings(recipe, [f"student.loss.virtual_view_beside={share}"]).student
        cameras = [frame.camera for frame in dataset.train]
        student = Student(config, teacher, cameras, extent=dataset.extent, seed=0)
        run(student, dataset, 1)
        coded = student.quantized_scene()
        sheet = None
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            sheet = options.pictures / f"beside_{share:g}.png"
        found = compare(coded.decode("cpu"), teacher, dataset, sheet)
        found |= {"bytes": len(pack(coded)), "gaussians": len(coded)}
        result["students"][f"{share:g}"] = found
        print(share, json.dumps(found), flush=True)
        if options.json:
            options.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
