"""The price on bits before there are codes: what it adds to gradients, when, and what of."""

from collections.abc import Callable
from dataclasses import replace

import pytest
import torch

from mobilegs.data.dataset import Dataset
from mobilegs.errors import InputError
from mobilegs.train.student.quantization import SMALL, pay_ahead
from mobilegs.train.student.trainer import Student
from mobilegs.train.student.view_dependence import ViewDependence
from tests.support.tiny import STUDENT, train

MakeStudent = Callable[..., Student]
PRICED = replace(STUDENT, coding="sq", bit_price=1.0, codes_fraction=1.0)
KINDS = {
    "lobes from latents": PRICED,
    "free lobes": replace(PRICED, view=ViewDependence("free", fraction=0.6)),
    "network": replace(PRICED, view=ViewDependence("network")),
    "sorted": replace(PRICED, blend="sorted", view=ViewDependence("constant")),
}


def leaf(*shape: int, generator: torch.Generator) -> torch.Tensor:
    spreads = torch.logspace(-3, 3, shape[1], dtype=torch.float64)
    return (5 + spreads * torch.randn(*shape, generator=generator).double()).requires_grad_()


def test_the_gradient_is_that_of_the_bits_that_numbers_count(generator: torch.Generator) -> None:
    values = leaf(200, 4, generator=generator)
    x = values - values.detach().mean(0)
    small = SMALL * values.detach().std(0, correction=0)
    bits = torch.log2(1 + (x / small) ** 2).sum() / 2
    (expected,) = torch.autograd.grad(3 * bits / len(values), values)
    pay_ahead({"view": values}, 3.0)
    assert values.grad is not None
    torch.testing.assert_close(values.grad, expected, rtol=1e-9, atol=0)


def test_the_price_is_added_to_what_the_picture_asks_for(generator: torch.Generator) -> None:
    values, again = leaf(50, 3, generator=generator), leaf(50, 3, generator=generator)
    again.data.copy_(values.data)
    pay_ahead({"lobe_latents": values}, 1.0)
    again.grad = torch.full_like(again, 0.25)
    pay_ahead({"lobe_latents": again}, 1.0)
    assert values.grad is not None
    torch.testing.assert_close(again.grad - values.grad, torch.full_like(again, 0.25))


@pytest.mark.parametrize("rows", [1, 7])
def test_columns_of_equal_numbers_owe_nothing(rows: int) -> None:
    values = torch.full((rows, 2), 3.5, requires_grad=True)
    pay_ahead({"lobe_latents": values}, 1.0)
    assert values.grad is not None and values.grad.shape == (rows, 2)
    assert (values.grad == 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_that_shall_be_coded_come_near_their_mean(
    kind: str, dataset: Dataset, make_student: MakeStudent
) -> None:
    """In every kind of student, but for centres, which have no codes."""
    spreads = []
    for begins in (1.0, 0.7):
        student = make_student(replace(KINDS[kind], price_fraction=begins))
        train(student, dataset, 28)
        tensors, generator = student.model.rows.tensors, torch.Generator().manual_seed(0)
        for name in sorted(tensors.keys() - {"means"}):
            tensors[name].data += torch.randn(tensors[name].shape, generator=generator)
        train(student, dataset, 39)
        spreads.append({name: values.std(0).mean().item() for name, values in tensors.items()})
    late, early = spreads
    assert {"log_scales", "quats", "static", "view"} < late.keys()
    assert all(early[name] < late[name] for name in late.keys() - {"means"}), (early, late)


def test_codebooks_are_not_priced(dataset: Dataset, make_student: MakeStudent) -> None:
    found = []
    for begins in (1.0, 0.0):
        config = replace(STUDENT, coding="nvq", bit_price=1.0, price_fraction=begins)
        student = make_student(config)
        train(student, dataset, 20)
        found.append(student.model.rows.tensors)
    late, early = found
    assert late.keys() == early.keys() and len(late) > 3
    assert all(torch.equal(late[name], early[name]) for name in late)


def test_codes_pay_whenever_numbers_before_them_would_have_begun(
    dataset: Dataset, make_student: MakeStudent
) -> None:
    found = []
    for begins in (0.3, 1.0):
        config = replace(PRICED, codes_fraction=0.3, price_fraction=begins)
        student = make_student(config)
        train(student, dataset, 40)
        found.append(student.coded())
    for name, codes in found[0].indices.items():
        assert torch.equal(codes, found[1].indices[name])


@pytest.mark.parametrize("wrong", [-0.1, 1.1, float("nan")])
def test_a_share_of_the_run_is_one(wrong: float) -> None:
    with pytest.raises(InputError, match="price_fraction"):
        replace(STUDENT, price_fraction=wrong)
