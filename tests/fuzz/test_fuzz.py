"""Some hostile files of each kind; README.md describes the long campaign."""

import json
import random
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply
from mobilegs.formats.spz import read_spz
from mobilegs.mgs import bits, positions, rans
from mobilegs.scene_file import WRITERS
from tests.fuzz.campaign import ONLY_THERE, SEEDS, THERE, Node
from tests.fuzz.mutate import Mutator
from tests.fuzz.mutate_plain import damaged
from tests.fuzz.readers import READERS, Verdict, verdicts
from tests.fuzz.seeds import (
    ROW,
    Seed,
    attributes,
    ply,
    spz_head,
    zipped,
)
from tests.fuzz.seeds_streams import BITS, POSITIONS, RANS, inputs
from tests.support.format_files import encode_compressed_ply, encode_splat
from tests.support.memory_meter import RESET, MemoryMeter
from tests.support.mgs_parts import parse_parts
from tests.support.random_scenes import random_scene

CORPUS = Path(__file__).parent / "corpus"
EXPECTED: dict[str, str | None] = json.loads((CORPUS / "expected.json").read_text())
# of a file each; `make test` tries the first 100
MUTATIONS = {
    "mgs": 700,
    "ply": 1000,
    "spz": 1000,
    "compressed": 1000,
    "splat": 500,
    "sog": 500,
    "glb": 1000,
}
PATIENT = 600.0  # seconds: tests do not fail on busy machines

pytestmark = pytest.mark.skipif(not RESET.exists(), reason="needs Linux")


@pytest.fixture(scope="module")
def seeds() -> dict[str, dict[str, Seed]]:
    return {kind: make() for kind, make in SEEDS.items()}


@pytest.fixture(scope="module")
def node(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Node]:
    process = Node(tmp_path_factory.mktemp("node"), seconds=PATIENT)
    yield process
    process.close()


def compare(kind: str, inputs: list[bytes], node: Node, folder: Path) -> list[str | None]:
    """Return our verdicts; the viewer must agree on each `.mgs`."""
    found: list[str | None] = []
    first = ours(kind, inputs, folder)
    both = zip(first, node.verdicts(kind, inputs) if kind in THERE else first, strict=True)
    for i, (our, their) in enumerate(both):
        assert not isinstance(our, dict), f"input {i}: {our['error']}"
        assert not isinstance(their, dict), f"input {i}, node: {their['error']}"
        if kind == "mgs" and not (our is None and their and ONLY_THERE.search(their)):
            assert (our is None) == (their is None), f"input {i}: '{our}', there '{their}'"
        found.append(our)
    return found


def ours(kind: str, inputs: list[bytes], folder: Path) -> list[Verdict]:
    return verdicts(kind, inputs, folder, seconds=PATIENT)


@pytest.mark.parametrize("kind", MUTATIONS)
def test_mutated_files_are_scenes_or_are_refused(
    kind: str,
    seeds: dict[str, dict[str, Seed]],
    node: Node,
    tmp_path: Path,
    pytestconfig: pytest.Config,
) -> None:
    count = MUTATIONS[kind] if pytestconfig.getoption("--thorough") else 100
    mutator = Mutator(kind, seeds[kind], seed=0)
    found = compare(kind, [mutator.input(i) for i in range(count)], node, tmp_path)
    assert count / 20 < found.count(None) < (count / 2 if kind != "splat" else count)


@pytest.mark.parametrize("kind", SEEDS)
def test_seeds_are_scenes(
    kind: str, seeds: dict[str, dict[str, Seed]], node: Node, tmp_path: Path
) -> None:
    files = [seed.data for seed in seeds[kind].values()]
    assert not any(compare(kind, files, node, tmp_path))


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("mgs", "tiny"),
        ("ply", "big"),
        ("spz", "version 3, degree 1"),
        ("spz", "version 4, degree 0, quick"),
        ("compressed", "degree 1"),
        ("glb", "degree 0"),
    ],
)
def test_a_file_cut_at_any_byte_is_refused(
    kind: str, name: str, seeds: dict[str, dict[str, Seed]], node: Node, tmp_path: Path
) -> None:
    data = seeds[kind][name].data
    assert None not in compare(kind, [data[:end] for end in range(len(data))], node, tmp_path)


@pytest.mark.parametrize("name", EXPECTED)
def test_files_of_the_corpus_are_opened_or_refused_as_expected(
    name: str, node: Node, tmp_path: Path
) -> None:
    data, kind, expected = (CORPUS / name).read_bytes(), name.rpartition(".")[2], EXPECTED[name]
    (found,) = compare(kind, [data], node, tmp_path)
    (theirs,) = node.verdicts(kind, [data])
    assert (found is None) == (theirs is None) == (expected is None)
    assert expected is None or (found is not None and expected in found)


def test_the_corpus_is_complete_and_small() -> None:
    files = [path for path in CORPUS.iterdir() if path.name != "expected.json"]
    assert {path.name for path in files} == EXPECTED.keys()
    assert len(files) <= 60 and all(path.stat().st_size < 2000 for path in files)


# --- C++ against the reference


def by_reference(way: int, stream: bytes, count: int, bound: int) -> np.ndarray | str:
    try:
        if way == BITS:
            return bits.unpack_bits(stream, np.full(count, bound))
        if way == POSITIONS:
            return positions.decode_reference(stream, count).numpy()
        return rans.decode_reference(stream, count, bound)
    except InputError as error:
        return str(error)


def natively(way: int, stream: bytes, count: int, bound: int) -> np.ndarray | str:
    try:
        if way == BITS:
            return bits.unpack_short(stream, np.full(count, bound))
        if way == POSITIONS:
            return positions.decode_positions(stream, count).numpy()
        return rans.decode(stream, count, bound)
    except InputError as error:
        return str(error)


@pytest.mark.skipif(binding.decoders() is None, reason="needs the C++ library")
def test_mutated_streams_have_the_results_of_the_reference(
    seeds: dict[str, dict[str, Seed]],
) -> None:
    r = random.Random(0)
    streams: dict[int, list[bytes]] = {RANS: [], BITS: [], POSITIONS: []}
    for data in inputs(seeds["mgs"]):
        if data[0] in streams and len(data) < 1000:
            streams[data[0]].append(data)
    for way, valid in streams.items():
        taken = 0
        for _ in range(400):
            data = r.choice(valid)
            _, count, bound = struct.unpack_from("<BIH", data)
            stream = data[7:]
            if r.random() < 0.8:
                stream = damaged(r, stream, as_long=r.random() < 0.7)
                count = max(1, count + r.choice([0, 0, 0, 0, 1, -1]))
            expected = by_reference(way, stream, count, bound)
            found = natively(way, stream, count, bound)
            if isinstance(found, str) or isinstance(expected, str):
                assert found == expected
                continue
            assert np.array_equal(found, expected)
            taken += 1
        assert 60 < taken < 340


# --- memory


def peak(read, path: Path) -> int:
    """Return the peak memory of reading a file, which may be refused."""
    meter = MemoryMeter()
    meter.start()
    try:
        read(path)
    except InputError as error:
        print(error)
    return meter.peak()


def test_long_frequency_tables_take_memory_in_proportion_to_the_file(
    seeds: dict[str, dict[str, Seed]], tmp_path: Path
) -> None:
    parts = parse_parts(seeds["mgs"]["scalars"].data)
    piece = parts.piece("scale.1")
    head = struct.unpack_from("<HHII", piece.data)
    tables = bytes(2 << 20)
    piece.data = struct.pack("<HHII", *head[:2], len(tables), head[3]) + tables + piece.data[12:]
    piece.data = piece.data[: 12 + len(tables) + 4 + 2 * head[3]]
    (found,) = ours("mgs", [parts.to_bytes()], tmp_path)
    assert isinstance(found, str), found


def test_many_gaussians_in_few_bytes_stay_within_the_bound(
    seeds: dict[str, dict[str, Seed]], tmp_path: Path
) -> None:
    assert ours("mgs", [seeds["mgs"]["crowd"].data], tmp_path) == [None]


def test_a_spz_that_decompresses_to_too_much_is_refused_in_time(tmp_path: Path) -> None:
    path = tmp_path / "bomb.spz"
    path.write_bytes(zipped(spz_head(3, 5_000_000, 3) + bytes(5_000_000 * 64)))
    assert peak(read_spz, path) < 16 << 20


@pytest.mark.parametrize("degree", [0, 3])
def test_a_spz_takes_at_most_twice_the_scene(degree: int, tmp_path: Path) -> None:
    path, count = tmp_path / "much.spz", 300_000
    content = spz_head(3, count, degree) + b"".join(attributes(3, count, degree))
    zipper = zlib.compressobj(0, wbits=31)
    path.write_bytes(zipper.compress(content) + zipper.flush())
    scene = sum(value.nbytes for value in read_spz(path).tensors().values())
    assert peak(read_spz, path) < 2 * scene + path.stat().st_size + (32 << 20)


@pytest.mark.parametrize("degree", [0, 3])
@pytest.mark.parametrize("kind", ["compressed", "splat", "sog", "glb"])
def test_other_formats_take_at_most_twice_file_and_scene(
    kind: str, degree: int, tmp_path: Path
) -> None:
    path, made = tmp_path / f"much.{kind}", random_scene(60_000, degree)
    if kind == "compressed":
        path.write_bytes(encode_compressed_ply(made))
    elif kind == "splat":
        path.write_bytes(encode_splat(made).tobytes())
    else:
        WRITERS[kind](path, made)
    scene = sum(value.nbytes for value in READERS[kind](path).tensors().values())
    assert peak(READERS[kind], path) < 2 * scene + path.stat().st_size + (24 << 20)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("types", [("double",), ("float",), ("uchar",)])
def test_a_ply_takes_at_most_twice_the_scene(
    kind: str, types: tuple[str, ...], tmp_path: Path
) -> None:
    path = tmp_path / "much.ply"
    names = [*ROW, *(f"f_rest_{i}" for i in range(45))]
    path.write_bytes(ply(kind, names, count=20_000, types=types))
    scene = sum(value.nbytes for value in read_ply(path).tensors().values())
    assert peak(read_ply, path) < 2 * scene + (24 << 20)


def test_rows_with_numbers_beyond_float32_are_dropped(tmp_path: Path) -> None:
    data = ply("ascii", ROW, count=1)[:-1].rsplit(b" ", 1)[0] + b" 1e99\n"
    (tmp_path / "far.ply").write_bytes(data)
    assert len(read_ply(tmp_path / "far.ply")) == 0


@pytest.mark.parametrize("rest", [b"\n" * 3_000_000, b"7 " * 1_500_000, b"7" * 3_000_000])
def test_a_ply_of_many_lines_or_words_takes_memory_in_proportion(
    rest: bytes, tmp_path: Path
) -> None:
    path = tmp_path / "odd.ply"
    path.write_bytes(ply("ascii", ROW, count=2) + rest)
    assert peak(read_ply, path) < 2 * len(rest) + (8 << 20)
    path.write_bytes(ply("ascii", ROW, count=2).replace(b"end_header\n", b"end_header\n" + rest))
    assert peak(read_ply, path) < 4 * len(rest) + (8 << 20)
