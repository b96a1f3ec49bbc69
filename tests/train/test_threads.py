"""Numbers of threads: what other programs leave, and results that do not depend on them."""

import time
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import psutil
import pytest
import torch

from mobilegs.data.dataset import Dataset
from mobilegs.render.scene import Scene
from mobilegs.train import threads
from mobilegs.train.recipes import short_recipe
from mobilegs.train.stage import Stage
from mobilegs.train.state_file import digest
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.threads import FairThreads
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


class Machine:
    """Four cores, on which this process and others have used times."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.own, self.others, self.steal = 100.0, 0.0, 0.0, 0.0
        monkeypatch.setattr(threads.time, "monotonic", lambda: self.now)
        monkeypatch.setattr(threads.psutil, "cpu_times", self.cpu_times)
        process = SimpleNamespace(
            cpu_times=lambda: SimpleNamespace(user=self.own, system=0.0),
            cpu_affinity=lambda: list(range(CORES)),
        )
        monkeypatch.setattr(threads.psutil, "Process", lambda: process)

    def cpu_times(self, percpu: bool) -> list[SimpleNamespace]:
        assert percpu
        idle = CORES * self.now - self.own - self.others - self.steal
        each = {"idle": idle / CORES, "iowait": 0.0, "steal": self.steal / CORES}
        elsewhere = SimpleNamespace(idle=self.now)  # a core that this process may not use
        return [SimpleNamespace(**each) for _ in range(CORES)] + [elsewhere]

    def run(self, seconds: float, *, own: float, others: float, steal: float = 0.0) -> None:
        """Let time pass, with numbers of cores in use."""
        self.now += seconds
        self.own += own * seconds
        self.others += others * seconds
        self.steal += steal * seconds


@pytest.mark.parametrize(
    ("own", "others", "steal", "expected"),
    [
        (0.5, 0.0, 0.0, 4),  # idle cores are free
        (3.6, 0.4, 0.0, 4),
        (0.3, 3.7, 0.0, 1),
        (3.0, 0.0, 1.0, 4),  # fewer threads would not help against other virtual machines
    ],
)
def test_threads_are_the_cores_that_others_leave(own, others, steal, expected, monkeypatch) -> None:
    machine = Machine(monkeypatch)
    with FairThreads() as fair:
        machine.run(2.0, own=own, others=others, steal=steal)
        fair.adapt()
        assert torch.get_num_threads() == expected


def test_threads_follow_what_others_do_and_end_as_they_began(monkeypatch) -> None:
    machine = Machine(monkeypatch)
    with FairThreads() as fair:
        for others, expected in ((0.0, 4), (2.0, 2), (3.0, 1), (0.0, 4), (1.0, 3)):
            machine.run(1.5, own=4.0 - others, others=others)
            fair.adapt()
            assert torch.get_num_threads() == expected
        machine.run(0.9, own=1.0, others=3.0)
        fair.adapt()
        assert torch.get_num_threads() == 3  # it is too early
        machine.run(0.2, own=1.0, others=3.0)
        fair.adapt()
        assert torch.get_num_threads() == 1
    assert torch.get_num_threads() == CORES


def test_times_of_this_machine_are_read() -> None:
    with FairThreads() as fair:
        before, started = fair._core_seconds(), time.monotonic()
        while time.monotonic() < started + 0.5:
            pass
        passed = time.monotonic() - started
        cores = psutil.cpu_count() or 1
        assert 0.05 < fair._core_seconds() - before < (cores + 0.5) * passed + 0.5


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
        digests.append(digest(student.state()))
    assert digests[0] == digests[1]


def run(stage: Stage, dataset: Dataset, numbers: tuple[int, ...]) -> None:
    """Take all steps, with the numbers of threads in turn."""
    assert stage.any_threads
    with FairThreads():
        for step in range(stage.steps):
            torch.set_num_threads(numbers[step % len(numbers)])
            train(stage, dataset, step + 1)


@pytest.mark.parametrize(
    "changes",
    [
        {"quantization": {"method": "nvq"}},
        {"color": {"decoder": "networks"}},
        {"view_dependence": {"kind": "network"}},
    ],
)
def test_networks_and_codebooks_keep_their_threads(changes, make_student) -> None:
    plain = changed(STUDENT, quantization={"method": "sq"})
    assert make_student(plain).any_threads
    assert not make_student(changed(plain, **changes)).any_threads
