"""The time of a stage: even, never backwards, and at the end when the steps are."""

from itertools import pairwise

import pytest

from mobilegs.data.dataset import Dataset
from mobilegs.render.scene import Scene
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.times import Times
from tests.support.tiny import CPU, STUDENT, TEACHER, blobs, changed


def test_time_is_the_share_of_the_steps() -> None:
    times = Times(40)
    assert [times.of(step) for step in (0, 10, 40, 50)] == [0, 0.25, 1, 1]


@pytest.mark.parametrize("changes", [[(200, 50)], [(60, 50)], [(200, 50), (120, 110), (400, 119)]])
def test_a_change_neither_stops_nor_reverses_the_time(changes: list[tuple[int, int]]) -> None:
    times = Times(100)
    for steps, at in changes:
        before = [times.of(step) for step in range(at + 1)]
        times.set_steps(steps, at)
        assert times.steps == steps
        assert [times.of(step) for step in range(at + 1)] == before
    path = [times.of(step) for step in range(times.steps + 1)]
    assert path[-1] == 1
    assert all(a < b for a, b in pairwise(path))


def test_the_last_step_lies_after_the_change() -> None:
    times = Times(100)
    times.set_steps(10, 50)
    assert times.steps == 51 and times.of(51) == 1


@pytest.mark.parametrize("steps", [3, 30, 100, 30_000])
def test_intervals_end_evenly(steps: int) -> None:
    times = Times(steps)
    ends = [step for step in range(1, steps + 1) if times.passes(step, 1 / 30)]
    assert len(ends) == min(steps, 30) and ends[-1] == steps


def test_no_rate_rises_and_no_term_goes_off_again(dataset: Dataset) -> None:
    config = changed(STUDENT, quantization={"method": "sq"}, schedule={"rate_from": 0.3})
    config = changed(config, steps=100, lr={"final_factor": 0.1, "decay_from": 0.2})
    photos = [frame.camera for frame in dataset.train]
    student = Student(config, Scene(blobs(), near=0.2), photos, extent=3.0, seed=0)
    teacher_config = changed(TEACHER, steps=100, lr={"final_factor": 0.1})
    teacher = Teacher(teacher_config, dataset, seed=0, device=CPU)
    for stage in (student, teacher):
        rates, degrees, terms, phases = [], [], [], []
        for stage.done in range(300):
            if stage.done in (40, 80):
                stage.set_steps(3 * stage.steps, stage.done)
            rates.append(stage._lrs()["means"])
            phases.append(stage.phase)
            if isinstance(stage, Teacher):
                degrees.append(stage.sh_degree)
            else:
                terms.append(stage._has_rate_term)
        assert all(a >= b for a, b in pairwise(rates))
        assert rates[0] > rates[150] > rates[-1]
        assert degrees == sorted(degrees) and terms == sorted(terms)
        assert len(phases) - 1 - sum(a == b for a, b in pairwise(phases)) <= 2
