"""The teacher on a tiny capture: training and resume."""

from dataclasses import replace

import pytest
import torch

from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.train.student.config import StudentConfig
from mobilegs.train.teacher import trainer
from mobilegs.train.teacher.densify import DensifyConfig
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig, TeacherLearningRates
from tests.support.tiny import CPU, TEACHER, train


def test_the_teacher_learns_and_grows_up_to_its_cap(dataset: Dataset) -> None:
    teacher = Teacher(TEACHER, dataset, seed=0, device=CPU)
    losses = train(teacher, dataset, 40)
    assert sum(losses[-6:]) < 0.8 * sum(losses[:6])
    assert 40 < teacher.count <= 60


def test_a_teacher_follows_the_sum_of_its_views_gradients(dataset: Dataset) -> None:
    apart, together = (
        Teacher(replace(TEACHER, views_per_step=3), dataset, seed=0, device=CPU) for _ in range(2)
    )
    views = [(index, load_view(dataset.train[index])) for index in (4, 0, 2)]
    losses = []
    for index, view in views:
        loss, *_ = apart._view_loss(index, view, None)
        loss.backward()
        losses.append(loss)
    expected = {name: t.grad for name, t in apart.adam.tensors.items()}
    together.adam.step = lambda **_: None
    assert together.advance(views).loss == torch.stack(losses).mean()
    for name, tensor in together.adam.tensors.items():
        grad = expected[name]
        if name == "sh_rest":  # not trained yet
            assert tensor.grad is None and grad is None
            continue
        assert tensor.grad is not None and grad is not None
        assert torch.equal(tensor.grad, grad), name
        assert (tensor.grad != 0).any()


def test_the_first_photos_are_small_and_grow_until_a_given_time(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trainer, "MIN_SIDE", 4)
    config = replace(TEACHER, steps=100, first_divisor=4)
    teacher = Teacher(config, dataset, seed=0, device=CPU)
    divisors = []
    for teacher.done in range(100):
        divisors.append(teacher.divisor)
    # four equal factors of 4 ** (1 / 40): 4 to 3, 3 to 2, 2 to 1
    expected = [4] * 9 + [3] * 11 + [2] * 20 + [1] * 60
    assert divisors == expected
    observed = []
    teacher.done = 0
    teacher.strategy.observe = lambda *seen, **more: observed.append(seen[2])
    view = load_view(dataset.train[2])
    teacher.advance([(2, view)])
    size = (view.camera.width // 4, view.camera.height // 4)
    assert (observed[0].width, observed[0].height) == size
    monkeypatch.setattr(trainer, "MIN_SIDE", 1 + min(size))
    teacher.done = 0
    assert teacher.divisor < 4


def test_learning_rates_fall_from_a_time_on(dataset: Dataset) -> None:
    lr = TeacherLearningRates(final_factor=0.1)
    teacher = Teacher(replace(TEACHER, steps=100, lr=lr), dataset, seed=0, device=CPU)
    found = {}
    for teacher.done in (0, 50, 75, 100):
        found[teacher.done] = teacher._lrs()
    for name in ("quats", "log_scales", "logit_opacities", "sh0", "sh_rest"):
        falling = [rates[name] / found[0][name] for rates in found.values()]
        assert falling == pytest.approx([1, 1, 0.1**0.5, 0.1]), name


@pytest.mark.parametrize(
    ("strategy", "stops"),
    [("clone_split", (40, 40)), ("mcmc", (67, 67)), ("mini_splatting", (67, 67))],
)
def test_fewer_steps_end_densification_sooner(
    dataset: Dataset, strategy: str, stops: tuple[int, int]
) -> None:
    densify = replace(TEACHER.densify, strategy=strategy)
    teacher = Teacher(replace(TEACHER, steps=100, densify=densify), dataset, seed=0, device=CPU)
    teacher.set_steps(80, 0)
    shorter = teacher.strategy.last_event
    teacher.set_steps(120, 0)
    assert (shorter, teacher.strategy.last_event, teacher.steps) == (*stops, 120)
    teacher.set_steps(1, 0)
    assert teacher.steps == teacher.strategy.last_event + 1


@pytest.mark.parametrize("config", [TeacherConfig, StudentConfig])
def test_a_step_without_views_is_refused(config: type) -> None:
    with pytest.raises(InputError, match="views_per_step must be at least 1, not 0"):
        config(views_per_step=0)


@pytest.mark.parametrize("min_views", [1, 2])
def test_gaussians_in_too_few_cameras_are_removed_in_the_end(
    dataset: Dataset, min_views: int
) -> None:
    config = replace(TEACHER, min_views=min_views, densify=DensifyConfig(strategy="fixed"))
    teacher = Teacher(replace(config, steps=2), dataset, seed=0, device=CPU)
    with torch.no_grad():
        before_one_eye = 0.85 * dataset.train[0].camera.position
        teacher.adam.tensors["means"][0] = before_one_eye
        teacher.adam.tensors["log_scales"][0] = -4
    train(teacher, dataset, 1)
    assert teacher.count == 40
    train(teacher, dataset, 2)
    assert teacher.count == (40 if min_views == 1 else 39)
