"""Fuzz the C++ decoders with libFuzzer: `python -m tests.fuzz.decoders`, see README.md."""

import argparse
import os
import struct
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from mobilegs.mgs import rans
from mobilegs.mgs.bits import pack_bits
from mobilegs.mgs.positions import CLASSES
from mobilegs.mgs.streams import index_width
from tests.fuzz.seeds import Seed, indices, mgs_seeds
from tests.support.mgs_parts import parse_parts

HERE = Path(__file__).parent
SOURCES = [HERE / "decode_fuzzer.cpp", HERE / "../../mobilegs/csrc/decode.cpp"]
SANITIZE = ["-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=undefined"]
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path(tempfile.gettempdir()) / "fuzz-decode")
    options = parser.parse_args()
    corpus, target = options.output / "corpus", options.output / "decode_fuzzer"
    corpus.mkdir(parents=True, exist_ok=True)
    for i, data in enumerate(inputs(mgs_seeds())):
        (corpus / f"seed-{i}").write_bytes(data)
    os.nice(10)
    build = ["clang++", "-std=c++17", "-O2", "-g", *SANITIZE, *SOURCES, "-o", target]
    subprocess.run(build, check=True)
    # 557,056 positions are 3.2 MiB, tables take 3 MiB
    limits = ["-malloc_limit_mb=4", "-rss_limit_mb=1024", "-timeout=20", "-max_len=20000"]
    # the output is at most one line per second; findings are written to the folder
    command = [target, f"-runs={options.runs}", f"-seed={options.seed}", *limits, corpus]
    # a large quarantine gives every input new memory, which would take most of the time
    calm = {**os.environ, "ASAN_OPTIONS": "quarantine_size_mb=8"}
    subprocess.run(command, check=True, cwd=options.output, env=calm)


if __name__ == "__main__":
    main()
