"""The presets' codebooks give the sizes that the paper prints."""

from dataclasses import replace

import pytest

from bench.paper.printed_bytes import FIVE, PRINTED, file_mib, readings
from mobilegs.train.recipes import RECIPES


@pytest.mark.parametrize("preset", ["paper", "release"])
def test_the_presets_have_the_printed_sizes(preset: str) -> None:
    codebooks = RECIPES[preset]().student.quantization.codebooks  # pyright: ignore[reportArgumentType]
    for size in (64, 256, 1024):
        assert file_mib(replace(codebooks, appearance=size)) == pytest.approx(
            PRINTED[size], rel=0.05
        )
    assert file_mib(FIVE) < 0.85 * PRINTED[1024]


def test_bytes_of_known_codebooks() -> None:
    sizes = RECIPES["paper"]().student.quantization.codebooks
    # 66 bits of indices; 3 x 64, 2 x 512 x 2 and 3 x 1,024 x 2 numbers
    expected = 470_000 * (18.1 + 0.929 * 66) / 8 + 188_680 + 22_528 + 2 * 8384
    assert file_mib(sizes) * 2**20 == pytest.approx(expected)
    assert [row[0] for row in readings(sizes)] == ["64", "256", "1,024", "4,096"]
