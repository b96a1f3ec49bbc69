"""Masks that are learned: what they make of opacities, and what they remove."""

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from torch.autograd import gradcheck
from torch.nn.functional import normalize

from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.render.lobes import seen_along
from mobilegs.spherical_harmonics import C0
from mobilegs.train.student.mask_pruning import PresenceConfig, fainter
from mobilegs.train.student.shared_decode import Seen
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from mobilegs.train.student.vote_pruning import VoteConfig
from tests.support.tiny import STUDENT, cameras, train

MakeStudent = Callable[..., Student]
KINDS = {
    "sorted": replace(STUDENT, blend="sorted", view=ViewDependence("constant")),
    "lobes from latents": STUDENT,
    "free lobes": replace(STUDENT, view=ViewDependence("free", fraction=0.6)),
    "network": replace(STUDENT, view=ViewDependence("network")),
}


def in_double(camera: Camera) -> Camera:
    return replace(camera, viewmat=camera.viewmat.double(), K=camera.K.double())


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_opacity_is_multiplied_and_phi_is_not(degree: int, generator: torch.Generator) -> None:
    means = torch.randn(64, 3, generator=generator, dtype=torch.float64)
    lobes = torch.randn(64, (degree + 1) ** 2, 2, generator=generator, dtype=torch.float64) * 4
    presence = torch.rand(64, generator=generator, dtype=torch.float64)
    camera = in_double(cameras()[0])
    directions = normalize(means - camera.position, dim=1)
    before, phi = seen_along(lobes, directions)
    after, same = seen_along(fainter(lobes, presence, means, camera), directions)
    torch.testing.assert_close(after, presence * before, atol=1e-12, rtol=1e-9)
    assert torch.equal(phi, same)


def test_gradients_reach_masks_and_lobes(generator: torch.Generator) -> None:
    means = torch.randn(5, 3, generator=generator, dtype=torch.float64)
    lobes = torch.randn(5, 9, 2, generator=generator, dtype=torch.float64).requires_grad_()
    presence = (
        0.1 + 0.8 * torch.rand(5, generator=generator, dtype=torch.float64)
    ).requires_grad_()
    camera = in_double(cameras()[1])
    assert gradcheck(lambda a, b: fainter(a, b, means, camera), (lobes, presence))


def test_the_surest_and_the_faintest_stay_finite() -> None:
    logits = torch.tensor([-300.0, -90.0, 0.0, 90.0, 300.0])
    for value in (0.0, 1e-30, 0.5, 1 - 2**-24, 1.0):
        lobes = torch.stack([logits, torch.ones(5)], 1)[:, None].div(C0).requires_grad_()
        presence = torch.full((5,), value, requires_grad=True)
        found = fainter(lobes, presence, torch.zeros(5, 3), cameras()[0])
        found.sum().backward()
        assert found.isfinite().all()
        assert lobes.grad.isfinite().all() and presence.grad.isfinite().all()
        if value == 1:
            assert torch.equal(found, lobes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_with_masks_is_that_of_fainter_gaussians(
    kind: str, make_student: MakeStudent, generator: torch.Generator
) -> None:
    student = make_student(KINDS[kind])
    some = cameras()[:2]  # each of them sees its own opacities
    options = {"background": student.background}
    whole, plain = torch.ones(50), Seen(student.model, some)
    for number in range(2):
        same = Seen(student.model, some, presence=whole).draw(number, **options)
        torch.testing.assert_close(same.image, plain.draw(number, **options).image)
    masks = torch.rand(50, generator=generator).requires_grad_()
    seen = Seen(student.model, some, presence=masks)
    pictures = [seen.draw(number, **options).image for number in range(2)]
    for picture in pictures:
        picture.sum().backward()
    seen.backward()
    assert (masks.grad != 0).sum() > 25
    gone = torch.full((50,), 1e-12)
    empty = Seen(student.model, some, presence=gone).draw(0, **options)
    assert empty.alpha.max() < 1e-3 < plain.draw(0, **options).alpha.max()


@pytest.mark.parametrize("kind", ["sorted", "lobes from latents"])
def test_masks_remove_what_nothing_needs(
    kind: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    """Half of the Gaussians are too faint to be drawn: only the loss on the masks tells them."""
    presence = PresenceConfig(weight=1.0, rate=0.5, until=0.75)
    votes = VoteConfig(quantile=0.0, interval=0.25)
    student = make_student(replace(KINDS[kind], presence=presence, votes=votes))
    faint = torch.arange(50) % 2 == 0
    with torch.no_grad():
        rows = student.model.rows.tensors
        if kind == "sorted":
            rows["logit_opacities"][faint] = -6.0
        else:
            rows["explicit_lobes"][faint, 0, 0] = -6.0 / C0
    train(student, dataset, 29)
    assert "presence" in student.model.rows.tensors
    train(student, dataset, 30)
    assert "presence" not in student.model.rows.tensors
    left = student.count
    assert 5 <= left <= 25
    train(student, dataset, 40)
    assert student.count == left


def test_masks_go_on_where_they_were(dataset: Dataset, make_student: MakeStudent) -> None:
    config = replace(STUDENT, presence=PresenceConfig(weight=0.5, rate=0.3, until=0.5))
    whole = make_student(config)
    train(whole, dataset, 12)
    for stop in (12, 22):  # while there are masks, and when they are gone
        train(whole, dataset, stop)
        again = make_student(config)
        again.restore(whole.state())
        assert ("presence" in again.model.rows.tensors) == (stop == 12)
    train(whole, dataset, 40)
    train(again, dataset, 40)
    for name, tensor in whole.model.rows.tensors.items():
        assert torch.equal(tensor, again.model.rows.tensors[name]), name


def test_masks_are_random_but_repeatable_and_told_apart(generator: torch.Generator) -> None:
    config = PresenceConfig(weight=0.5, temperature=0.2)
    logits = torch.tensor([-3.0, 0.0, 3.0]).repeat(20000).requires_grad_()
    drawn = config.draw(logits, generator)
    assert torch.equal(drawn, config.draw(logits, torch.Generator().manual_seed(0)))
    near_one = (drawn.detach() > 0.5).float().view(-1, 3).mean(0)  # with the very probability
    torch.testing.assert_close(near_one, torch.sigmoid(logits[:3]).detach(), atol=0.01, rtol=0)
    config.loss(logits).backward()
    assert (logits.grad > 0).all()
    assert config.stay(logits[:3], last=False).tolist() == [False, True, True]
    assert config.stay(logits[:3] - 0.1, last=True).tolist() == [False, False, True]


def test_a_temperature_of_zero_is_refused() -> None:
    with pytest.raises(InputError, match="temperature above 0"):
        PresenceConfig(temperature=0.0)
