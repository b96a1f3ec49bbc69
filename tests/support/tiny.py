"""Tiny captures, and configurations of teacher and student for them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset, Frame, load_view
from mobilegs.data.demo.capture import write_capture
from mobilegs.gaussians import Gaussians
from mobilegs.render.scene import Scene
from mobilegs.representation.codebooks import CodebookSizes
from mobilegs.train.stage import Stage, view_order
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.init import gaussians_at
from mobilegs.train.teacher.trainer import TeacherConfig

CPU = torch.device("cpu")
TEACHER = TeacherConfig(
    steps=40,
    max_splats=60,
    init_splats=40,
    densify=DensifyConfig(min_interval=4, prune_scale=0.0),  # the points are sparse
)


def changed(config: Any, **changes: Any) -> Any:
    """Return a copy of a config with other fields; a dictionary changes fields of a group."""
    for name, value in changes.items():
        if isinstance(value, dict):
            changes[name] = changed(getattr(config, name), **value)
    return replace(config, **changes)


STUDENT: StudentConfig = changed(
    StudentConfig(),
    steps=40,
    schedule={"latents_from": 1 / 6, "quantize_from": 0.65},
    loss={"virtual_view_every": 0},  # tests of virtual views set it
    quantization={
        "method": "nvq",  # tests of `sq` set it
        "quality": 1.0,
        "codebooks": CodebookSizes(scale=8, rotation=16, appearance=16, opacity=8),
    },
)


def with_kind(kind: str) -> StudentConfig:
    return changed(STUDENT, view_dependence={"kind": kind})


def blobs() -> Gaussians:
    """Return fifty opaque coloured Gaussians around the origin."""
    generator = torch.Generator().manual_seed(5)
    points = torch.randn(50, 3, generator=generator) * 0.5
    made = gaussians_at(points, torch.rand(50, 3, generator=generator), opacity=0.8, sh_degree=1)
    made.log_scales -= 0.7
    made.sh[:, 1:] = 0.2 * torch.randn(50, 3, 3, generator=generator)
    return made


def cameras() -> list[Camera]:
    K = torch.tensor([[28.0, 0, 12], [0, 28, 12], [0, 0, 1]])
    eyes = torch.randn(7, 3, generator=torch.Generator().manual_seed(6))
    up = torch.tensor([0.0, 0, 1])
    return [Camera(look_at(3 * eye / eye.norm(), torch.zeros(3), up), K, 24, 24) for eye in eyes]


def photographed(
    truth: Scene, cameras: list[Camera], names: str, *, points: torch.Tensor, colors: torch.Tensor
) -> Dataset:
    """Return photos of a scene, the first one held back; `names` has a place for a number."""
    frames = [
        Frame(
            names.format(index),
            camera,
            pixels=(truth.render(camera).image.clamp(0, 1) * 255).round().to(torch.uint8),
        )
        for index, camera in enumerate(cameras)
    ]
    return Dataset(
        name="blobs",
        train=frames[1:],
        test=frames[:1],
        points=points,
        colors=colors,
        extent=3.0,
        center=torch.zeros(3),
        background=torch.zeros(3),
        near=0.2,
    )


@pytest.fixture(scope="session")
def dataset() -> Dataset:
    """Seven photos, 24 x 24, of the blobs; their means with noise are the points."""
    noise = 0.05 * torch.randn(50, 3, generator=torch.Generator().manual_seed(7))
    truth = Scene(blobs())
    points, colors = truth.gaussians.means + noise, torch.full((50, 3), 0.5)
    return photographed(truth, cameras(), "{}.png", points=points, colors=colors)


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine photos, 24 x 20, of fifty blobs, as COLMAP would leave them."""
    generator = torch.Generator().manual_seed(5)
    points = torch.randn(50, 3, generator=generator) * 0.5
    colors = torch.rand(50, 3, generator=generator)
    truth = Scene(gaussians_at(points, colors, opacity=0.8, sh_degree=0))
    K = torch.tensor([[28.0, 0, 12], [0, 28, 10], [0, 0, 1]])
    eyes = [torch.randn(3, generator=generator) for _ in range(9)]
    up = torch.tensor([0.0, 0, 1])
    cameras = [Camera(look_at(3 * e / e.norm(), torch.zeros(3), up), K, 24, 20) for e in eyes]
    folder = tmp_path_factory.mktemp("capture") / "blobs"
    dataset = photographed(truth, cameras, "view_{}.png", points=points, colors=colors)
    write_capture(folder, dataset)
    return folder


@pytest.fixture(scope="session")
def make_student(dataset: Dataset) -> Callable[..., Student]:
    def make(config: StudentConfig = STUDENT, seed: int = 0) -> Student:
        cameras_of_photos = [frame.camera for frame in dataset.train]
        teacher = Scene(blobs(), near=0.2)
        return Student(config, teacher, cameras_of_photos, extent=dataset.extent, seed=seed)

    return make


def train(stage: Stage, dataset: Dataset, until: int) -> list[float]:
    """Train up to step `until`; return the losses."""
    losses = []
    while stage.done < until:
        number = stage.views_per_step
        order = view_order(len(dataset.train), stage.done * number, number, seed=3)
        views = [(index, load_view(dataset.train[index])) for index in order]
        losses.append(float(stage.advance(views).loss))
    return losses


def grad_of(tensor: torch.Tensor) -> torch.Tensor:
    """Return the gradient of a leaf, which must have one."""
    assert tensor.grad is not None
    return tensor.grad
