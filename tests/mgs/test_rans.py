"""The entropy coder rANS and packed bits."""

import constriction
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import unpack_bits
from tests.support.codec_inputs import skewed_symbols


@settings(deadline=None, max_examples=100)
@given(st.data())
def test_symbols_round_trip(data: st.DataObject) -> None:
    contextual = data.draw(st.booleans())
    alphabet = data.draw(st.integers(1, 64 if contextual else 4096))
    count = data.draw(st.integers(0, 300))
    symbols = data.draw(stnp.arrays(np.uint16, count, elements=st.integers(0, alphabet - 1)))
    coded = rans.encode(symbols, alphabet, contextual=contextual)
    assert np.array_equal(rans.decode(coded, count, alphabet), symbols)


@pytest.mark.parametrize(
    ("count", "contextual"), [(2047, True), (2048, False), (4097, True), (40_000, False)]
)
def test_symbols_round_trip_with_every_number_of_lanes(count: int, contextual: bool) -> None:
    symbols = skewed_symbols(count, 49)
    coded = rans.encode(symbols, 49, contextual=contextual)
    assert np.array_equal(rans.decode(coded, count, 49), symbols)


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


def test_a_wrong_number_of_symbols_or_another_alphabet_is_refused() -> None:
    coded = rans.encode(skewed_symbols(1000, 64), 64)
    for count in (0, 999, 1001, 5000):
        with pytest.raises(InputError):
            rans.decode(coded, count, 64)
    with pytest.raises(InputError, match="64"):
        rans.decode(coded, 1000, 65)


@pytest.mark.parametrize("data", [b"", b"\x01\x00", b"\xff"])
def test_packed_bits_of_a_wrong_length_or_tail_are_refused(data: bytes) -> None:
    with pytest.raises(InputError):
        unpack_bits(data, np.array([3, 4]))
