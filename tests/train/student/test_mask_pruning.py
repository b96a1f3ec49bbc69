"""Pruning by learned masks: their effect on opacities, and the Gaussians they remove."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import torch
from torch.autograd import gradcheck
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.render.lobes import evaluate_lobes
from mobilegs.spherical_harmonics import C0
from mobilegs.train.student.mask_pruning import MaskConfig, mask_lobes
from mobilegs.train.student.shared_decode import SharedDecode
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig
from tests.support.tiny import STUDENT, cameras, changed, grad_of, train

MakeStudent = Callable[..., Student]
KINDS = {
    "sorted": replace(STUDENT, blend="sorted", view_dependence=ViewDependence("constant")),
    "sorted, network": replace(STUDENT, blend="sorted", view_dependence=ViewDependence("network")),
    "lobes from latents": STUDENT,
    "free lobes": replace(STUDENT, view_dependence=ViewDependence("free", decoder_from=0.6)),
    "network": replace(STUDENT, view_dependence=ViewDependence("network")),
}


def in_double(camera: Camera) -> Camera:
    return replace(camera, viewmat=camera.viewmat.double(), K=camera.K.double())


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_masks_multiply_opacities_and_leave_phi(degree: int, generator: torch.Generator) -> None:
    means = torch.randn(64, 3, generator=generator, dtype=torch.float64)
    lobes = torch.randn(64, (degree + 1) ** 2, 2, generator=generator, dtype=torch.float64) * 4
    masks = torch.rand(64, generator=generator, dtype=torch.float64)
    camera = in_double(cameras()[0])
    directions = normalize(means - camera.position, dim=1)
    before, phi = evaluate_lobes(lobes, directions)
    after, same = evaluate_lobes(mask_lobes(lobes, masks, means, camera), directions)
    torch.testing.assert_close(after, masks * before, atol=1e-12, rtol=1e-9)
    assert torch.equal(phi, same)


def test_gradients_reach_masks_and_lobes(generator: torch.Generator) -> None:
    means = torch.randn(5, 3, generator=generator, dtype=torch.float64)
    lobes = torch.randn(5, 9, 2, generator=generator, dtype=torch.float64).requires_grad_()
    masks = (0.1 + 0.8 * torch.rand(5, generator=generator, dtype=torch.float64)).requires_grad_()
    camera = in_double(cameras()[1])
    assert gradcheck(lambda a, b: mask_lobes(a, b, means, camera), (lobes, masks))


def test_extreme_opacities_and_masks_stay_finite() -> None:
    logits = torch.tensor([-300.0, -90.0, 0.0, 90.0, 300.0])
    for value in (0.0, 1e-30, 0.5, 1 - 2**-24, 1.0):
        lobes = torch.stack([logits, torch.ones(5)], 1)[:, None].div(C0).requires_grad_()
        masks = torch.full((5,), value, requires_grad=True)
        found = mask_lobes(lobes, masks, torch.zeros(5, 3), cameras()[0])
        found.sum().backward()
        assert found.isfinite().all()
        assert grad_of(lobes).isfinite().all() and grad_of(masks).isfinite().all()
        if value == 1:
            assert torch.equal(found, lobes)


@pytest.mark.parametrize("kind", KINDS)
def test_masks_fade_gaussians_in_the_image(
    kind: str, make_student: MakeStudent, generator: torch.Generator
) -> None:
    student = make_student(KINDS[kind])
    some = cameras()[:2]  # opacities depend on the camera
    options: dict[str, Any] = {"background": student.background}
    whole, plain = torch.ones(50), SharedDecode(student.model, some)
    for number in range(2):
        same = SharedDecode(student.model, some, masks=whole).render(number, **options)
        torch.testing.assert_close(same.image, plain.render(number, **options).image)
    masks = torch.rand(50, generator=generator).requires_grad_()
    seen = SharedDecode(student.model, some, masks=masks)
    images = [seen.render(number, **options).image for number in range(2)]
    for image in images:
        image.sum().backward()
    seen.backward()
    assert (grad_of(masks) != 0).sum() > 25
    gone = torch.full((50,), 1e-12)
    empty = SharedDecode(student.model, some, masks=gone).render(0, **options)
    assert empty.alpha.max() < 1e-3 < plain.render(0, **options).alpha.max()


@pytest.mark.parametrize("kind", ["sorted", "lobes from latents"])
def test_masks_remove_gaussians_without_an_effect(
    kind: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    """Half of the Gaussians are too faint to be rendered: their masks get only the masks' loss."""
    masks = MaskConfig(weight=1.0, until=0.75)
    votes = VoteConfig(quantile=0.0, interval=0.25)
    student = make_student(
        changed(KINDS[kind], pruning={"masks": masks, "votes": votes}, lr={"masks": 0.5})
    )
    faint = torch.arange(50) % 2 == 0
    with torch.no_grad():
        rows = student.model.rows.tensors
        if kind == "sorted":
            rows["logit_opacities"][faint] = -6.0
        else:
            rows["explicit_lobes"][faint, 0, 0] = -6.0 / C0
    train(student, dataset, 29)
    assert "masks" in student.model.rows.tensors
    train(student, dataset, 30)
    assert "masks" not in student.model.rows.tensors
    left = student.count
    assert 5 <= left <= 25
    train(student, dataset, 40)
    assert student.count == left


def test_training_with_masks_resumes_exactly(dataset: Dataset, make_student: MakeStudent) -> None:
    config = changed(
        STUDENT, pruning={"masks": MaskConfig(weight=0.5, until=0.5)}, lr={"masks": 0.3}
    )
    whole = make_student(config)
    train(whole, dataset, 12)
    for stop in (12, 22):  # with masks, and after their end
        train(whole, dataset, stop)
        again = make_student(config)
        again.restore(whole.state())
        assert ("masks" in again.model.rows.tensors) == (stop == 12)
    train(whole, dataset, 40)
    train(again, dataset, 40)
    for name, tensor in whole.model.rows.tensors.items():
        assert torch.equal(tensor, again.model.rows.tensors[name]), name


def test_masks_are_drawn_with_their_probability_and_repeatably(generator: torch.Generator) -> None:
    config = MaskConfig(weight=0.5, temperature=0.2)
    logits = torch.tensor([-3.0, 0.0, 3.0]).repeat(20000).requires_grad_()
    drawn = config.sample(logits, generator)
    assert torch.equal(drawn, config.sample(logits, torch.Generator().manual_seed(0)))
    near_one = (drawn.detach() > 0.5).float().view(-1, 3).mean(0)  # the mean is the probability
    torch.testing.assert_close(near_one, torch.sigmoid(logits[:3]).detach(), atol=0.01, rtol=0)
    config.loss(logits).backward()
    assert (grad_of(logits) > 0).all()
    assert config.kept(logits[:3], final=False).tolist() == [False, True, True]
    assert config.kept(logits[:3] - 0.1, final=True).tolist() == [False, False, True]


def test_a_temperature_of_zero_is_refused() -> None:
    with pytest.raises(InputError, match="temperature must be above 0"):
        MaskConfig(temperature=0.0)
