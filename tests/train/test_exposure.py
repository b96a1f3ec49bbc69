"""Exposure and white balance of single photos, learned with the scene and dropped with the run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, Frame, load_view
from mobilegs.evaluate.metrics import psnr
from mobilegs.render.scene import Scene
from mobilegs.train import exposure
from mobilegs.train.exposure import (
    ExposureConfig,
    Exposures,
    exposure_gains,
    exposures_for,
    solve_gains,
    vignette,
)
from mobilegs.train.teacher.trainer import Teacher, TeacherConfig
from tests.support.tiny import CPU, TEACHER, blobs, train

LEARNED = ExposureConfig(learned="always")
NEVER = ExposureConfig(learned="never")
GAINS = torch.tensor([0.7, 0.85, 1.0, 1.05, 1.15, 1.25])  # of the six photos; their mean is 1


@pytest.fixture(autouse=True)
def short_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of a few steps need higher learning rates."""
    monkeypatch.setattr(exposure, "LR", 0.01)
    monkeypatch.setattr(exposure, "LR_END", 0.002)


@pytest.fixture(scope="module")
def uneven(dataset: Dataset) -> Dataset:
    """The capture with darker and brighter photos, the held-back one as it was."""
    frames = []
    for frame, gain in zip(dataset.train, GAINS, strict=True):
        assert frame.pixels is not None
        pixels = (frame.pixels.float() * gain).clamp(0, 255).round().to(torch.uint8)
        frames.append(replace(frame, pixels=pixels))
    return replace(dataset, train=frames)


def some_gains(generator: torch.Generator) -> torch.Tensor:
    return 0.1 * torch.randn(3, 3, generator=generator)


def test_a_photo_s_colours_are_an_affine_change_of_the_render(generator: torch.Generator) -> None:
    gains = some_gains(generator)
    exposures = Exposures(LEARNED, gains)
    image = torch.rand(4, 5, 3, generator=generator)
    factors = 2**gains - (2**gains).mean(0) + 1  # in sRGB, light is a power of colour + 0.055
    expected = (image[0, 0] + 0.055) * factors[2] - 0.055
    torch.testing.assert_close(exposures.apply(2, image)[0, 0].detach(), expected)
    with torch.no_grad():
        exposures.changes.add_(0.1 * torch.randn(3, 3, 4, generator=generator))
    change = exposures.changes[1].detach().numpy()
    expected = np.einsum("ij,hwj->hwi", change[:, :3], image.numpy()) + change[:, 3]
    found = exposures.apply(1, image)
    np.testing.assert_allclose(found.detach().numpy(), expected, atol=1e-6)
    penalty = exposure.PENALTY_WEIGHT * ((change - np.eye(3, 4)) ** 2).sum()
    assert float(exposures.penalty(1).detach()) == pytest.approx(penalty, rel=1e-5)
    (found.sum() + exposures.penalty(1)).backward()
    assert exposures.changes.grad is not None
    assert (exposures.changes.grad[[0, 2]] == 0).all()
    exposures.step(0.5)
    mean = exposures.changes.mean(0)
    torch.testing.assert_close(mean, torch.eye(3, 4))  # the scene takes no tint


def test_a_vignette_falls_off_to_the_corners_and_learns(generator: torch.Generator) -> None:
    found = vignette(torch.tensor([-0.3, 0.1]), torch.zeros(4, 6, 3)).numpy()
    for row, column in ((0, 0), (1, 4), (3, 2)):
        squares = ((column + 0.5 - 3) ** 2 + (row + 0.5 - 2) ** 2) / (3**2 + 2**2)
        expected = 1 - 0.3 * squares + 0.1 * squares**2
        assert found[row, column, 0] == pytest.approx(expected, rel=1e-6)
    exposures = Exposures(replace(LEARNED, vignetting=True), some_gains(generator))
    assert len(exposures.leaves) == 2
    image = torch.rand(8, 6, 3, generator=generator)
    before = exposures.apply(0, image)
    (before * vignette(torch.tensor([-1.0, 0.0]), image)).sum().backward()
    exposures.step(0.0)
    falloff = exposures.adam.tensors["falloff"].detach()
    torch.testing.assert_close(falloff.abs(), torch.full((2,), exposure.LR))


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


@pytest.mark.thorough
def test_a_teacher_finds_the_gains_of_uneven_photos(uneven: Dataset) -> None:
    plain = replace(TEACHER, steps=240)
    without, learned = (trained(replace(plain, exposure=each), uneven) for each in (NEVER, LEARNED))
    assert learned.exposures is not None and without.exposures is None
    grey = torch.full((1, 1, 3), 0.4)
    found = torch.stack([learned.exposures.apply(i, grey).mean() for i in range(6)]).detach()
    assert float(torch.corrcoef(torch.stack([found, GAINS]))[0, 1]) > 0.9
    assert quality(learned, uneven) > quality(without, uneven)


def test_photos_decide_whether_exposures_are_learned(dataset: Dataset, uneven: Dataset) -> None:
    scene = Scene(blobs(), near=0.2)  # a teacher's depths are right by luck at this size
    (found, even), (_, differing) = (
        exposures_for(ExposureConfig(), scene, each.train) for each in (dataset, uneven)
    )
    assert even is not None and differing is not None and even < 0.12 < differing and found is None
    found, spread = exposures_for(ExposureConfig(), scene, uneven.train)
    assert found is not None and spread == differing
    grey = torch.full((1, 1, 3), 0.4)
    gains = torch.stack([found.apply(i, grey).mean() for i in range(6)]).detach()
    assert float(torch.corrcoef(torch.stack([gains, GAINS]))[0, 1]) > 0.8  # over neighbours
    assert exposures_for(NEVER, scene, uneven.train) == (None, None)
    assert exposures_for(LEARNED, scene, dataset.train)[0] is not None


@pytest.mark.parametrize(("noise", "learned"), [(0.02, True), (0.1, True), (1.0, False)])
def test_gains_that_explain_nothing_are_no_exposures(
    dataset: Dataset,
    generator: torch.Generator,
    monkeypatch: pytest.MonkeyPatch,
    noise: float,
    learned: bool,
) -> None:
    """Photos that show other things at a point differ in their means, and hardly elsewhere."""
    gains = GAINS.log2()[:, None].expand(6, 3)
    colors = torch.randn(2000, 1, 3, generator=generator) + gains
    colors = colors + noise * torch.randn(2000, 6, 3, generator=generator)
    shared = colors, torch.ones(2000, 6)
    monkeypatch.setattr(exposure, "shared_colors", lambda scene, frames: shared)
    scene = trained(replace(TEACHER, steps=1), dataset).scene()
    found, spread = exposures_for(ExposureConfig(), scene, dataset.train)
    assert (found is not None) == learned and spread is not None
    assert spread > exposure.LEAST_SPREAD if learned else spread == 0


def test_exif_that_differs_is_enough(uneven: Dataset, dataset: Dataset) -> None:
    scene = trained(replace(TEACHER, steps=40, exposure=NEVER), dataset).scene()
    scene.gaussians.means.add_(1e3)  # no photo shows a point
    frames = [replace(f, exposure=float(g)) for f, g in zip(uneven.train, 4 * GAINS, strict=True)]
    found, spread = exposures_for(ExposureConfig(), scene, frames)
    assert found is not None and spread is not None and spread > exposure.LEAST_SPREAD


def test_gains_follow_from_points_that_photos_share(generator: torch.Generator) -> None:
    """Colours are gain + colour of the point, with outliers and points that few photos show."""
    gains = 0.3 * torch.randn(12, 3, generator=generator)
    points = torch.randn(500, 1, 3, generator=generator)
    colors = gains + points + 0.01 * torch.randn(500, 12, 3, generator=generator)
    outliers = torch.rand(500, 12, generator=generator) < 0.2
    colors[outliers] += 2 * torch.rand(int(outliers.sum()), 3, generator=generator)
    shown = (torch.rand(500, 12, generator=generator) < 0.4).float()
    found = solve_gains(torch.where(shown[..., None] > 0, colors, 9.0), shown)
    torch.testing.assert_close(found - found.mean(0), gains - gains.mean(0), atol=0.01, rtol=0)
    nothing = solve_gains(colors, torch.zeros_like(shown))
    assert torch.equal(nothing, torch.zeros(12, 3))


def test_photos_without_shared_points_have_the_gain_of_their_exif(
    generator: torch.Generator, tmp_path: Path
) -> None:
    gains = 0.3 * torch.randn(6, 3, generator=generator)
    colors = gains + torch.randn(200, 1, 3, generator=generator)
    shown = torch.ones(200, 6)
    shown[:, 5] = 0
    guess = torch.tensor([0.3, 0.1, -0.2, 0.0, 0.1, -0.5])
    found = solve_gains(colors, shown, guess)
    assert torch.equal(found[5], torch.full((3,), -0.5))
    others = found[:5] - found[:5].mean(0)
    torch.testing.assert_close(others, gains[:5] - gains[:5].mean(0), atol=1e-3, rtol=0)

    exposures = [(1 / 100, 100, 1.8), (1 / 50, 100, 1.8), (1 / 100, 800, 1.8), (1 / 100, 100, 3.6)]
    frames = []
    for index, (time, iso, number) in enumerate(exposures):
        exif = Image.Exif()
        exif.get_ifd(0x8769).update({0x829A: time, 0x8827: iso, 0x829D: number})
        Image.new("RGB", (8, 8)).save(tmp_path / f"{index}.jpg", exif=exif)
        camera = Camera(torch.eye(4), torch.eye(3), 8, 8)
        frames.append(Frame(f"{index}.jpg", camera, tmp_path / f"{index}.jpg"))
    found = exposure_gains(frames)
    assert found is not None
    steps = torch.tensor([0.0, 1.0, 3.0, -2.0]) / 2.4  # in light, to the power of sRGB
    torch.testing.assert_close(found, steps - steps.mean(), atol=1e-4, rtol=0)
    # that of the capture counts before that of its file, and none is guessed
    assert exposure_gains([replace(frames[0], exposure=5.0), frames[1]]) is not None
    Image.new("RGB", (8, 8)).save(tmp_path / "0.jpg")
    assert exposure_gains(frames) is None
