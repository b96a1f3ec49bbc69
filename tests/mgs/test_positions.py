"""The grid of stored positions, their Morton order, and their codec."""

import struct

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits
from mobilegs.mgs.positions import (
    PositionGrid,
    decode_positions,
    encode_positions,
    float16_to_ordered,
    morton_codes,
    ordered_to_float16,
    positions_from_morton,
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


def test_a_world_position_has_two_float32_roundings() -> None:
    grid = make_grid()
    stored = grid.store(random_means(50))
    expected = [
        [np.float32(c) + np.float32(grid.radius) * np.float32(float(p) * 2**11)
         for c, p in zip(grid.center.tolist(), row, strict=True)]
        for row in stored
    ]  # fmt: skip
    assert grid.world(stored).tolist() == [[float(value) for value in row] for row in expected]


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


def test_a_grid_around_one_mean_is_valid() -> None:
    point = torch.tensor([[1.0, 2.0, 3.0]])
    assert torch.equal(PositionGrid.around(point).round(point), point)


def test_ordered_numbers_sort_like_the_float16_values() -> None:
    bits = np.arange(0x10000, dtype=np.uint32).astype(np.uint16)
    assert np.array_equal(ordered_to_float16(float16_to_ordered(bits)), bits)
    finite = bits[(bits & 0x7C00) != 0x7C00]
    values = finite.view(np.float16)[np.argsort(float16_to_ordered(finite), kind="stable")]
    assert (np.diff(values.astype(np.float64)) >= 0).all()


@settings(deadline=None, max_examples=40)
@given(patterns)
def test_morton_codes_interleave_bits_with_x_lowest(bits: np.ndarray) -> None:
    stored = torch.from_numpy(bits.view(np.float16))
    numbers = float16_to_ordered(bits)
    slow = [
        sum((int(number) >> b & 1) << 3 * b + a for b in range(16) for a, number in enumerate(row))
        for row in numbers
    ]
    codes = morton_codes(stored)
    assert codes.tolist() == slow
    assert torch.equal(positions_from_morton(codes).view(torch.int16), stored.view(torch.int16))


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


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_damaged_positions_are_refused_or_finite(data: st.DataObject) -> None:
    coded = bytearray(encode_positions(in_morton_order(make_grid().store(random_means(60)))))
    coded[data.draw(st.integers(0, len(coded) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    try:
        decoded = decode_positions(bytes(coded), 60)
    except InputError:
        return
    assert decoded.shape == (60, 3) and decoded.isfinite().all()


@pytest.mark.parametrize("code", [(1 << 48) - 1, 0])
def test_positions_that_are_not_finite_are_refused(code: int) -> None:
    infinite = positions_from_morton(np.array([code], dtype=np.uint64))
    assert not infinite.isfinite().any()
    with pytest.raises(InputError, match="finite"):
        decode_positions(encode_positions(infinite), 1)


def test_codes_beyond_48_bits_are_refused() -> None:
    classes = rans.encode(np.array([48, 48], dtype=np.uint16), 49)  # twice at least 2^47
    mantissas = pack_bits(np.zeros(2, dtype=np.uint64), np.array([47, 47]))
    with pytest.raises(InputError, match="grid"):
        decode_positions(struct.pack("<I", len(classes)) + classes + mantissas, 2)
