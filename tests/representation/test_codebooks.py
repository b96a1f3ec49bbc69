"""Sub-vector codebooks."""

from dataclasses import replace

import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.representation.codebooks import CodebookSizes, SubVectorCodebooks, canonical_quats
from mobilegs.representation.float16 import FLOAT16_MAX, round_float16


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


@pytest.fixture
def values() -> torch.Tensor:
    return torch.randn(400, 6, generator=seeded())


@pytest.fixture
def books(values: torch.Tensor) -> SubVectorCodebooks:
    return SubVectorCodebooks.fit(values, length=2, size=32, generator=seeded())


def test_decoding_looks_each_sub_vector_up(books: SubVectorCodebooks) -> None:
    row = books()[7]
    parts = [books.centers[s, books.indices[7, s]].half().float() for s in range(3)]
    assert torch.equal(row, torch.cat(parts))


def test_selected_rows_equal_rows_of_the_whole(books: SubVectorCodebooks) -> None:
    rows = torch.tensor([5, 5, 399, 0])
    assert torch.equal(books(rows), books()[rows])
    mask = torch.arange(400) % 3 == 0
    assert torch.equal(books(mask), books()[mask])
    assert books(slice(0, 0)).shape == (0, 6)


def test_more_entries_mean_less_error(values: torch.Tensor) -> None:
    errors = [
        (SubVectorCodebooks.fit(values, length=2, size=k, generator=seeded())() - values)
        .square()
        .mean()
        for k in (4, 16, 64, 400)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-6  # an entry for every row: only the rounding to halves is left


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


def test_entries_learn(books: SubVectorCodebooks, values: torch.Tensor) -> None:
    target = values + 0.3
    optimizer = torch.optim.Adam(books.parameters(), lr=0.02)
    before = (books() - target).square().mean()
    for _ in range(30):
        optimizer.zero_grad()
        (books() - target).square().mean().backward()
        optimizer.step()
    assert (books() - target).square().mean() < before - 0.08


def test_reassigning_follows_changed_values(
    books: SubVectorCodebooks, values: torch.Tensor
) -> None:
    before = (books() - (values + 0.5)).square().mean()
    books.reassign(values + 0.5)
    assert (books() - (values + 0.5)).square().mean() < before


def test_selecting_drops_rows_and_keeps_the_entries(books: SubVectorCodebooks) -> None:
    whole = books().detach()
    keep = torch.arange(400) % 2 == 1
    books.select(keep)
    assert torch.equal(books(), whole[keep])


def test_a_saved_state_restores_the_same_values(books: SubVectorCodebooks) -> None:
    state = books.state_dict()
    other = SubVectorCodebooks(torch.zeros(3, 32, 2), torch.zeros(400, 3, dtype=torch.int64))
    other.load_state_dict(state)
    assert torch.equal(other(), books())


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


@pytest.mark.parametrize("sizes", [{"scale": 0}, {"appearance": 4097}])
def test_codebook_sizes_out_of_range_are_refused(sizes: dict[str, int]) -> None:
    with pytest.raises(InputError, match="codebook"):
        replace(CodebookSizes(), **sizes)
