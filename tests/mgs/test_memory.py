"""The memory that opening a `.mgs` takes: at most twice its size and that of its scene."""

import ctypes
import struct
import time
from collections.abc import Callable

import numpy as np
import pytest

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.positions import CLASSES
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
    "positions too long": ("positions@1", lambda d: d + b"\0", "more or fewer bytes"),
    "refinement bits too short": ("rotation-finer@1", lambda d: d[:-1], "more or fewer bytes"),
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


# --- small files that claim much


def crowd(parts: Parts, count: int) -> bytes:
    """Return a file of `count` equal Gaussians at positions that are not finite.

    Only unneeded words make it long. The error is in the last stream, so that decoders run over
    all Gaussians before they find it.
    """
    one_symbol = np.packbits([1, 1] + 52 * [0], bitorder="little").tobytes()
    head = rans.HEADER.pack(CLASSES, 1, len(one_symbol), 0)
    classes = head + one_symbol + struct.pack("<I", 1 << 16) * rans.lane_count(count)
    parts.header["count"] = count
    parts.piece("positions").data = struct.pack("<I", len(classes)) + classes
    for scalar in parts.header.get("scalars", {}).values():
        alone = {"least": 0, "size": 1, "middle": 0}
        scalar |= {key: [value] * len(scalar[key]) for key, value in alone.items()}
    books = parts.header.get("codebooks", {}).values()
    for book in books:
        book["size"] = 1
    for piece in parts.pieces:
        if piece.name == "codebooks":
            numbers = sum(book["count"] * book["length"] for book in books)
            piece.codec, piece.data = "raw", bytes(2 * numbers)
        elif "." in piece.name or piece.name == "rotation-finer":
            piece.codec, piece.data = "bits", b""
    last = parts.piece("opacity.0")
    one_index = rans.HEADER.pack(1, 1, 1, count // 2) + b"\3"
    states = struct.pack("<I", 1 << 16) * rans.lane_count(count)
    last.codec, last.data = "rans", one_index + states + bytes(count)
    return parts.to_bytes()


@pytest.mark.parametrize("mode", ["sq", "nvq"])
def test_many_gaussians_in_a_small_file_are_refused_within_the_bound_and_quickly(mode: str) -> None:
    steps = StepSizes() if mode == "sq" else None
    small = encode_mgs(make_scene(Case(50, steps=steps, colors="linear" if steps else "networks")))
    data = crowd(parse_parts(small), 2_000_000)
    begun = time.process_time()
    assert opened(data) == "a rANS stream does not end where it should: the file is damaged"
    assert time.process_time() - begun < 5  # a tenth of that, on an idle machine
