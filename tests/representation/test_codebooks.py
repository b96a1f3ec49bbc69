"""Sub-vector codebooks."""

import pytest
import torch

from mobilegs.representation.codebooks import SubVectorCodebooks, canonical_quats
from mobilegs.representation.float16 import FLOAT16_MAX, round_float16


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


@pytest.fixture
def values() -> torch.Tensor:
    return torch.randn(400, 6, generator=seeded())


@pytest.fixture
def books(values: torch.Tensor) -> SubVectorCodebooks:
    return SubVectorCodebooks.fit(values, length=2, size=32, generator=seeded())


def test_decoded_values_are_float16_numbers(books: SubVectorCodebooks) -> None:
    assert torch.equal(books(), books().half().float())
    assert not torch.equal(books.centers, books.centers.half().float())


def test_gradients_reach_exactly_the_entries_in_use(books: SubVectorCodebooks) -> None:
    rows = torch.tensor([3, 9])
    books(rows).sum().backward()
    expected = torch.zeros(3, 32)
    for row in rows:
        for s in range(3):
            expected[s, books.indices[row, s]] += 1
    assert books.centers.grad is not None
    assert torch.equal(books.centers.grad, expected[:, :, None].expand(-1, -1, 2))


def test_reassigning_follows_changed_values(
    books: SubVectorCodebooks, values: torch.Tensor
) -> None:
    before = (books() - (values + 0.5)).square().mean()
    books.reassign(values + 0.5)
    assert (books() - (values + 0.5)).square().mean() < before


def test_canonical_quaternions_are_the_same_rotation_with_positive_w() -> None:
    quats = 3 * torch.randn(100, 4, generator=seeded())
    unit = canonical_quats(quats)
    assert (unit[:, 0] >= 0).all()
    assert torch.allclose(unit.norm(dim=1), torch.ones(100))
    assert torch.allclose(canonical_quats(-quats), unit)
    overlap = (unit * quats / quats.norm(dim=1, keepdim=True)).sum(1).abs()
    assert torch.allclose(overlap, torch.ones(100))


def test_rounding_to_float16_saturates_and_passes_gradients() -> None:
    values = torch.tensor([1e9, -1e9, 0.1, 1e-9], requires_grad=True)
    rounded = round_float16(values)
    assert rounded.tolist() == [FLOAT16_MAX, -FLOAT16_MAX, float(torch.tensor(0.1).half()), 0.0]
    (rounded * torch.arange(4.0)).sum().backward()
    assert values.grad is not None and values.grad.tolist() == [0, 1, 2, 3]
