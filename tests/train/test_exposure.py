"""Exposure and white balance of single photos, learned with the scene and dropped with the run."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import torch

from mobilegs.data.dataset import Dataset, load_view
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import psnr
from mobilegs.train.exposure import ExposureConfig, Exposures
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.tiny import CPU, STUDENT, TEACHER, train

LEARNED = ExposureConfig(learned=True, lr=0.01, lr_end=0.002)
GAINS = torch.tensor([0.7, 0.85, 1.0, 1.05, 1.15, 1.25])  # of the six photos; their mean is 1


@pytest.fixture(scope="module")
def uneven(dataset: Dataset) -> Dataset:
    """The capture with darker and brighter photos, the held-back one as it was."""
    frames = []
    for frame, gain in zip(dataset.train, GAINS, strict=True):
        assert frame.pixels is not None
        pixels = (frame.pixels.float() * gain).clamp(0, 255).round().to(torch.uint8)
        frames.append(replace(frame, pixels=pixels))
    return replace(dataset, train=frames)


def test_a_photo_s_colours_are_an_affine_change_of_the_render(generator: torch.Generator) -> None:
    exposures = Exposures(LEARNED, 3, CPU)
    with torch.no_grad():
        exposures.changes.add_(0.1 * torch.randn(3, 3, 4, generator=generator))
    image = torch.rand(4, 5, 3, generator=generator)
    change = exposures.changes[1].detach().numpy()
    expected = np.einsum("ij,hwj->hwi", change[:, :3], image.numpy()) + change[:, 3]
    found = exposures.apply(1, image)
    np.testing.assert_allclose(found.detach().numpy(), expected, atol=1e-6)
    penalty = LEARNED.weight * ((change - np.eye(3, 4)) ** 2).sum()
    assert float(exposures.penalty(1).detach()) == pytest.approx(penalty, rel=1e-5)
    (found.sum() + exposures.penalty(1)).backward()
    assert exposures.changes.grad is not None
    assert (exposures.changes.grad[[0, 2]] == 0).all()
    exposures.step(0.5)
    mean = exposures.changes.mean(0)
    torch.testing.assert_close(mean, torch.eye(3, 4))  # the scene takes no tint


def trained(config: TeacherConfig, dataset: Dataset) -> Teacher:
    teacher = Teacher(config, dataset, seed=0, device=CPU)
    train(teacher, dataset, config.steps)
    return teacher


def quality(teacher: Teacher, dataset: Dataset) -> float:
    views = [load_view(frame) for frame in dataset.test]
    images = [teacher.scene().render(view.camera).image for view in views]
    return float(
        np.mean([psnr(i.clamp(0, 1), v.image) for i, v in zip(images, views, strict=True)])
    )


def test_a_teacher_finds_the_gains_of_uneven_photos(uneven: Dataset) -> None:
    plain = replace(TEACHER, steps=240)
    without, learned = (
        trained(replace(plain, exposure=each), uneven) for each in (ExposureConfig(), LEARNED)
    )
    assert learned.exposures is not None and without.exposures is None
    found = learned.exposures.changes.detach()[:, :, :3].diagonal(dim1=1, dim2=2).mean(1)
    assert float(torch.corrcoef(torch.stack([found, GAINS]))[0, 1]) > 0.9
    assert quality(learned, uneven) > quality(without, uneven)


def test_a_resumed_run_with_exposures_ends_with_the_same_state(
    uneven: Dataset, make_student: Callable[..., Student]
) -> None:
    def teacher() -> Teacher:
        config = replace(TEACHER, exposure=LEARNED)
        return Teacher(config, uneven, seed=0, device=CPU)

    def student() -> Student:
        return make_student(replace(STUDENT, exposure=LEARNED))

    for make in (teacher, student):
        whole, first, second = make(), make(), make()
        train(whole, uneven, 9)
        train(first, uneven, 4)
        second.restore(first.state())
        train(second, uneven, 9)
        assert whole.exposures is not None and second.exposures is not None
        assert torch.equal(whole.exposures.changes, second.exposures.changes)
        assert not torch.equal(whole.exposures.changes[0], torch.eye(3, 4))
        assert (whole.state()["exposures"]["changes"]["step"] == 9).all()


def test_invalid_settings_are_refused() -> None:
    for name, value in (("lr", 0.0), ("lr_end", -1.0), ("weight", -0.1)):
        with pytest.raises(InputError):
            replace(ExposureConfig(), **{name: value})
