"""A tiny capture, and what learns from it.

A test file takes the fixtures with `pytest_plugins = ["tiny"]`, and imports what else it needs:
PYTEST_DONT_REWRITE, since that import comes first.
"""

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch

from mobilegs.camera import Camera, look_at
from mobilegs.compress.codebooks import CodebookSizes
from mobilegs.data.dataset import Dataset, Frame, load_view
from mobilegs.gaussians import Gaussians
from mobilegs.render import Rendered
from mobilegs.render.scene import Scene
from mobilegs.train.stage import Stage, view_order
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.shared_decode import Seen
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
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
STUDENT = StudentConfig(
    steps=40,
    net_fraction=1 / 6,
    codes_fraction=0.65,
    regression_steps=5,
    coding="nvq",  # tests of `sq` say so
    distill_between=0,  # as do tests of that
    fineness=1.0,
    codebooks=CodebookSizes(scale=8, rotation=16, appearance=16, opacity=8),
)


def with_kind(kind: str) -> StudentConfig:
    return replace(STUDENT, view=ViewDependence(kind=kind, size=16, fraction=0.3))


def blobs() -> Gaussians:
    """Fifty opaque coloured blobs around the origin."""
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


@pytest.fixture(scope="session")
def dataset() -> Dataset:
    """Seven photos, 24 x 24, of the blobs; their centres, moved a little, are the points."""
    truth = Scene(blobs())
    frames = [
        Frame(
            f"{index}.png",
            camera,
            pixels=(truth.render(camera).image.clamp(0, 1) * 255).round().to(torch.uint8),
        )
        for index, camera in enumerate(cameras())
    ]
    noise = torch.randn(50, 3, generator=torch.Generator().manual_seed(7))
    return Dataset(
        name="blobs",
        train=frames[1:],
        test=frames[:1],
        points=truth.gaussians.means + 0.05 * noise,
        colors=torch.full((50, 3), 0.5),
        extent=3.0,
        center=torch.zeros(3),
        background=torch.zeros(3),
        near=0.2,
    )


@pytest.fixture
def make_student(dataset: Dataset) -> Callable[..., Student]:
    def make(config: StudentConfig = STUDENT, seed: int = 0) -> Student:
        seen_by = [frame.camera for frame in dataset.train]
        teacher = Scene(blobs(), near=0.2)
        return Student(config, teacher, seen_by, extent=dataset.extent, seed=seed)

    return make


def train(stage: Stage, dataset: Dataset, until: int) -> list[float]:
    """Steps up to number `until`; their losses."""
    losses = []
    while stage.done < until:
        number = stage.views_per_step
        order = view_order(len(dataset.train), stage.done * number, number, seed=3)
        views = [(index, load_view(dataset.train[index])) for index in order]
        losses.append(float(stage.advance(views).loss))
    return losses


def draw(student: Student, *, depth: bool = False) -> Rendered:
    """What training draws for the first camera."""
    seen = Seen(student.model, cameras()[:1])
    return seen.draw(0, background=student.background, depth=depth)
