"""Operations whose bits do not depend on the number of threads, compared with those of torch."""

from collections.abc import Callable, Iterator

import pytest
import torch
from torch import Tensor
from torch.autograd import gradcheck, gradgradcheck

from mobilegs.reproducible import column_means, product, sigmoid, times, total

ROWS = (1, 257, 512, 97_965)  # from 32,768 elements on torch divides its work


@pytest.fixture(autouse=True)
def same_threads() -> Iterator[None]:
    before = torch.get_num_threads()
    yield
    torch.set_num_threads(before)


def random(*shape: int, seed: int = 1) -> Tensor:
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed))


def assert_same_bits(operation: Callable[..., Tensor], *inputs: Tensor) -> tuple[Tensor, ...]:
    """Compare result and gradients for several numbers of threads; return them."""
    first: tuple[Tensor, ...] = ()
    for number in (1, 2, 7):
        torch.set_num_threads(number)
        leaves = [each.clone().requires_grad_() for each in inputs]
        found = operation(*leaves)
        found.backward(random(*found.shape, seed=9))
        grads = [leaf.grad for leaf in leaves if leaf.grad is not None]
        first = first or (found, *grads)
        assert len(first) == 1 + len(grads)
        assert all(torch.equal(a, b) for a, b in zip(first, (found, *grads), strict=True))
    return first


@pytest.mark.parametrize("count", ROWS)
def test_a_sigmoid(count: int) -> None:
    values = 4 * random(count)
    found, _ = assert_same_bits(sigmoid, values)
    torch.testing.assert_close(found, values.sigmoid())


def test_a_sigmoid_and_its_gradient_hold_everywhere() -> None:
    values = torch.tensor([-1000.0, -90, -20, -1e-8, 0, 3, 20, 90, 1000], dtype=torch.float64)
    for dtype in (torch.float32, torch.float64):
        mine, theirs = (values.to(dtype).requires_grad_() for _ in range(2))
        sigmoid(mine).sum().backward()
        theirs.sigmoid().sum().backward()
        torch.testing.assert_close(sigmoid(mine), theirs.sigmoid(), rtol=1e-6, atol=1e-38)
        torch.testing.assert_close(mine.grad, theirs.grad, rtol=1e-5, atol=1e-38)
    some = torch.randn(20, dtype=torch.float64, requires_grad=True)
    assert gradcheck(sigmoid, some) and gradgradcheck(sigmoid, some)


@pytest.mark.parametrize("count", ROWS)
@pytest.mark.parametrize("columns", [(), (4, 3)])
def test_sums_and_means(count: int, columns: tuple[int, ...]) -> None:
    values = random(count, *columns)
    found, _ = assert_same_bits(total, values)
    torch.testing.assert_close(found, values.sum(), rtol=1e-4, atol=1e-3)
    found, _ = assert_same_bits(column_means, values)
    torch.testing.assert_close(found, values.mean(0), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("count", ROWS)
def test_a_factor_of_all_values(count: int) -> None:
    values, factor = random(count, 3), torch.tensor(0.7)
    found, grad = assert_same_bits(lambda factor: times(values, factor), factor)
    assert torch.equal(found, values * factor)
    expected = (values * random(count, 3, seed=9)).sum()
    torch.testing.assert_close(grad, expected, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("count", ROWS)
@pytest.mark.parametrize(("shape", "full"), [((13, 18), True), ((31, 16), False), ((1, 1), False)])
def test_a_product(count: int, shape: tuple[int, int], full: bool) -> None:
    values, matrix = random(count, shape[0]), random(*shape, seed=2)
    added = random(count, shape[1], seed=3) if full else random(shape[1], seed=3)
    found = assert_same_bits(product, values, matrix, added)
    leaves = [each.clone().requires_grad_() for each in (values, matrix, added)]
    expected = torch.addmm(leaves[2], leaves[0], leaves[1])
    expected.backward(random(*expected.shape, seed=9))
    for a, b in zip(found, (expected, *(leaf.grad for leaf in leaves)), strict=True):
        torch.testing.assert_close(a, b, rtol=1e-3, atol=3e-3)


def test_gradients_of_a_product_and_a_factor() -> None:
    values, matrix, added = (
        random(*shape).double().requires_grad_() for shape in ((600, 3), (3, 2), (2,))
    )
    assert gradcheck(product, (values, matrix, added), fast_mode=True)
    factor = torch.tensor(0.7, dtype=torch.float64, requires_grad=True)
    assert gradcheck(lambda factor: times(values[:50], factor), factor)
