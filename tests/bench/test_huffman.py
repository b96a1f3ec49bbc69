"""Huffman codes of the indices: counted, against other ways to find the same numbers."""

import math
import re
from collections import Counter

import numpy as np
import pytest

from bench.paper.huffman import code_lengths, huffman_bytes
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from tests.support.scene_cases import CASES, make_scene


def test_the_known_example() -> None:
    """Of Cormen, Leiserson, Rivest and Stein, Introduction to Algorithms: 224,000 bits."""
    lengths = code_lengths(np.array([45, 13, 12, 16, 9, 5]))
    assert lengths.tolist() == [1, 3, 3, 3, 4, 4]


def bits_of_merges(symbols: list[int]) -> int:
    """Return the bits of a Huffman code: the sum of the counts of all merged pairs."""
    counts, total = sorted(Counter(symbols).values()), 0
    while len(counts) > 1:
        merged = counts.pop(0) + counts.pop(0)
        total += merged
        counts = sorted([*counts, merged])
    return total


@pytest.mark.parametrize("name", ["layers of scalars", "the paper's"])
def test_the_bytes_of_a_scene_are_those_of_its_streams(name: str) -> None:
    data = encode_mgs(make_scene(CASES[name]))
    scene, found = decode_mgs(data), huffman_bytes(decode_mgs(data))
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
