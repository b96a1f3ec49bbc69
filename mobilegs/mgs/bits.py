"""Integers packed into bits, lowest bit first, vectorised over the numbers."""

import numpy as np
from jaxtyping import Int, Integer, UInt8, UInt16, UInt64

from mobilegs.csrc import binding
from mobilegs.errors import InputError


def pack_bits(values: UInt64[np.ndarray, "n"], widths: Int[np.ndarray, "n"]) -> bytes:
    """Pack the lowest `widths[i]` bits (0 to 48) of each value, consecutively.

    Each value must fit its width. Bit j of the stream is bit `j % 8` of byte `j // 8`; the rest of
    the last byte is 0.
    """
    ends = np.cumsum(widths, dtype=np.int64)
    if len(ends) == 0:
        return b""
    starts = ends - widths
    shift = (starts & 63).astype(np.uint64)
    low = values << shift
    high = (values >> np.uint64(1)) >> (np.uint64(63) - shift)  # bits of the next word
    word = starts >> 6
    first = np.flatnonzero(np.diff(word, prepend=-1))  # `word` is sorted: a run is one word
    words = np.zeros(int(ends[-1]) // 64 + 2, dtype=np.uint64)
    words[word[first]] |= np.bitwise_or.reduceat(low, first)
    words[word[first] + 1] |= np.bitwise_or.reduceat(high, first)
    return words.astype("<u8").tobytes()[: (int(ends[-1]) + 7) // 8]


def unpack_bits(
    data: bytes | memoryview, widths: Integer[np.ndarray, "n"]
) -> UInt64[np.ndarray, "n"]:
    """Unpack what `pack_bits` packed.

    Raises InputError if the length of `data` does not match the widths, or it ends in bits that are
    not 0.
    """
    ends = np.cumsum(widths, dtype=np.int64)
    total = int(ends[-1]) if len(ends) else 0
    if len(data) != (total + 7) // 8:
        raise InputError("packed bits take more or fewer bytes than they should")
    if total % 8 and data[-1] >> total % 8:
        raise InputError("packed bits end in bits that are not zero")
    words = np.frombuffer(bytes(data) + bytes(16 - len(data) % 8), dtype="<u8").astype(np.uint64)
    starts = ends - widths
    shift = (starts & 63).astype(np.uint64)
    word = starts >> 6
    low = words[word] >> shift
    high = (words[word + 1] << np.uint64(1)) << (np.uint64(63) - shift)
    mask = (np.uint64(1) << widths.astype(np.uint64)) - np.uint64(1)
    return (low | high) & mask


def unpack_short(
    data: bytes | memoryview, widths: Integer[np.ndarray, "n"]
) -> UInt16[np.ndarray, "n"]:
    """Run `unpack_bits` for widths of at most 16 bits, in little memory."""
    numbers = binding.unpack_short(data, widths)
    return unpack_bits(data, widths).astype(np.uint16) if numbers is None else numbers


def bit_lengths(values: UInt64[np.ndarray, "n"]) -> UInt8[np.ndarray, "n"]:
    """Return the bit length of each value below 2^53: 0 for 0, otherwise floor(log2) + 1."""
    return np.frexp(values.astype(np.float64))[1].astype(np.uint8)
