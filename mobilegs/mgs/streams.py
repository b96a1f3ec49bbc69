"""The codecs of single streams, and the choice between them: whichever takes fewer bytes."""

import struct

import numpy as np
from jaxtyping import UInt16

from mobilegs.errors import InputError
from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits, unpack_short
from mobilegs.mgs.container import Stream


def index_width(size: int) -> int:
    """Bits of an index into `size` entries: 0 if there is but one."""
    return (size - 1).bit_length()


def encode_indices(name: str, symbols: UInt16[np.ndarray, "n"], size: int) -> Stream:
    """Indices below `size` (1 to 4096): `rans`, or `bits` of fixed width."""
    widths = np.full(len(symbols), index_width(size))
    plain = Stream(name, "bits", pack_bits(symbols.astype(np.uint64), widths))
    coded = Stream(name, "rans", rans.encode(symbols, size))
    return min(plain, coded, key=lambda stream: len(stream.data))


def decode_indices(stream: Stream, count: int, size: int) -> UInt16[np.ndarray, "n"]:
    """The indices in a stream; InputError if it is damaged or one is too large."""
    if stream.codec == "rans":
        return rans.decode(stream.data, count, size)
    if stream.codec != "bits":
        raise _unknown(stream)
    symbols = unpack_short(stream.data, np.full(count, index_width(size), dtype=np.uint8))
    if symbols.max(initial=0) >= size:
        raise InputError(f"the stream '{stream.name}' points outside of its codebook")
    return symbols


def encode_halves(name: str, halves: UInt16[np.ndarray, "n"]) -> Stream:
    """Bit patterns of halves: `halves` (the upper bytes as rANS symbols), `planes` or `raw`.

    Sign, exponent and the first two digits are worth about 5 of their 8 bits in trained
    weights; the rest is noise, unless it was rounded away: then `planes` has the lower bytes as
    rANS symbols, too.
    """
    upper = rans.encode(halves >> 8, 256)
    lower = (halves & 255).astype(np.uint8).tobytes()
    start = struct.pack("<I", len(upper)) + upper
    plain = Stream(name, "raw", halves.astype("<u2").tobytes())
    coded = Stream(name, "halves", start + lower)
    planes = Stream(name, "planes", start + rans.encode(halves & 255, 256))
    return min(plain, coded, planes, key=lambda stream: len(stream.data))


def decode_halves(stream: Stream, count: int) -> UInt16[np.ndarray, "n"]:
    """The `count` halves in a stream; InputError if it is damaged."""
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
        f"the stream '{stream.name}' of the .mgs file uses the codec '{stream.codec}', which "
        "this program does not know"
    )


def _wrong_length(stream: Stream) -> InputError:
    return InputError(f"the stream '{stream.name}' of the .mgs file has a wrong length")
