"""The grid of stored positions, their Morton order, and their codec."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp

from mobilegs.mgs.positions import (
    PositionGrid,
    decode_positions,
    encode_positions,
)
from tests.support.codec_inputs import in_morton_order, random_means

patterns = stnp.arrays(
    np.uint16,
    st.tuples(st.integers(1, 60), st.just(3)),
    elements=st.integers(0, 0xFFFF).filter(lambda bits: bits & 0x7C00 != 0x7C00),
)


def make_grid(exponent: int = 11) -> PositionGrid:
    return PositionGrid(torch.tensor([1.0, -2.0, 30.0]), 3.7, exponent)


@pytest.mark.parametrize("exponent", [0, 11, 14])
def test_rounding_equals_storing_and_reading(exponent: int) -> None:
    grid = make_grid(exponent)
    means = random_means(1000)
    rounded = grid.round(means)
    assert torch.equal(rounded, grid.world(grid.store(means)))
    assert torch.equal(grid.round(rounded), rounded)


def test_the_grid_is_uniform_near_the_centre_and_relative_beyond() -> None:
    grid = PositionGrid(torch.zeros(3), 1.0, 11)
    near = torch.rand(2000, 3, generator=torch.Generator().manual_seed(0)) / 8
    assert (grid.round(near) - near).abs().max() <= 2.0**-14
    far = 100 * near
    assert ((grid.round(far) - far).abs() <= far.abs() * 2.0**-11 + 2.0**-14).all()


def test_gradients_pass_through_the_rounding() -> None:
    means = random_means(5).requires_grad_()
    (make_grid().round(means) * torch.arange(15.0).reshape(5, 3)).sum().backward()
    assert means.grad is not None
    assert torch.equal(means.grad, torch.arange(15.0).reshape(5, 3))


def test_stored_positions_are_finite_and_zero_is_positive() -> None:
    stored = PositionGrid(torch.zeros(3), 1e-3, 0).store(torch.tensor([[1e9, -1e30, -0.0]]))
    assert stored.isfinite().all()
    assert stored.view(torch.int16)[0, 2] == 0


def test_a_grid_around_means_is_centred_on_the_median_and_holds_80_percent() -> None:
    means = random_means(1001)
    grid = PositionGrid.around(means)
    assert torch.equal(grid.center, means.median(dim=0).values)
    inside = (means - grid.center).norm(dim=1) <= grid.radius
    assert 0.79 < inside.float().mean() < 0.81


@settings(deadline=None, max_examples=50)
@given(patterns, st.integers(1, 4))
def test_positions_round_trip_with_duplicates(bits: np.ndarray, copies: int) -> None:
    stored = in_morton_order(torch.from_numpy(np.repeat(bits, copies, axis=0).view(np.float16)))
    decoded = decode_positions(encode_positions(stored), len(stored))
    assert torch.equal(decoded.view(torch.int16), stored.view(torch.int16))


def test_many_positions_take_less_than_half_of_their_bytes() -> None:
    surface = torch.nn.functional.normalize(random_means(50_000), dim=1)
    stored = in_morton_order(PositionGrid(torch.zeros(3), 1.0).store(surface))
    coded = encode_positions(stored)
    assert len(coded) < 3.0 * len(stored)
    assert torch.equal(decode_positions(coded, len(stored)), stored)
