"""The streams of valid `.mgs` files as inputs of the target `fuzz/cpp/decode.cpp`."""

import struct

import numpy as np

from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits
from mobilegs.mgs.positions import CLASSES
from mobilegs.mgs.streams import index_width
from tests.fuzz.seeds import Seed, indices
from tests.support.mgs_parts import parse_parts

RANS, BITS, POSITIONS, FITTED = 0, 1, 2, 128
WIDE = {RANS: 33, POSITIONS: 35}  # the bit 32 allows many numbers
LANES = (8, 16, 32, 64, 128, 256)


def inputs(seeds: dict[str, Seed]) -> list[bytes]:
    """Return the streams of valid files as inputs of the target."""
    found = []
    for seed in seeds.values():
        parts = parse_parts(seed.data)
        coded = indices(parts)
        sizes = parts.header.get("layers", [parts.header["count"]])
        for piece in parts.pieces:
            if piece.name in coded:
                count, size = coded[piece.name]
                way, width = (RANS, size) if piece.codec == "rans" else (BITS, index_width(size))
                found.append(struct.pack("<BIH", way, count, width) + piece.data)
            elif piece.codec == "morton-class":
                count = sizes[int(piece.name.partition("@")[2] or 0)]
                found.append(struct.pack("<BIH", POSITIONS, count, 0) + piece.data)
            elif piece.codec in ("halves", "planes"):
                length = struct.unpack_from("<I", piece.data)[0]
                # the lower bytes tell the count unless they are coded
                count = len(piece.data) - 4 - length if piece.codec == "halves" else 9792
                found.append(struct.pack("<BIH", RANS, count, 256) + piece.data[4 : 4 + length])
    found += [data for lanes in LANES for data in wide(lanes)]
    fitted = [bytes([data[0] | FITTED]) + data[1:] for data in found]
    return list(dict.fromkeys([*found, *fitted]))


def wide(lanes: int) -> list[bytes]:
    """Return streams with this number of lanes and almost only equal numbers."""
    count = 2048 * lanes + 5
    symbols = np.zeros(count, dtype=np.uint16)
    symbols[:: count // 7] = 3
    found = []
    for way, size in ((RANS, 5), (RANS, 300), (POSITIONS, CLASSES)):
        coded = rans.encode(symbols, size)
        if way == POSITIONS:
            lower = np.full(int((symbols == 3).sum()), 2)
            bits = pack_bits(lower.astype(np.uint64), lower)
            coded = struct.pack("<I", len(coded)) + coded + bits
        found.append(struct.pack("<BIH", WIDE[way], count, size) + coded)
    return found
