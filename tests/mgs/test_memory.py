"""The memory that opening a `.mgs` takes: at most twice its size and that of its scene."""

import ctypes
from collections.abc import Callable

import pytest

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.representation.lobes import LobeShape
from mobilegs.representation.uniform_quantizer import StepSizes
from tests.support.memory_meter import RESET, MemoryMeter
from tests.support.mgs_parts import Parts, parse_parts
from tests.support.quantized_scenes import tensors
from tests.support.scene_cases import Case, make_scene

pytestmark = [
    pytest.mark.skipif(not RESET.exists(), reason="needs Linux"),
    pytest.mark.skipif(binding.decoders() is None, reason="needs the C++ library"),
]
COUNT = 300_000
FREE = 8 << 20  # bytes in addition: a quarter of the allowance of other formats
SIZES = {"nvq": 2, "sq": 4}  # bytes of an index


@pytest.fixture(scope="module")
def levels_file() -> bytes:
    """A file of mode `sq` with two LOD levels, and elongations as in trained scenes."""
    layers = (COUNT // 5, COUNT - COUNT // 5)
    steps = StepSizes(0.3, 0.5, 0.4, 1.0, 2.0)
    shape = LobeShape(1, 2)
    return encode_mgs(make_scene(Case(COUNT, shape, steps=steps, colors="linear", layers=layers)))


def promised(parts: Parts) -> int:
    """Return the bytes of a scene's rows, by its header."""
    columns = [len(scalar["least"]) for scalar in parts.header.get("scalars", {}).values()]
    columns += [book["count"] for book in parts.header.get("codebooks", {}).values()]
    return parts.header["count"] * (6 + SIZES[parts.header["mode"]] * sum(columns))


def opened(data: bytes) -> str:
    """Open a file within the bound of memory; returns the message of a refusal, or ''."""
    bound = 2 * (len(data) + promised(parse_parts(data))) + FREE
    libc = ctypes.CDLL(None)
    if hasattr(libc, "malloc_trim"):  # memory freed before would hide new memory
        libc.malloc_trim(0)
    meter, refusal = MemoryMeter(), ""
    meter.start()
    try:
        decode_mgs(data)
    except InputError as error:
        refusal = str(error)
    peak = meter.peak()
    print(f"{peak >> 20} of {bound >> 20} MiB: {refusal}")
    assert peak < bound
    return refusal


def test_lod_levels_take_at_most_twice_file_and_scene(levels_file: bytes) -> None:
    parts = parse_parts(levels_file)
    rows = [part for part in tensors(decode_mgs(levels_file)) if len(part) == COUNT]
    assert sum(part.nbytes for part in rows) == promised(parts)
    assert opened(levels_file) == ""


DAMAGES: dict[str, tuple[str, Callable[[bytes], bytes], str]] = {
    "classes of positions": ("positions@1", lambda d: _flipped(d, 2000), "a rANS stream"),
    "the end of positions": ("positions@1", lambda d: d[:-1] + b"\xff", "not zero"),
    "the last word": ("lobes.1@1", lambda d: _flipped(d, -1), "a rANS stream"),
}


def _flipped(data: bytes, at: int) -> bytes:
    changed = bytearray(data)
    changed[at] ^= 1
    return bytes(changed)


@pytest.mark.parametrize("name", DAMAGES)
def test_damaged_lod_levels_are_refused_within_the_same_bound(
    name: str, levels_file: bytes
) -> None:
    stream, damage, sentence = DAMAGES[name]
    parts = parse_parts(levels_file)
    piece = parts.piece(stream)
    piece.data = damage(piece.data)
    assert sentence in opened(parts.to_bytes())
