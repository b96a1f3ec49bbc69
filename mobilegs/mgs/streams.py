"""Codecs of indices and of float16 numbers; the encoder takes the one with the fewest bytes."""

import struct

import numpy as np
from jaxtyping import UInt16

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits, unpack_short
from mobilegs.mgs.container import Stream


def in_level(name: str, number: int) -> str:
    """Return the name of a stream in the LOD level `number`."""
    return f"{name}@{number}" if number else name


def index_width(size: int) -> int:
    """Return the bits of an index below `size`; 0 if `size` is 1."""
    return (size - 1).bit_length()


def encode_indices(name: str, symbols: UInt16[np.ndarray, "n"], size: int) -> Stream:
    """Encode indices below `size` (1 to 4096) with `rans`, or `bits` of a fixed width."""
    widths = np.full(len(symbols), index_width(size))
    plain = Stream(name, "bits", pack_bits(symbols.astype(np.uint64), widths))
    coded = Stream(name, "rans", rans.encode(symbols, size))
    return min(plain, coded, key=lambda stream: len(stream.data))


def decode_indices(stream: Stream, count: int, size: int) -> UInt16[np.ndarray, "n"]:
    """Decode `count` indices below `size`; InputError if the stream is damaged."""
    if stream.codec == "rans":
        return rans.decode(stream.data, count, size)
    if stream.codec != "bits":
        raise _unknown(stream)
    symbols = unpack_short(stream.data, np.full(count, index_width(size), dtype=np.uint8))
    if symbols.max(initial=0) >= size:
        raise InputError(f"the stream '{stream.name}' holds an index out of range")
    return symbols


def encode_float16(name: str, patterns: UInt16[np.ndarray, "n"]) -> Stream:
    """Encode float16 bit patterns with `halves`, `planes` or `raw`.

    `halves` has the upper bytes as rANS symbols: sign, exponent and the first two fraction bits,
    which have about 5 bits of entropy in trained weights. The lower bytes are noise, unless
    weights were rounded to fewer significant bits: then `planes` codes them with rANS too.
    """
    upper = rans.encode(patterns >> 8, 256)
    lower = (patterns & 255).astype(np.uint8).tobytes()
    start = struct.pack("<I", len(upper)) + upper
    plain = Stream(name, "raw", patterns.astype("<u2").tobytes())
    coded = Stream(name, "halves", start + lower)
    planes = Stream(name, "planes", start + rans.encode(patterns & 255, 256))
    return min(plain, coded, planes, key=lambda stream: len(stream.data))


def decode_float16(stream: Stream, count: int) -> UInt16[np.ndarray, "n"]:
    """Decode `count` float16 bit patterns; InputError if the stream is damaged."""
    data = stream.data
    if stream.codec == "raw":
        if len(data) != 2 * count:
            raise _wrong_length(stream)
        return np.frombuffer(data, dtype="<u2").astype(np.uint16)
    if stream.codec not in ("halves", "planes"):
        raise _unknown(stream)
    if len(data) < 4:
        raise _wrong_length(stream)
    (length,) = struct.unpack_from("<I", data)
    rest = data[4 + length :]
    if 4 + length > len(data) or (stream.codec == "halves" and len(rest) != count):
        raise _wrong_length(stream)
    upper = rans.decode(data[4 : 4 + length], count, 256)
    if stream.codec == "planes":
        return upper << 8 | rans.decode(rest, count, 256)
    return upper << 8 | np.frombuffer(rest, dtype=np.uint8)


def _unknown(stream: Stream) -> InputError:
    return InputError(
        f"the stream '{stream.name}' of the .mgs file uses the unknown codec '{stream.codec}'"
    )


def _wrong_length(stream: Stream) -> InputError:
    return InputError(f"the stream '{stream.name}' of the .mgs file has a wrong length")
