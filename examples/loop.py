"""Train by hand: a teacher, steps of your own, a student, and its file.

    python examples/loop.py my_capture scene.mgs --downscale 4 --steps 500

`Teacher` and `Student` take a step at a time. Between them, the teacher's Gaussians take steps with
a loss and an optimiser of PyTorch, as any other tensors.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import torch

from mobilegs import (
    Dataset,
    Scene,
    Student,
    StudentConfig,
    Teacher,
    TeacherConfig,
    View,
    encode_mgs,
    evaluate_side_by_side,
    load_capture,
    load_view,
    photo_loss,
)


def photos(dataset: Dataset, steps: int) -> Iterator[tuple[int, View]]:
    """Yield a training photo with its index for every step, in random order."""
    generator = torch.Generator().manual_seed(0)
    for _ in range(steps):
        index = int(torch.randint(len(dataset.train), (1,), generator=generator))
        yield index, load_view(dataset.train[index])


def refine_colors(scene: Scene, dataset: Dataset, steps: int) -> None:
    """Train the constant part of the colours with the loss of 3DGS."""
    gaussians = scene.gaussians
    gaussians.sh.requires_grad_()
    optimizer = torch.optim.Adam([gaussians.sh], lr=1e-3)
    for _, view in photos(dataset, steps):
        image = scene.render(view.camera).image  # [h, w, 3]
        loss = photo_loss(image, view.image, mask=view.mask)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    gaussians.sh.requires_grad_(False)


def main() -> None:
    options = argparse.ArgumentParser(description="Train a capture in a loop of your own.")
    options.add_argument("capture", type=Path)
    options.add_argument("output", type=Path)
    options.add_argument("--downscale", type=int)
    options.add_argument("--steps", type=int, default=500, help="of teacher and student each")
    given = options.parse_args()

    dataset = load_capture(given.capture, downscale=given.downscale)
    config = TeacherConfig(steps=given.steps, max_splats=20_000, init_splats=10_000)
    teacher = Teacher(config, dataset, seed=0, device=torch.device("cpu"))
    for photo in photos(dataset, given.steps):
        result = teacher.advance([photo])
        if teacher.done % max(1, given.steps // 5) == 0:
            count = f"{teacher.count:,} Gaussians"
            print(f"teacher, step {teacher.done}: loss {result.loss:.3f}, {count}")
    scene = teacher.scene()
    refine_colors(scene, dataset, given.steps // 10)

    cameras = [frame.camera for frame in dataset.train]
    student = Student(
        replace(StudentConfig(), steps=given.steps),
        scene,
        cameras,
        extent=dataset.extent,
        seed=0,
    )
    for photo in photos(dataset, given.steps):
        student.advance([photo])
    quantized = student.quantized_scene(views=cameras[:4])
    given.output.write_bytes(encode_mgs(quantized))

    scenes = {"teacher": scene, "student": quantized.decode()}
    for name, metrics in evaluate_side_by_side(scenes, dataset).items():
        print(f"{name}: {metrics['psnr']:.2f} dB on held-back photos")
    print(f"{given.output}: {given.output.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
