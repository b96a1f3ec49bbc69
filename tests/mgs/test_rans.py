"""The entropy coder rANS and packed bits."""

import constriction
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import bit_lengths, pack_bits, unpack_bits
from tests.support.codec_inputs import skewed_symbols


def entropy_bytes(symbols: np.ndarray) -> float:
    counts = np.bincount(symbols)
    shares = counts[counts > 0] / len(symbols)
    return float(-(shares * np.log2(shares)).sum() * len(symbols) / 8)


@settings(deadline=None, max_examples=100)
@given(st.data())
def test_symbols_round_trip(data: st.DataObject) -> None:
    contextual = data.draw(st.booleans())
    alphabet = data.draw(st.integers(1, 64 if contextual else 4096))
    count = data.draw(st.integers(0, 300))
    symbols = data.draw(stnp.arrays(np.uint16, count, elements=st.integers(0, alphabet - 1)))
    coded = rans.encode(symbols, alphabet, contextual=contextual)
    assert np.array_equal(rans.decode(coded, count, alphabet), symbols)


@pytest.mark.parametrize("count", [2047, 2048, 4095, 4096, 4097, 40_000, 600_001])
@pytest.mark.parametrize("contextual", [False, True])
def test_symbols_round_trip_with_every_number_of_lanes(count: int, contextual: bool) -> None:
    symbols = skewed_symbols(count, 49)
    coded = rans.encode(symbols, 49, contextual=contextual)
    assert np.array_equal(rans.decode(coded, count, 49), symbols)


@pytest.mark.parametrize("alphabet", [2, 64, 1024, 4096])
def test_the_size_is_within_half_a_percent_of_the_entropy_and_its_tables(alphabet: int) -> None:
    symbols = skewed_symbols(200_000, alphabet)
    fixed = 1.3 * alphabet + 32 + 4 * rans.lane_count(200_000)
    assert len(rans.encode(symbols, alphabet)) <= 1.005 * entropy_bytes(symbols) + fixed


def test_the_size_matches_constriction() -> None:
    symbols = skewed_symbols(100_000, 300)
    counts = np.bincount(symbols, minlength=300).astype(np.float64)
    stream = constriction.stream  # pyright: ignore[reportAttributeAccessIssue]
    model = stream.model.Categorical(counts / counts.sum(), perfect=False)
    oracle = stream.stack.AnsCoder()
    oracle.encode_reverse(symbols.astype(np.int32), model)
    theirs = 4 * len(oracle.get_compressed())
    assert len(rans.encode(symbols, 300)) == pytest.approx(theirs + 400, rel=0.005)


def test_contexts_save_bytes_if_symbols_depend_on_the_previous_one() -> None:
    random = np.random.default_rng(0)
    steps = random.integers(-1, 2, 50_000)
    symbols = np.abs(np.cumsum(steps) % 40).astype(np.uint16)
    alone = rans.encode(symbols, 40)
    context = rans.encode(symbols, 40, contextual=True)
    assert len(context) < 0.4 * len(alone)
    assert len(context) < 1.05 * 50_000 * np.log2(3) / 8 + 500


def test_a_single_symbol_takes_no_bits() -> None:
    symbols = np.full(100_000, 7, dtype=np.uint16)
    assert len(rans.encode(symbols, 10)) < 20 + 4 * rans.lane_count(100_000)


def test_equal_symbols_give_equal_bytes() -> None:
    assert rans.encode(skewed_symbols(9000, 64), 64) == rans.encode(skewed_symbols(9000, 64), 64)


@settings(deadline=None)
@given(stnp.arrays(np.int64, st.integers(1, 500), elements=st.integers(0, 10**9)))
def test_frequencies_sum_to_the_total_and_are_positive_for_every_symbol(counts: np.ndarray) -> None:
    frequencies = rans.normalise_counts(counts)
    assert frequencies.sum() == (rans.TOTAL if counts.any() else 0)
    assert np.array_equal(frequencies > 0, counts > 0)


def test_frequencies_of_thousands_of_rare_symbols_sum_to_the_total() -> None:
    counts = np.ones(4096, dtype=np.int64)
    counts[0] = 10**12
    frequencies = rans.normalise_counts(counts)
    assert frequencies.sum() == rans.TOTAL and frequencies.min() == 1


@settings(deadline=None, max_examples=80)
@given(st.data())
def test_damaged_streams_are_refused_or_decoded(data: st.DataObject) -> None:
    contextual = data.draw(st.booleans())
    symbols = skewed_symbols(300, 40, seed=data.draw(st.integers(0, 3)))
    coded = bytearray(rans.encode(symbols, 40, contextual=contextual))
    for _ in range(data.draw(st.integers(1, 3))):
        coded[data.draw(st.integers(0, len(coded) - 1))] = data.draw(st.integers(0, 255))
    damaged = bytes(coded[: data.draw(st.integers(len(coded) - 2, len(coded)))])
    try:
        out = rans.decode(damaged, 300, 40)
    except InputError:
        return
    assert out.shape == (300,) and out.max() < 40


def test_most_flipped_bits_are_found_without_a_checksum() -> None:
    symbols = skewed_symbols(2000, 64)
    coded = rans.encode(symbols, 64)
    noticed = 0
    for bit in range(len(coded) * 8 - 4000, len(coded) * 8, 160):
        damaged = bytearray(coded)
        damaged[bit // 8] ^= 1 << bit % 8
        try:
            rans.decode(bytes(damaged), 2000, 64)
        except InputError:
            noticed += 1
    assert noticed == 25


def test_a_wrong_number_of_symbols_is_refused() -> None:
    coded = rans.encode(skewed_symbols(1000, 64), 64)
    for count in (0, 999, 1001, 5000):
        with pytest.raises(InputError):
            rans.decode(coded, count, 64)


def test_another_alphabet_is_refused() -> None:
    with pytest.raises(InputError, match="64"):
        rans.decode(rans.encode(skewed_symbols(10, 64), 64), 10, 65)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 48), st.integers(0, 2**48 - 1)), max_size=200))
def test_bits_round_trip(pairs: list[tuple[int, int]]) -> None:
    widths = np.array([width for width, _ in pairs], dtype=np.int64)
    values = np.array([value % (1 << width) for width, value in pairs], dtype=np.uint64)
    packed = pack_bits(values, widths)
    assert len(packed) == (widths.sum() + 7) // 8
    assert np.array_equal(unpack_bits(packed, widths), values)


def test_the_lowest_bit_comes_first() -> None:
    packed = pack_bits(np.array([1, 0b0110, 0x1FF], np.uint64), np.array([1, 4, 9]))
    assert int.from_bytes(packed, "little") == 1 | 0b0110 << 1 | 0x1FF << 5


@pytest.mark.parametrize("data", [b"", b"\x01\x00", b"\xff"])
def test_packed_bits_of_a_wrong_length_or_tail_are_refused(data: bytes) -> None:
    with pytest.raises(InputError):
        unpack_bits(data, np.array([3, 4]))


@settings(deadline=None)
@given(stnp.arrays(np.uint64, 20, elements=st.integers(0, 2**53 - 1)))
def test_bit_lengths_equal_pythons(values: np.ndarray) -> None:
    assert bit_lengths(values).tolist() == [int(value).bit_length() for value in values]
