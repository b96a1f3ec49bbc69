"""Mini-Splatting: the paper's schedule and its events."""

from dataclasses import replace
from itertools import groupby
from pathlib import Path

import pytest
import torch

from mobilegs.data.dataset import Dataset, load_view
from mobilegs.render import measure_contributions
from mobilegs.spherical_harmonics import C0
from mobilegs.train.optim import exponential_lr
from mobilegs.train.recipes import RECIPES, with_method
from mobilegs.train.state_file import digest, read_state, write_state
from mobilegs.train.teacher import mini_splatting
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.init import neighbor_distances
from mobilegs.train.teacher.mini_splatting import MiniSplatting, MiniSplattingConfig, constant_color
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.selection import few
from tests.support.tiny import CPU, train

CONFIG = TeacherConfig(
    steps=60,
    max_splats=60,
    init_splats=40,
    densify=DensifyConfig("mini_splatting", min_interval=4, prune_scale=0.0),
)


def started(dataset: Dataset, config: TeacherConfig = CONFIG, **more) -> Teacher:
    if more:
        config = replace(config, mini_splatting=MiniSplattingConfig(**more))
    return Teacher(config, dataset, seed=0, device=CPU)


def strategy_of(teacher: Teacher) -> MiniSplatting:
    assert isinstance(teacher.strategy, MiniSplatting)
    return teacher.strategy


# --- the timetable at 30,000 steps


@pytest.fixture(scope="module")
def papers(dataset: Dataset) -> Teacher:
    return Teacher(RECIPES["long"]().teacher, dataset, seed=0, device=CPU)


def test_events_fall_on_the_papers_steps(papers: Teacher) -> None:
    named = sorted((strategy_of(papers).event(step), step) for step in range(1, 30_001))
    found = {e: [s for _, s in steps] for e, steps in groupby(named, lambda each: each[0])}
    assert found["densify"] == [s for s in range(600, 15_000, 100) if s % 5000]
    assert found["reinit"] == [5000, 10_000]
    assert found["sample"] == [15_000] and found["trim"] == [20_000]


def test_the_learning_rate_of_the_means_rewinds_to_step_5000(papers: Teacher) -> None:
    rates = {}
    for step in (1, 5000, 14_999, 15_000, 20_000, 30_000):
        papers.done = step - 1
        rates[step] = papers._lrs()["means"] / papers.extent
    papers.done = 0
    clocks = {1: 1, 5000: 5000, 14_999: 14_999, 15_000: 5000, 20_000: 10_000, 30_000: 20_000}
    for step, clock in clocks.items():
        assert rates[step] == pytest.approx(exponential_lr(1.6e-4, 1.6e-6, clock / 30_000))
    assert rates[15_000] == pytest.approx(rates[5000])
    assert rates[30_000] == pytest.approx(7.4e-6, rel=0.01)


@pytest.mark.parametrize("steps", [1, 2, 7, 60])
def test_short_runs_have_every_event_in_order(steps: int, dataset: Dataset) -> None:
    strategy = strategy_of(started(dataset, replace(CONFIG, steps=steps)))
    events = [strategy.event(step) for step in range(1, steps + 1)]
    assert events.count("sample") <= 1 and events.count("trim") <= 1
    if steps == 60:
        assert [e for e, _ in groupby(e for e in events if e)] == [
            *["densify", "reinit"] * 2,
            *["densify", "sample", "trim"],
        ]


# --- the events


def test_gaussians_that_dominate_much_of_an_image_are_split(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mini_splatting, "BLUR_AREA", 1 / 50)  # 11.5 of 576 pixels
    teacher = started(dataset)
    strategy = strategy_of(teacher)
    train(teacher, dataset, 2)
    seen = [
        teacher.gaussians(),
        torch.zeros(teacher.count, dtype=torch.int32),
    ]
    strategy._clear(teacher.count, CPU)
    shapes = constant_color(teacher.adam)
    for index in (0, 3):
        view = load_view(dataset.train[index])
        given = (shapes.means, shapes.quats, shapes.scales, shapes.opacities)
        seen[1] = torch.maximum(seen[1], measure_contributions(*given, camera=view.camera).largest)
        zeros = torch.zeros(teacher.count, 2)
        radii = torch.ones(teacher.count)
        strategy.observe(3, shapes, view.camera, screen_grads=zeros, radii=radii)
    assert torch.equal(strategy.blurred, seen[1] > 576 / 50)
    blurred = strategy.blurred
    assert 0 < blurred.sum() < teacher.count  # no gradient: nothing else is cloned or split
    before = constant_color(teacher.adam)
    strategy._densify(8, teacher.adam, teacher.generator, split_too=blurred)
    after = constant_color(teacher.adam)
    gone, parents = int(blurred.sum()), before.select(blurred)
    kept = before.select(~blurred)
    assert len(after) == len(before) + gone
    torch.testing.assert_close(after.means[: len(kept)], kept.means)
    torch.testing.assert_close(after.scales[len(kept) :], torch.cat([parents.scales] * 2) / 1.6)
    assert not strategy.blurred.any() and len(strategy.blurred) == len(after)


def test_a_restart_replaces_all_gaussians(dataset: Dataset) -> None:
    teacher = started(dataset)
    train(teacher, dataset, 9)
    train(teacher, dataset, 10)
    new = teacher.gaussians()
    assert 150 < len(new) <= round(3.5 * 60)
    torch.testing.assert_close(new.opacities, torch.full((len(new),), 0.1))
    assert (new.quats == torch.tensor([1.0, 0, 0, 0])).all() and (new.sh[:, 1:] == 0).all()
    torch.testing.assert_close(
        new.scales, neighbor_distances(new.means)[:, None].expand(-1, 3), rtol=1e-4, atol=1e-6
    )
    photos = torch.cat([load_view(frame).image.reshape(-1, 3) for frame in dataset.train])
    colors = 0.5 + C0 * new.sh[:, 0]
    assert torch.cdist(colors, photos).amin(1).max() < 1e-3
    assert not teacher.adam.adam.state
    strategy = strategy_of(teacher)
    assert len(strategy.gradients) == len(strategy.blurred) == len(new)


def test_the_sampling_keeps_half_of_the_important_gaussians(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = replace(CONFIG, max_splats=400)  # more than half of the peak, so it does not bind
    teacher = started(dataset, config, peak_splats=1.5, reinit_splats=1.0)
    strategy, seen = strategy_of(teacher), []
    measure = strategy._importance
    monkeypatch.setattr(
        strategy, "_importance", lambda adam: seen.append(measure(adam)) or seen[-1]
    )
    train(teacher, dataset, 29)
    before = teacher.gaussians()
    train(teacher, dataset, 30)
    after = teacher.gaussians()
    [worth] = seen
    useful = int((worth > 0).sum())
    assert len(after) == int(0.5 * useful)
    assert 60 < len(after) < 400
    distance = torch.cdist(after.means, before.means)
    nearest = distance.argmin(1)
    assert distance.amin(1).max() < 0.02 and len(nearest.unique()) == len(after)
    assert (worth[nearest] > 0).float().mean() > 0.95
    torch.testing.assert_close(after.sh[:, 0], before.sh[nearest, 0], rtol=0, atol=0.02)
    torch.testing.assert_close(after.opacities, torch.full((len(after),), 0.1))
    assert not teacher.adam.adam.state


def test_trimming_removes_the_least_important_and_resets_adam(dataset: Dataset) -> None:
    teacher = started(dataset, trim_keeps=0.8)
    train(teacher, dataset, 39)
    before = teacher.count
    train(teacher, dataset, 40)
    assert 0.3 * before < teacher.count < before and not teacher.adam.adam.state
    train(teacher, dataset, 41)
    assert teacher.adam.adam.state


@pytest.mark.parametrize("max_splats", [1, 17])
def test_max_splats_holds_after_the_sampling_and_the_peak_before(
    dataset: Dataset, max_splats: int
) -> None:
    config = replace(CONFIG, max_splats=max_splats, densify=replace(CONFIG.densify, gradient=1e-9))
    teacher = started(dataset, config)
    for step in range(1, 61):
        train(teacher, dataset, step)
        assert 0 < teacher.count <= (4.5 * max_splats + 0.5 if step < 30 else max_splats)


@pytest.mark.parametrize("method", ["3dgs", "mini-splatting", "mcmc"])
def test_a_capture_with_one_view_can_be_trained(dataset: Dataset, method) -> None:
    config = with_method(RECIPES["demo"](), method).teacher
    teacher = Teacher(
        replace(config, steps=24, max_splats=60, init_splats=40),
        replace(dataset, train=dataset.train[:1]),
        seed=0,
        device=CPU,
    )
    one_view = replace(dataset, train=dataset.train[:1])
    train(teacher, one_view, 24)
    assert teacher.count > 0 and teacher.gaussians().means.isfinite().all()


@pytest.mark.parametrize(
    ("method", "stop"),
    few(
        [("3dgs", 10), ("mcmc", 10), *(("mini-splatting", stop) for stop in (10, 30, 40))],
        ("3dgs", 10),
        ("mini-splatting", 30),
    ),
)
def test_a_resumed_teacher_ends_bit_for_bit_the_same(
    dataset: Dataset, tmp_path: Path, method, stop: int
) -> None:
    recipe = with_method(replace(RECIPES["demo"](), teacher=CONFIG), method)
    recipe = replace(recipe, teacher=replace(recipe.teacher, sh_every=4))  # stops lie between two
    whole, first, second = (
        Teacher(recipe.teacher, dataset, seed=seed, device=CPU) for seed in (0, 0, 9)
    )
    train(whole, dataset, 42)
    train(first, dataset, stop)
    write_state(tmp_path / "saved", first.state())
    second.restore(read_state(tmp_path / "saved"))
    train(second, dataset, 42)
    assert digest(whole.state()) == digest(second.state())
