"""Students with the weighting `exponential`, the paper's Eq. 1 as printed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from bench.paper.rows import ROWS
from bench.paper.run import float_bytes
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.pipeline.train import TrainRun, resolve_recipe
from mobilegs.render import Weighting
from mobilegs.train.recipes import Recipe, with_settings
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig
from tests.support.tiny import STUDENT, cameras, changed, render_student, train

EXPLICIT = {"latents_from": 1.0, "quantize_from": 1.0}
EQUATION_1: StudentConfig = changed(
    STUDENT,
    schedule=EXPLICIT,
    weighting=Weighting("exponential", sigma=2.0, background_weight=0.5),
    view_dependence=ViewDependence("free", decoder_from=1.0),
    pruning={"votes": VoteConfig(quantile=0.0)},
)
PRUNED = changed(EQUATION_1, pruning={"votes": VoteConfig(quantile=0.6, interval=0.25)})
MakeStudent = Callable[..., Student]


@pytest.mark.parametrize("kind", ["free", "network", "constant"])
def test_sigma_beta_and_background_weight_learn(
    kind: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    config = replace(EQUATION_1, view_dependence=ViewDependence(kind, decoder_from=1.0))
    student = make_student(config)
    start = student.model.attenuation
    assert start is not None
    expected = torch.tensor([1 / 6, 1.0]).log().expand(50, 2)  # 2 extents of 3
    torch.testing.assert_close(start.detach(), expected)
    losses = train(student, dataset, 40)
    assert sum(losses[-6:]) < 0.8 * sum(losses[:6])
    learned = student.model.attenuation
    assert learned is not None and learned.shape == (student.count, 2)
    assert (learned.std(0) > 0.01).all()  # each Gaussian its own
    assert abs(student.model.weighting.background_weight - 0.5) > 0.01

    scene = student.scene()
    assert scene.weighting == student.model.weighting
    rendered = scene.render(cameras()[0], level_sigma=student.model.level_sigma).image
    torch.testing.assert_close(rendered, render_student(student).image, atol=2e-5, rtol=0)
    shapes = student.count * (3 + 4 + 3 + 12 + 2)  # means to harmonics, sigma and beta
    logits = {"free": 9, "network": 1, "constant": 1}[kind] * student.count
    network = scene.network.parameters() if scene.network is not None else ()
    assert float_bytes(scene) == 4 * (shapes + logits + sum(p.numel() for p in network))
    with pytest.raises(InputError, match="file cannot hold sigma and beta"):
        student.quantized_scene()


def test_pruning_takes_their_rows_along_and_runs_resume_exactly(
    dataset: Dataset, make_student: MakeStudent
) -> None:
    whole, resumed = make_student(PRUNED), make_student(PRUNED)
    train(whole, dataset, 40)
    assert whole.count < 50
    for stop in (3, 20, 30):
        train(resumed, dataset, stop)
        before, resumed = resumed, make_student(PRUNED, seed=9)
        resumed.restore(before.state())
    train(resumed, dataset, 40)
    found, expected = resumed.model.rows.tensors, whole.model.rows.tensors
    assert found.keys() == expected.keys() and "attenuation" in found
    assert all(torch.equal(found[name], expected[name]) for name in expected)
    assert resumed.model.weighting == whole.model.weighting


def test_lr_weighting_is_their_learning_rate(dataset: Dataset, make_student: MakeStudent) -> None:
    student = make_student(changed(EQUATION_1, lr={"weighting": 0.0}))
    train(student, dataset, 3)
    model = student.model
    assert model.attenuation is not None and len(model.attenuation.unique(dim=0)) == 1
    assert model.weighting.background_weight == pytest.approx(0.5)


def test_the_row_of_the_papers_tables_is_such_a_student() -> None:
    row = ROWS["sort-free-gs-printed"]
    config = with_settings(Recipe(student=STUDENT), row.settings).student
    assert config.weighting.name == "exponential" and not row.coded


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"blend": "sorted"}, "blend=sorted has no weights"),
        ({"weighting": {"background_weight": 0.0}}, "background_weight=0.1"),
        ({"schedule": {"latents_from": 0.2}}, "schedule.latents_from=1"),
        ({"view_dependence": ViewDependence()}, "view_dependence.decoder_from=1"),
        ({"view_dependence": ViewDependence("free", decoder_from=0.5)}, "decoder_from=1"),
        ({"weighting": {"name": "exponent"}}, "unknown weighting 'exponent': .*exponential"),
    ],
)
def test_configurations_that_do_not_go_with_it_are_refused(changes: Any, word: str) -> None:
    with pytest.raises(InputError, match=word):
        changed(EQUATION_1, **changes)


def test_mobilegs_train_refuses_it_before_it_trains(tmp_path: Path) -> None:
    settings = (ROWS["sort-free-gs-printed"].settings,)
    with pytest.raises(InputError, match="cannot hold sigma and beta"):
        resolve_recipe(TrainRun(tmp_path, tmp_path / "run", preset="cpu", settings=settings))
