"""Damaged and hostile `.mgs` files: refused with a message, in little memory."""

import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect, inspect_mgs, read_mgs
from mobilegs.mgs.container import PREFIX
from mobilegs.mgs.quantized_scene import scenes_equal
from mobilegs.render.project import CLASSIC, Footprint
from tests.support.mgs_parts import Parts, Piece, parse_parts
from tests.support.node import refusals
from tests.support.quantized_scenes import join, split


def test_a_flipped_bit_anywhere_is_refused(data: bytes) -> None:
    header, body = split(data)
    places = [*range(PREFIX.size), *range(0, len(data), 97)]
    start = len(data) - len(body)
    for row in header["streams"]:  # and all of the padding
        end = start + row["bytes"]
        start = end + -row["bytes"] % 8
        places += range(end, start)
    for place in places:
        damaged = bytearray(data)
        damaged[place] ^= 1 << place % 8
        with pytest.raises(InputError):
            decode_mgs(bytes(damaged))


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        (b"", "empty"),
        (b"ply\nformat binary_little_endian 1.0\n", "PLY"),
        (b"PK\x03\x04rest", "zip"),
        (b"\x1f\x8b\x08", "gzip"),
        (b"MGS\x1a\n\x00\x01", "binary mode"),
        (b"MGS\x1a\r", "damaged"),
        (b"something else", "not a .mgs scene"),
    ],
)
def test_foreign_files_are_recognised(start: bytes, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        decode_mgs(start)


def test_only_version_4_has_a_footprint(data: bytes) -> None:
    header, body = split(data)
    footprint = {"blur": 0.1, "antialiased": True, "soft_edge": True}
    found = decode_mgs(join({**header, "footprint": footprint}, body, version=(4, 0)))
    assert found.footprint == Footprint(0.1, antialiased=True, soft_edge=True)
    assert decode_mgs(encode_mgs(found)).footprint == found.footprint
    assert inspect(encode_mgs(found)).get("footprint") == footprint
    for other in (footprint, None, "x"):
        ignored = decode_mgs(join({**header, "footprint": other}, body, version=(2, 1)))
        assert scenes_equal(ignored, decode_mgs(data)) and ignored.footprint == CLASSIC
    with pytest.raises(InputError, match="lacks the field 'footprint'"):
        decode_mgs(join(header, body, version=(4, 0)))
    for name, value in (("blur", 4.1), ("blur", None), ("antialiased", 1), ("soft_edge", "true")):
        wrong = {**header, "footprint": {**footprint, name: value}}
        with pytest.raises(InputError, match=name):
            decode_mgs(join(wrong, body, version=(4, 0)))
    given = {**header, "footprint": footprint, "blend": "sorted"}
    with pytest.raises(InputError, match="cannot have a footprint with a soft edge"):
        decode_mgs(join(given, body, version=(4, 0)))


def test_a_later_minor_version_may_add_fields_and_streams(data: bytes) -> None:
    header, body = split(data)
    extra = b"something new"
    row = {"name": "new", "codec": "new", "bytes": 13, "crc32": zlib.crc32(extra)}
    later = {**header, "new": [1], "streams": [*header["streams"], row]}
    file = join(later, body + extra + bytes(3), version=(2, 7))
    assert scenes_equal(decode_mgs(file), decode_mgs(data))
    row = inspect(file)["streams"][-1]
    assert row["raw_bytes"] is None and not row["used"]


def test_files_that_cannot_be_read_are_refused_by_name(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "bad.mgs").write_bytes(data[:-9])
    for path in (tmp_path / "none.mgs", tmp_path, tmp_path / "bad.mgs"):
        with pytest.raises(InputError, match=str(path)):
            read_mgs(path)
        with pytest.raises(InputError, match=str(path)):
            inspect_mgs(path)


# --- hostile headers with valid checksums; fuzz/ changes fields and streams at random


def test_a_header_that_is_not_utf8_is_refused() -> None:
    text = b"\xff\xfe{}" + bytes(8)
    fixed = struct.pack("<HHI", 2, 0, len(text))
    head = b"MGS\x1a\r\n\x00\x01" + fixed + struct.pack("<I", zlib.crc32(fixed + text))
    with pytest.raises(InputError, match="JSON"):
        decode_mgs(head + text)


DECODERS = {  # messages about the first stream of rows, by its codec
    "rans": "a rANS stream (is longer or shorter than|ends early|does not end where)",
    "bits": "packed bits take more or fewer bytes than they should",
}


@pytest.mark.parametrize("codec", DECODERS)
@pytest.mark.parametrize("count", [300_000, 32])
def test_a_false_count_is_refused_by_the_decoders_in_little_memory(
    data: bytes, codec: str, count: int
) -> None:
    parts = parse_parts(data)
    assert parts.header["count"] == 40
    symbols, widths = np.arange(40, dtype=np.uint16) % 8, np.full(40, 3)
    first = parts.piece("scale.0")
    first.codec = codec
    first.data = (
        rans.encode(symbols, 8) if codec == "rans" else pack_bits(symbols.astype(np.uint64), widths)
    )
    decode_mgs(parts.to_bytes())
    parts.header["count"] = count
    parts.piece("lobes.2").data += bytes(count)  # enough bytes for this count
    crafted = parts.to_bytes()
    with pytest.raises(InputError):
        decode_mgs(crafted)  # what is imported at first use does not count
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=DECODERS[codec]):
            decode_mgs(crafted)
        # the header claims 12 indices and a position per Gaussian
        bound = 2 * (len(crafted) + count * (12 * 2 + 6)) + 100_000
        assert tracemalloc.get_traced_memory()[1] < bound
    finally:
        tracemalloc.stop()


def of_zeros(parts: Parts, count: int) -> Parts:
    """Return a file of `count` Gaussians at one position with a few bytes per column."""
    parts.header["count"] = count
    for book in parts.header["codebooks"].values():
        book["size"] = 1
    for piece in parts.pieces:
        if "." in piece.name:
            piece.codec, piece.data = "bits", b""
    books = parts.header["codebooks"].values()
    numbers = sum(book["count"] * book["length"] for book in books)
    codebooks, positions = parts.piece("codebooks"), parts.piece("positions")
    codebooks.codec, codebooks.data = "raw", bytes(2 * numbers)
    # the first difference is the code of the position, all others are 0
    classes = rans.encode(np.array([48] + (count - 1) * [0], np.uint16), 49)
    positions.data = struct.pack("<I", len(classes)) + classes + struct.pack("<Q", 3 << 45)[:6]
    return parts


def test_bytes_of_unneeded_streams_do_not_count_for_the_number_of_gaussians(
    tmp_path: Path, data: bytes
) -> None:
    few = of_zeros(parse_parts(data), 15_000)
    used = sum(len(piece.data) for piece in few.pieces)
    assert len(decode_mgs(few.to_bytes())) == 15_000 and used > 15_000
    crafted = []
    for name in ("spare", "view-network", "lobes.3", "positions@1", "scale.00"):
        many = of_zeros(parse_parts(data), 60_000)
        many.pieces.insert(0, Piece(name, "raw", bytes(60_000)))
        crafted.append(many.to_bytes())
        for read in (inspect, decode_mgs):
            with pytest.raises(
                InputError, match=r"claims 60000 Gaussians in \d{5} of its \d+ bytes"
            ):
                read(crafted[-1])
    found = refusals(tmp_path, [few.to_bytes(), *crafted])
    assert found[0] is None
    assert all(said and "claims 60000 Gaussians in " in said for said in found[1:])
