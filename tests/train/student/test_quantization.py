"""The rate term before and after quantisation: its gradients and its effect."""

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch

from mobilegs.csrc import binding
from mobilegs.data.dataset import Dataset
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import UniformQuantizer
from mobilegs.train.student.quantization import (
    RATE_SCALE,
    add_early_rate_gradients,
    add_rate_gradients,
)
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from tests.support.selection import few
from tests.support.tiny import STUDENT, changed, train

MakeStudent = Callable[..., Student]
WITH_RATE = changed(
    STUDENT, quantization={"method": "sq", "rate_weight": 1.0}, schedule={"quantize_from": 1.0}
)
KINDS = {
    "lobes from latents": WITH_RATE,
    "network": replace(WITH_RATE, view_dependence=ViewDependence("network")),
    "sorted": replace(WITH_RATE, blend="sorted", view_dependence=ViewDependence("constant")),
}


def leaf(*shape: int, generator: torch.Generator) -> torch.Tensor:
    spreads = torch.logspace(-3, 3, shape[1], dtype=torch.float64)
    return (5 + spreads * torch.randn(*shape, generator=generator).double()).requires_grad_()


def test_early_rate_gradients_match_autograd(generator: torch.Generator) -> None:
    values = leaf(200, 4, generator=generator)
    x = values - values.detach().mean(0)
    small = RATE_SCALE * values.detach().std(0, correction=0)
    bits = torch.log2(1 + (x / small) ** 2).sum() / 2
    (expected,) = torch.autograd.grad(3 * bits / len(values), values)
    add_early_rate_gradients({"view": values}, 3.0)
    assert values.grad is not None
    torch.testing.assert_close(values.grad, expected, rtol=1e-9, atol=0)


@pytest.mark.parametrize("rows", [1, 7])
def test_columns_of_equal_values_have_no_rate_gradient(rows: int) -> None:
    values = torch.full((rows, 2), 3.5, requires_grad=True)
    add_early_rate_gradients({"lobe_latents": values}, 1.0)
    assert values.grad is not None and values.grad.shape == (rows, 2)
    assert (values.grad == 0).all()


@pytest.mark.parametrize("kind", few(KINDS, "lobes from latents"))
def test_the_early_rate_term_moves_values_towards_their_mean(
    kind: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    """It does so in every kind of student, except for the means, which have no codes."""
    spreads = []
    for begins in (1.0, 0.7):
        student = make_student(changed(KINDS[kind], schedule={"rate_from": begins}))
        train(student, dataset, 28)
        tensors, generator = student.model.rows.tensors, torch.Generator().manual_seed(0)
        for name in sorted(tensors.keys() - {"means"}):
            tensors[name].data += torch.randn(tensors[name].shape, generator=generator)
        train(student, dataset, 39)
        spreads.append({name: values.std(0).mean().item() for name, values in tensors.items()})
    late, early = spreads
    assert {"log_scales", "quats", "static", "view"} < late.keys()
    assert all(early[name] < late[name] for name in late.keys() - {"means"}), (early, late)


@pytest.mark.parametrize("rows", [1, 700])
def test_the_kernel_of_the_rate_agrees_with_the_reference(
    rows: int, generator: torch.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = torch.randn(rows, 3, generator=generator) * torch.tensor([0.1, 5.0, 300.0])
    codes = UniformQuantizer.fit(start, step_size=0.7)
    codes.log_step_offset.data.fill_(0.1)
    assert binding.supports(start)
    found = []
    for by_kernel in (True, False):
        if not by_kernel:
            monkeypatch.setattr(binding, "supports", lambda *tensors: False)
        values = torch.nn.Parameter(start.clone())
        values.grad, codes.log_step_offset.grad = torch.ones_like(values), None
        add_rate_gradients({"scale": codes}, {"scale": values}, 2.5)
        found.append((values.grad, codes.log_step_offset.grad))
    for kernel, reference in zip(*found, strict=True):
        torch.testing.assert_close(kernel, reference, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("rows", [1, 700])
def test_the_kernel_of_angles_agrees_with_the_reference(
    rows: int, generator: torch.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    quats = torch.randn(rows, 4, generator=generator)
    quats[:3] = torch.eye(4)[:rows][:3]  # no rotation, and half turns
    scales = UniformQuantizer.fit(torch.randn(rows, 3, generator=generator), step_size=0.7)
    codes = RotationQuantizer.fit(quats, scales=scales, step_size=0.2)
    found = []
    for by_kernel in (True, False):
        if not by_kernel:
            monkeypatch.setattr(binding, "supports", lambda *tensors: False)
        codes.log_step_offset.grad = None
        add_rate_gradients({"rotation": codes}, {"rotation": quats}, 2.5)
        found.append(codes.log_step_offset.grad)
    torch.testing.assert_close(found[0], found[1], rtol=1e-4, atol=1e-6)
    assert (found[1] != 0) == (rows > 1)


def test_the_rate_of_values_that_are_not_numbers_ends(generator: torch.Generator) -> None:
    values = torch.nn.Parameter(torch.randn(70, 2, generator=generator))
    values.data[3, 1], values.data[5, 0] = math.nan, -math.inf
    codes = UniformQuantizer.fit(values.detach(), step_size=0.1)
    add_rate_gradients({"scale": codes}, {"scale": values}, 1.0)
    assert values.grad is not None and bool(values.grad[:3].isfinite().all())
