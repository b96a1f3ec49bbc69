"""The memory that readers take: at most twice file and scene, and a constant."""

import re
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fuzz.inputs import seeds
from fuzz.readers import READERS, Reader
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.ply_compressed import CHUNK
from mobilegs.formats.spz import read_spz
from mobilegs.scene_file import WRITERS
from tests.support.memory_meter import RESET, MemoryMeter
from tests.support.mgs_parts import parse_parts
from tests.support.random_scenes import random_scene

PATIENT = 600.0
OTHERS = Path(__file__).parents[1] / "formats" / "other_tools"
ROW = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
TYPES = {"float": "<f4", "double": "<f8", "half": "<f2"}

pytestmark = pytest.mark.skipif(not RESET.exists(), reason="needs Linux")


def peak(read, path: Path) -> int:
    """Return the peak memory of reading a file, which may be refused."""
    meter = MemoryMeter()
    meter.start()
    try:
        read(path)
    except InputError as error:
        print(error)
    return meter.peak()


def ply(kind: str, names: Sequence[str], count: int, type_: str = "float") -> bytes:
    """Return a `.ply` of two computed rows that alternate."""
    properties = "".join(f"property {type_} {name}\n" for name in names)
    head = f"ply\nformat {kind} 1.0\nelement vertex {count}\n{properties}end_header\n"
    table = 3 * np.abs(np.sin(np.arange(2 * len(names), dtype=float))).reshape(2, -1)
    text = "".join(" ".join(f"{x:.6g}" for x in row) + "\n" for row in table).encode()
    rows = text if kind == "ascii" else table.astype(TYPES[type_]).tobytes()
    return head.encode() + rows * (count // 2)


def spz(count: int, degree: int, content: bytes, level: int) -> bytes:
    """Return a `.spz` of version 3, compressed at a level of gzip."""
    zipper = zlib.compressobj(level, wbits=31)
    head = b"NGSP" + struct.pack("<IIBBBB", 3, count, degree, 12, 0, 0)
    return zipper.compress(head + content) + zipper.flush()


def test_long_frequency_tables_take_memory_in_proportion_to_the_file(tmp_path: Path) -> None:
    parts = parse_parts(seeds("mgs")["scalars"])
    piece = parts.piece("scale.1")
    head = struct.unpack_from("<HHII", piece.data)
    tables = bytes(2 << 20)
    piece.data = struct.pack("<HHII", *head[:2], len(tables), head[3]) + tables + piece.data[12:]
    piece.data = piece.data[: 12 + len(tables) + 4 + 2 * head[3]]
    (found,) = Reader("mgs", tmp_path, PATIENT).verdicts([parts.to_bytes()])
    assert isinstance(found, str), found


def test_many_gaussians_in_few_bytes_stay_within_the_bound(tmp_path: Path) -> None:
    assert Reader("mgs", tmp_path, PATIENT).verdicts([seeds("mgs")["crowd"]]) == [None]


def test_a_spz_that_decompresses_to_too_much_is_refused_in_time(tmp_path: Path) -> None:
    path = tmp_path / "bomb.spz"
    path.write_bytes(spz(1_000_000, 3, bytes(1_000_000 * 64), level=1))
    assert peak(read_spz, path) < 16 << 20


def test_a_spz_takes_at_most_twice_the_scene(tmp_path: Path) -> None:
    path, count = tmp_path / "much.spz", 300_000
    row = 9 + 1 + 3 + 3 + 4 + 45
    path.write_bytes(spz(count, 3, bytes(i % 251 for i in range(row)) * count, level=0))
    scene = sum(value.nbytes for value in read_spz(path).tensors().values())
    assert peak(read_spz, path) < 2 * scene + path.stat().st_size + (32 << 20)


def compressed(times: int) -> bytes:
    """Return the twelve Gaussians of a compressed `.ply` of splat-transform, repeated."""
    head, end, body = (OTHERS / "theirs.compressed.ply").read_bytes().partition(b"end_header\n")
    chunks = -(-12 * times // CHUNK)
    head = re.sub(rb"(vertex|sh) 12\n", rb"\1 %d\n" % (12 * times), head)
    head = head.replace(b"chunk 1\n", b"chunk %d\n" % chunks)
    return head + end + chunks * body[:72] + times * body[72:264] + times * body[264:]


@pytest.mark.parametrize("kind", ["compressed", "splat", "sog", "glb"])
def test_other_formats_take_at_most_twice_file_and_scene(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"much.{kind}"
    if kind == "compressed":
        path.write_bytes(compressed(5000))
    elif kind == "splat":
        path.write_bytes((OTHERS / "rows.splat").read_bytes() * 5000)
    else:
        WRITERS[kind](path, random_scene(60_000, 3))
    scene = sum(value.nbytes for value in READERS[kind](path).tensors().values())
    assert peak(READERS[kind], path) < 2 * scene + path.stat().st_size + (24 << 20)


@pytest.mark.parametrize(
    ("kind", "type_"),
    [("ascii", "double"), ("ascii", "half"), *(("binary_little_endian", each) for each in TYPES)],
)
def test_a_ply_takes_at_most_twice_the_scene(kind: str, type_: str, tmp_path: Path) -> None:
    path = tmp_path / "much.ply"
    path.write_bytes(ply(kind, [*ROW, *(f"f_rest_{i}" for i in range(45))], 20_000, type_))
    scene = sum(value.nbytes for value in read_ply(path).tensors().values())
    assert peak(read_ply, path) < 2 * scene + (24 << 20)


@pytest.mark.parametrize("rest", [b"\n" * 3_000_000, b"7 " * 1_500_000, b"7" * 3_000_000])
def test_a_ply_of_many_lines_or_words_takes_memory_in_proportion(
    rest: bytes, tmp_path: Path
) -> None:
    path, data = tmp_path / "odd.ply", ply("ascii", ROW, 2)
    path.write_bytes(data + rest)
    assert peak(read_ply, path) < 2 * len(rest) + (8 << 20)
    path.write_bytes(data.replace(b"end_header\n", b"end_header\n" + rest))
    assert peak(read_ply, path) < 4 * len(rest) + (8 << 20)
