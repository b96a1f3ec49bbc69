"""A budget of time: what a plan chooses, and the pace that keeps to it."""

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.pipeline import train
from mobilegs.pipeline.options import TrainRun, budget_of
from mobilegs.pipeline.train import train_capture
from mobilegs.train import budget, memory
from mobilegs.train.budget import Correction, Pace, Plan, Planned, Speed, make_plan
from mobilegs.train.distributed import SINGLE_PROCESS
from mobilegs.train.recipes import (
    LONG_RATES,
    long_recipe,
    rates_for,
    short_recipe,
    with_method,
    with_steps,
)
from mobilegs.train.teacher.trainer import TeacherLearningRates
from tests.support.runs import RECIPE

SPEED = Speed(per_splat=2e-7, per_pixel=1e-7)  # about two cores


@dataclass
class Clocked:
    """A stage that only counts its steps."""

    steps: int
    name: str = "teacher"
    done: int = 0

    def set_steps(self, steps: int, at: int) -> None:
        assert steps > self.done >= at
        self.steps = steps


def run(stage, pace: Pace, speeds, elapsed: float = 0.0) -> float:
    """Take all steps, each of which lasts `speeds(step)` seconds; return the time."""
    pace.before(stage)
    while stage.done < stage.steps:
        stage.done += 1
        elapsed += speeds(stage.done)
        pace.after_step(stage, elapsed, SINGLE_PROCESS)
    return elapsed


@pytest.mark.parametrize(
    "speeds",
    [
        lambda step: 0.1,
        lambda step: 0.2,
        lambda step: 0.05,
        lambda step: 0.06 + 0.08 * min(1.0, step / 2500),  # as Gaussians are added
        lambda step: 0.1 if step < 3000 else 0.18,  # another program begins
        lambda step: 1.0,
    ],
    ids=["as planned", "half as fast", "twice as fast", "slowing", "busy later", "a tenth as fast"],
)
def test_the_pace_keeps_to_the_time_within_a_tenth(speeds) -> None:
    plan = Plan(minutes=20.0, seconds=1000.0, teacher_share=0.5)
    teacher = Clocked(5000)
    pace = Pace(plan, lambda plan: None)
    spent = run(teacher, pace, speeds)
    assert 400 < spent < 650
    student = Clocked(5000, "student")
    assert 900 < run(student, pace, speeds, spent) < 1100


def test_a_run_that_was_killed_makes_its_last_change_before_new_ones() -> None:
    made = (Correction("teacher", 300, 400),)
    plan = Plan(minutes=1.0, seconds=100.0, teacher_share=1.0, corrections=made)
    stage, plans = Clocked(1000, done=100), []
    run(stage, Pace(plan, plans.append), lambda step: 0.5)
    assert [c.at for c in plans[0].corrections] == sorted(c.at for c in plans[0].corrections)
    assert plans[0].corrections[0] == made[0]


def test_a_stage_without_time_left_ends_soon() -> None:
    plan = Plan(minutes=1.0, seconds=100.0, teacher_share=0.5)
    student = Clocked(1000, "student")
    run(student, Pace(plan, lambda plan: None), lambda step: 0.1, 100.0)
    assert student.done < 60


def test_a_repeated_plan_changes_the_steps_at_the_same_places_at_any_speed() -> None:
    plans: list[Plan] = []
    plan = Plan(minutes=20.0, seconds=1000.0)
    first = Clocked(5000)
    run(first, Pace(plan, plans.append), lambda step: 0.3)
    assert plans and plans[-1].corrections
    again, made = Clocked(5000), []
    run(again, Pace(replace(plans[-1], final=True), made.append), lambda step: 0.001)
    assert again.steps == first.steps != 5000 and not made
    resumed = Clocked(5000, done=first.steps - 1)  # a checkpoint behind all changes
    Pace(plans[-1], made.append).before(resumed)
    assert resumed.steps == first.steps


def test_a_plan_survives_json_and_a_damaged_one_is_refused() -> None:
    plan = Plan(5.0, 290.0, 0.4, (Correction("teacher", 10, 20),), True, 4 << 30, 5 << 30)
    assert Plan.from_json(json.loads(json.dumps(plan.as_json()))) == plan
    for damage in ({"corrections": [["teacher", 10]]}, {"minutes": "long"}, {"seconds": None}):
        with pytest.raises(InputError, match="plan is damaged"):
            Plan.from_json({**plan.as_json(), **damage})


def planned(dataset: Dataset, minutes: int, monkeypatch, **options) -> Planned:
    monkeypatch.setattr(budget, "measured_speed", lambda *of: SPEED)
    if budget.free_memory is memory.free_memory:
        monkeypatch.setattr(budget, "free_memory", lambda: 1 << 40)
    monkeypatch.setattr(budget.time, "monotonic", lambda: 0.0)

    def load(n: int | None) -> Dataset:
        frames = [
            replace(f, camera=f.camera.resized(1600 // (n or 1), 1200 // (n or 1)))
            for f in dataset.train
        ]
        return replace(dataset, train=frames)

    usual = {"downscale": None, "max_splats": None, "given": 0}
    more = {"team": SINGLE_PROCESS, "started": 0.0}
    given = {**usual, **options}
    recipe = given.pop("recipe", short_recipe())
    return make_plan(recipe, float(minutes), load, **given, **more)


def test_a_small_file_has_fewer_gaussians(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    most = planned(dataset, 120, monkeypatch).recipe.teacher.max_splats
    monkeypatch.setattr(budget, "FILE_BYTES_PER_SPLAT", 10.0)
    recipe = short_recipe()
    quantization = replace(recipe.student.quantization, target_mb=1.5)
    small = replace(recipe, student=replace(recipe.student, quantization=quantization))
    plan = planned(dataset, 120, monkeypatch, recipe=small)
    assert plan.recipe.teacher.max_splats == 150_000 < most and plan.downscale is None


def test_more_minutes_buy_larger_photos_and_more_gaussians(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = (1, 3, 120)
    plans = [planned(dataset, minutes, monkeypatch) for minutes in times]
    splats = [plan.recipe.teacher.max_splats for plan in plans]
    divisors = [plan.downscale or 1 for plan in plans]
    assert splats == sorted(set(splats)) and divisors == sorted(divisors, reverse=True)
    assert divisors[0] > divisors[-1] == 1
    for plan, minutes in zip(plans, times, strict=True):
        assert plan.recipe.student.steps >= math.floor(budget.ENOUGH_STEPS * math.sqrt(minutes))
        assert plan.recipe.teacher.lr == rates_for(plan.recipe.teacher.steps)


def test_learning_rates_follow_the_steps_of_a_teacher_that_clones_and_splits() -> None:
    few, some, many = (rates_for(steps) for steps in (2000, 12_000, 40_000))
    assert few == short_recipe().teacher.lr and many == LONG_RATES
    assert many.scales < some.scales < few.scales and few.sh_rest > some.sh_rest > many.sh_rest
    assert with_steps(short_recipe(), 24_000).teacher.lr == some
    for recipe in (long_recipe(), with_method(short_recipe(), "mcmc")):
        assert with_steps(recipe, 24_000).teacher.lr == TeacherLearningRates()


def test_a_plan_keeps_what_a_person_gave(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(dataset, 5, monkeypatch, downscale=1, max_splats=300_000)
    assert (plan.downscale, plan.recipe.teacher.max_splats) == (1, 300_000)
    assert plan.recipe.student.steps < budget.ENOUGH_STEPS * math.sqrt(5)
    given = planned(dataset, 5, monkeypatch, given=500_000)
    assert given.downscale is None and given.plan.teacher_share == 0
    assert given.recipe.student.steps < plan.recipe.student.steps * 2


def test_a_plan_chooses_less_where_memory_is_short(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    many = replace(dataset, train=dataset.train * 30)
    free = planned(many, 120, monkeypatch)
    assert free.plan.free_memory == 0
    chosen = free.plan.needed_memory
    assert chosen > 2e9
    monkeypatch.setattr(budget, "free_memory", lambda: round(0.6 * chosen))
    short = planned(many, 120, monkeypatch)
    assert short.plan.needed_memory <= 0.8 * 0.6 * chosen
    assert short.plan.free_memory == pytest.approx(0.6 * chosen, rel=1e-6)
    assert "would not fit into" in short.plan.memory_note
    monkeypatch.setattr(budget, "free_memory", lambda: 10 << 20)
    least = planned(many, 120, monkeypatch)
    assert least.plan.needed_memory > least.plan.free_memory
    assert "0.0 GB are free" in least.plan.memory_note
    assert free.plan.memory_note == ""


def test_the_measured_speed_grows_with_gaussians_and_pixels(dataset: Dataset) -> None:
    speed = budget.measured_speed(RECIPE.teacher, dataset, SINGLE_PROCESS)
    assert speed.per_splat > 0 and speed.per_pixel > 0
    assert speed.step(10, 100) < speed.step(20, 100) < speed.step(20, 200)


def test_options_decide_whether_a_run_has_a_budget(tmp_path: Path) -> None:
    run = TrainRun(tmp_path, tmp_path / "run", device="cpu")
    assert budget_of(run) == 30
    assert budget_of(replace(run, minutes=5.0)) == 5
    assert budget_of(replace(run, minutes=5.0, preset="paper")) == 5
    for other in ({"preset": "short"}, {"steps": 9}, {"settings": (("student.steps=9",),)}):
        assert budget_of(replace(run, **other)) is None
    for wrong in ({"steps": 9}, {"settings": (("teacher.steps=9",),)}, {"recipe": tmp_path}):
        with pytest.raises(InputError, match="leave out --minutes"):
            budget_of(replace(run, minutes=5.0, **wrong))
    for minutes in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(InputError, match="--minutes takes 1 to 10,000"):
            budget_of(replace(run, minutes=minutes))


@pytest.mark.thorough
def test_a_run_with_a_budget_can_be_repeated_and_resumed(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mobilegs.pipeline.options.MINUTES", (0.01, 10_000))
    monkeypatch.setattr(budget, "STEPS_MIN", 20)
    monkeypatch.setattr(budget, "PIXELS_MIN", 16)
    settings = ("teacher.densify.min_interval=3",)
    run = TrainRun(capture, tmp_path / "a", minutes=0.1, settings=(settings,), max_splats=60)
    train_capture(run)
    config = json.loads((tmp_path / "a/config.json").read_text())
    assert config["plan"]["minutes"] == 0.1 and config["plan"]["corrections"]
    again = TrainRun(capture, tmp_path / "b", recipe=tmp_path / "a/config.json")
    changes = [steps for stage, _, steps in config["plan"]["corrections"] if stage == "student"]
    half = [config["recipe"]["student"]["steps"], *changes][-1] // 2
    taken = 0

    def advance(stage, views, original=train.Student.advance):
        nonlocal taken
        taken += 1
        if taken == half:
            raise KeyboardInterrupt
        return original(stage, views)

    with monkeypatch.context() as patched:
        patched.setattr(train.Student, "advance", advance)
        with pytest.raises(KeyboardInterrupt):
            train_capture(again)
    train_capture(replace(again, resume=True))
    for name in ("scene.mgs", "teacher.ply"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
