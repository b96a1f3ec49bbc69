"""Huffman codes of the indices: counted, against other ways to find the same numbers."""

import math
import re
from collections import Counter
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.paper.huffman import code_lengths, huffman_bytes
from mobilegs.mgs.codec import inspect, pack, unpack
from tests.support.scene_cases import CASES, make_scene

COUNTS = st.lists(st.integers(0, 10**6), min_size=1, max_size=300).filter(any).map(np.array)


def test_the_known_example() -> None:
    """Of Cormen, Leiserson, Rivest and Stein, Introduction to Algorithms: 224,000 bits."""
    lengths = code_lengths(np.array([45, 13, 12, 16, 9, 5]))
    assert lengths.tolist() == [1, 3, 3, 3, 4, 4]


def test_a_symbol_that_occurs_alone_takes_no_bits() -> None:
    assert code_lengths(np.array([0, 7, 0])).tolist() == [0, 0, 0]


@settings(deadline=None)
@given(COUNTS)
def test_lengths_are_those_of_a_complete_code_within_a_bit_of_the_entropy(
    counts: np.ndarray,
) -> None:
    lengths, used = code_lengths(counts), counts > 0
    assert not lengths[~used].any()
    assert sum(2.0 ** -int(length) for length in lengths[used]) == 1  # Kraft
    shares = counts[used] / counts.sum()
    entropy = -(shares * np.log2(shares)).sum()
    assert entropy - 1e-9 <= shares @ lengths[used] < entropy + 1


@settings(deadline=None, max_examples=30)
@given(st.lists(st.integers(1, 50), min_size=2, max_size=5).map(np.array))
def test_no_prefix_code_has_fewer_bits(counts: np.ndarray) -> None:
    """Try all lengths that satisfy the inequality of Kraft."""
    every = product(range(1, len(counts)), repeat=len(counts))
    codes = (lengths for lengths in every if sum(2.0**-length for length in lengths) <= 1)
    fewest = min(sum(counts * lengths) for lengths in codes)
    assert counts @ code_lengths(counts) == fewest


def bits_of_merges(symbols: list[int]) -> int:
    """Return the bits of a Huffman code: the sum of the counts of all merged pairs."""
    counts, total = sorted(Counter(symbols).values()), 0
    while len(counts) > 1:
        merged = counts.pop(0) + counts.pop(0)
        total += merged
        counts = sorted([*counts, merged])
    return total


@pytest.mark.parametrize("name", ["network", "scalars", "layers", "the paper's"])
def test_the_bytes_of_a_scene_are_those_of_its_streams(name: str) -> None:
    data = pack(make_scene(CASES[name]))
    scene, found = unpack(data), huffman_bytes(unpack(data))
    rows = {row["name"]: row for row in inspect(data)["streams"]}
    assert set(found) == {stream for stream in rows if "." in stream}
    for stream, size in found.items():
        match = re.fullmatch(r"(\w+)\.(\d+)@?(\d*)", stream)
        assert match
        attribute, column, level = match.groups()
        codes = scene.indices[attribute]  # pyright: ignore[reportArgumentType]
        if scene.step_sizes and attribute == "rotation":
            codes = scene.cells
        codes = codes[:, int(column)]
        alphabet = int(codes.max() - codes.min()) + 1
        if not scene.step_sizes:
            alphabet = scene.codebooks[attribute].shape[1]  # pyright: ignore[reportArgumentType]
        symbols = codes[scene.lod_slices()[int(level or 0)]].tolist()
        bits, longest = bits_of_merges(symbols), math.log2(len(set(symbols)))
        tables = [8 + alphabet * width for width in range(6) if 2**width > longest]
        assert 8 * size in [-(-(table + bits) // 8) * 8 for table in tables]
