"""Numbers of threads: those of torch and of the kernels, and results that depend on neither."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
import torch

from mobilegs.data.dataset import Dataset
from mobilegs.render.scene import Scene
from mobilegs.train.recipes import short_recipe
from mobilegs.train.stage import Stage
from mobilegs.train.state_file import digest
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.threads import all_threads, torch_on_one_thread
from tests.support.selection import few
from tests.support.tiny import CPU, STUDENT, changed, train

CORES = 4
SAME_AND_OTHERS = ((3, 3, 3), (3, 1, 2))  # threads of the steps in turn


@pytest.fixture(autouse=True)
def four_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(CORES)
    yield
    torch.set_num_threads(before)


def test_kernels_keep_the_threads_that_torch_gives_up() -> None:
    found = []
    with torch_on_one_thread():
        found.append(torch.get_num_threads())
        with torch_on_one_thread(), all_threads():  # of a stage's timing, in a plan
            found.append(torch.get_num_threads())
        found.append(torch.get_num_threads())
    with torch_on_one_thread(wanted=False), all_threads():
        found.append(torch.get_num_threads())
    assert [*found, torch.get_num_threads()] == [1, CORES, 1, CORES, CORES]


@pytest.fixture(scope="module")
def many_points(dataset: Dataset) -> Dataset:
    """The tiny capture with 40,000 points: torch divides 32,768 elements among its threads."""
    points = 0.5 * torch.randn(40_000, 3, generator=torch.Generator().manual_seed(2))
    return replace(dataset, points=points, colors=torch.full_like(points, 0.5))


def teachers(dataset: Dataset, strategy: str) -> Iterator[Teacher]:
    """Train two teachers of 8 steps, with other numbers of threads from step to step."""
    config = changed(
        short_recipe().teacher,
        steps=8,
        init_splats=40_000,
        max_splats=50_000,
        far_splats=0,
        densify={"strategy": strategy, "min_interval": 2},
    )
    for numbers in SAME_AND_OTHERS:
        torch.set_num_threads(numbers[0])
        teacher = Teacher(config, dataset, seed=0, device=CPU)
        run(teacher, dataset, numbers)
        assert teacher.count > 33_000 or strategy == "mini_splatting"  # it samples
        yield teacher


@pytest.mark.parametrize(
    "strategy", few(["clone_split", "mini_splatting", "mcmc"], "mini_splatting")
)
def test_a_teacher_is_the_same_whatever_the_threads_of_its_steps(strategy, many_points) -> None:
    first, other = (digest(teacher.state()) for teacher in teachers(many_points, strategy))
    assert first == other


@pytest.mark.thorough
def test_a_student_is_the_same_whatever_the_threads_of_its_steps(many_points) -> None:
    recipe = changed(short_recipe(), student={"steps": 12})
    scene = Scene(next(teachers(many_points, "clone_split")).gaussians(), near=many_points.near)
    cameras = [frame.camera for frame in many_points.train]
    digests = []
    for numbers in SAME_AND_OTHERS:
        torch.set_num_threads(numbers[0])
        student = Student(recipe.student, scene, cameras, extent=many_points.extent, seed=0)
        run(student, many_points, numbers)
        digests.append((digest(student.state()), student.model.weighting))
    assert digests[0] == digests[1]


def run(stage: Stage, dataset: Dataset, numbers: tuple[int, ...]) -> None:
    """Take all steps, with the numbers of threads in turn."""
    assert stage.runs_kernels
    for step in range(stage.steps):
        torch.set_num_threads(numbers[step % len(numbers)])
        with torch_on_one_thread():
            train(stage, dataset, step + 1)


@pytest.mark.parametrize(
    "changes",
    [
        {"quantization": {"method": "nvq"}},
        {"color": {"decoder": "networks"}},
        {"view_dependence": {"kind": "network"}},
    ],
)
def test_students_of_other_kinds_keep_the_threads_of_torch(changes, make_student) -> None:
    plain = changed(STUDENT, quantization={"method": "sq"})
    assert make_student(plain).runs_kernels
    assert not make_student(changed(plain, **changes)).runs_kernels
