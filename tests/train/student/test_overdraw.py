"""Overdraw: areas of ellipses, their gradients, and their effect on training."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from torch.testing import assert_close

from mobilegs.camera import Camera, look_at
from mobilegs.data.dataset import Dataset
from mobilegs.render.project import BLUR, project
from mobilegs.train.student.overdraw import overdraw
from mobilegs.train.student.shared_decode import SharedDecode
from mobilegs.train.student.trainer import Student
from tests.support.tiny import STUDENT, cameras, changed, train, with_kind

ALPHA_MIN = 1 / 64
DOUBLE = torch.float64


def camera(size: int = 200) -> Camera:
    K = torch.tensor([[900.0, 0, size / 2], [0, 900.0, size / 2], [0, 0, 1]], dtype=DOUBLE)
    eye = torch.tensor([0.3, -0.2, -4.0], dtype=DOUBLE)
    viewmat = look_at(eye, torch.zeros(3, dtype=DOUBLE), torch.tensor([0, -1.0, 0], dtype=DOUBLE))
    return Camera(viewmat, K, size, size)


def gaussians(count: int, seed: int = 0) -> tuple[torch.Tensor, ...]:
    """Return means, quats, log_scales and opacities of small ones near the image centre."""
    generator = torch.Generator().manual_seed(seed)

    def normal(*shape: int) -> torch.Tensor:
        return torch.randn(*shape, generator=generator, dtype=DOUBLE)

    opacities = torch.rand(count, generator=generator, dtype=DOUBLE)
    return 0.05 * normal(count, 3), normal(count, 4), normal(count, 3) * 0.7 - 4, opacities


def test_areas_match_those_of_projected_ellipses() -> None:
    view, (means, quats, log_scales, opacities) = camera(), gaussians(50)
    sh = torch.zeros(50, 1, 3, dtype=DOUBLE)
    projected = project(
        means, quats, log_scales.exp(), opacities, sh, camera=view, alpha_min=ALPHA_MIN
    )
    a, b, c = projected.conics.unbind(1)
    sharp = torch.linalg.inv(torch.stack([a, b, b, c], 1).view(-1, 2, 2))
    sharp = sharp - BLUR * torch.eye(2, dtype=DOUBLE)
    reach = 2 * torch.log((opacities / ALPHA_MIN).clamp_min(1))
    areas = math.pi * reach * torch.linalg.det(sharp).clamp_min(0).sqrt() / 200**2
    for i in range(50):
        row = slice(i, i + 1)
        found = overdraw(
            means[row], quats[row], log_scales[row], opacities[row],
            camera=view, alpha_min=ALPHA_MIN,
        )  # fmt: skip
        assert found == pytest.approx(float(areas[i]), rel=0.03, abs=1e-9), i
    everything = overdraw(means, quats, log_scales, opacities, camera=view, alpha_min=ALPHA_MIN)
    assert_close(everything, areas.sum(), rtol=0.01, atol=0)


def test_only_scales_receive_gradients() -> None:
    view, (means, quats, log_scales, opacities) = camera(), gaussians(7, seed=1)
    leaves = [t.requires_grad_() for t in (means, quats, log_scales, opacities)]
    overdraw(*leaves, camera=view, alpha_min=ALPHA_MIN).backward()
    assert log_scales.grad is not None and log_scales.grad.min() >= 0 < log_scales.grad.max()
    assert means.grad is None and quats.grad is None and opacities.grad is None
    faint = opacities.detach() <= ALPHA_MIN
    assert not log_scales.grad[faint].any()

    def of(scales: torch.Tensor) -> torch.Tensor:
        return overdraw(means, quats, scales, opacities, camera=view, alpha_min=ALPHA_MIN)

    assert torch.autograd.gradcheck(of, (log_scales.detach().requires_grad_(),))


def test_gradients_with_levels_by_finite_differences() -> None:
    view, (means, quats, log_scales, opacities) = camera(), gaussians(20, seed=3)
    log_scales = (log_scales + 1.0).requires_grad_()

    def of(scales: torch.Tensor) -> torch.Tensor:
        options = {"camera": view, "alpha_min": ALPHA_MIN, "level_sigma": 1.0}
        return overdraw(means, quats, scales, opacities, **options)

    assert torch.autograd.gradcheck(of, (log_scales,))
    round_ones = torch.full((2, 3), -2.0, dtype=DOUBLE, requires_grad=True)
    options = {"camera": view, "alpha_min": ALPHA_MIN, "level_sigma": 1.0}
    overdraw(means[:2], quats[:2], round_ones, opacities[:2], **options).backward()
    assert round_ones.grad is not None and round_ones.grad.isfinite().all()


def test_a_gaussian_counts_at_most_the_image_and_not_from_behind() -> None:
    view = camera()
    quats = torch.tensor([[1.0, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]], dtype=DOUBLE)
    huge = torch.full((3, 3), 3.0, dtype=DOUBLE, requires_grad=True)
    behind = 3 * view.position
    means = torch.stack([torch.zeros(3, dtype=DOUBLE), behind, view.position])
    opacities = torch.ones(3, dtype=DOUBLE)
    found = overdraw(means, quats, huge, opacities, camera=view, alpha_min=ALPHA_MIN)
    assert found.item() == pytest.approx(1.0)
    found.backward()
    assert huge.grad is not None and not huge.grad.any()  # and no NaN
    nothing = overdraw(
        *(t[:0] for t in (means, quats, huge, opacities)), camera=view, alpha_min=0.1
    )
    assert nothing.item() == 0


@pytest.mark.parametrize("kind", ["network", "latent", "sorted latent"])
def test_overdraw_of_a_shared_decode_is_that_of_its_first_camera(
    make_student: Callable[..., Student], kind: str
) -> None:
    config = with_kind(kind.removeprefix("sorted "))
    blend = "sorted" if kind.startswith("sorted") else "sortfree"
    student = make_student(replace(config, blend=blend))
    shared = SharedDecode(student.model, cameras()[:3])
    found = shared.overdraw()
    assert_close(found, SharedDecode(student.model, cameras()[:1]).overdraw())
    assert 0.1 < found < 20
    found.backward()
    reached = {name for name, leaf in shared.detached.items() if leaf.grad is not None}
    assert reached == {"log_scales"}


@pytest.mark.thorough
def test_an_overdraw_weight_reduces_overdraw(
    make_student: Callable[..., Student], dataset: Dataset
) -> None:
    found = []
    for weight in (0.0, 0.1):  # less is within the noise of a scene this small
        config = replace(STUDENT, steps=240)
        student = make_student(changed(config, loss={"overdraw_weight": weight}))
        train(student, dataset, student.steps)
        shared = [SharedDecode(student.model, [camera]) for camera in cameras()]
        found.append(sum(decoded.overdraw().item() for decoded in shared))
    assert found[1] < 0.97 * found[0]
