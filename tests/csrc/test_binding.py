"""The C++ decoders against their references: the same numbers, the same errors."""

import inspect
import itertools
import random
import re
import struct
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp
from torch.testing import assert_close

from mobilegs.csrc import binding
from mobilegs.errors import InputError
from mobilegs.gaussians import Gaussians
from mobilegs.mgs import bits, positions, rans
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import scenes_equal
from mobilegs.mgs.uniform_streams import join_columns
from mobilegs.render.kernels import cpu
from mobilegs.representation.appearance import OCTAVES, AppearanceDecoder, contract
from mobilegs.representation.codebooks import gather_entries
from mobilegs.representation.lobes import LobeDecoder, LobeShape
from mobilegs.representation.rotations import refinement_bits, refinement_bits_of
from tests.support.codec_inputs import in_morton_order, random_means, skewed_symbols
from tests.support.scene_cases import CASES, make_scene
from tests.support.selection import few

BUILDS = [build for build in binding.BUILDS if binding.BUILDS[build] <= binding.cpu_flags()]


@pytest.fixture(params=[build for build in BUILDS if binding.built_library(build)])
def build(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Decode with each of the libraries that this CPU runs."""
    loaded = cpu.library(request.param)
    monkeypatch.setattr(binding, "decoders", lambda: loaded)


def seeded(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def outcome(decode: Callable[..., Any], *stream: Any) -> tuple[np.ndarray | None, str]:
    """Return the result of a decoder, or else its error message."""
    try:
        return np.asarray(decode(*stream)), ""
    except InputError as error:
        return None, str(error)


def assert_alike(decode: Callable[..., Any], reference: Callable[..., Any], *stream: Any) -> str:
    """Check that both give the same result or the same error; returns its message or ''."""
    expected, sentence = outcome(reference, *stream)
    found, ours = outcome(decode, *stream)
    assert ours == sentence
    if found is not None and expected is not None:
        assert found.tobytes() == expected.tobytes() and found.shape == expected.shape
    return sentence


def rans_alike(data: bytes | memoryview, count: int, alphabet: int) -> str:
    return assert_alike(rans.decode, rans.decode_reference, data, count, alphabet)


def positions_alike(data: bytes | memoryview, count: int) -> str:
    return assert_alike(positions.decode_positions, positions.decode_reference, data, count)


def bits_alike(data: bytes, widths: np.ndarray) -> str:
    def reference(data: bytes, widths: np.ndarray) -> np.ndarray:
        return bits.unpack_bits(data, widths).astype(np.uint16)

    return assert_alike(bits.unpack_short, reference, data, widths)


def damaged(data: st.DataObject, coded: bytes) -> bytes:
    """Change some bytes, or append or remove some."""
    found = bytearray(coded)
    for _ in range(data.draw(st.integers(0, 3))):
        at = data.draw(st.integers(0, len(found) - 1))
        found[at] = data.draw(st.one_of(st.integers(0, 255), st.just(found[at] ^ 1)))
    cut = data.draw(st.integers(-3, 3))
    return bytes(found[:cut]) if cut < 0 else bytes(found) + bytes(cut)


# --- rans


@cache
def coded_symbols(count: int, contextual: bool) -> bytes:
    return rans.encode(skewed_symbols(count, 40), 40, contextual=contextual)


@settings(max_examples=50)
@given(st.data())
def test_symbols_equal_the_reference(data: st.DataObject) -> None:
    contextual = data.draw(st.booleans())
    alphabet = data.draw(st.integers(1, 64 if contextual else 4096))
    count = data.draw(st.integers(0, 300))
    symbols = data.draw(stnp.arrays(np.uint16, count, elements=st.integers(0, alphabet - 1)))
    coded = rans.encode(symbols, alphabet, contextual=contextual)
    assert rans_alike(coded, count, alphabet) == ""
    found = binding.decode_rans(coded, count, alphabet)
    assert found is not None and np.array_equal(found, symbols)


@pytest.mark.parametrize("count", [2047, 4097, 65_535, 600_001])
@pytest.mark.parametrize("contextual", [False, True])
@pytest.mark.usefixtures("build")
def test_symbols_are_decoded_with_every_number_of_lanes(count: int, contextual: bool) -> None:
    symbols = skewed_symbols(count, 49)
    coded = memoryview(b"?" + rans.encode(symbols, 49, contextual=contextual))[1:]  # unaligned
    found = binding.decode_rans(coded, count, 49)
    assert found is not None and np.array_equal(found, symbols)


@pytest.mark.parametrize("count", [0, 1, 2047, 4097, 65_537])
@pytest.mark.parametrize("contextual", [False, True])
@pytest.mark.usefixtures("build")
def test_symbols_are_encoded_as_by_the_reference(
    count: int, contextual: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a symbol that is alone has a frequency of 2^14 and takes no bits
    for symbols in (skewed_symbols(count, 49), np.full(count, 7, dtype=np.uint16)):
        coded = rans.encode(symbols, 49, contextual=contextual)
        with monkeypatch.context() as patch:
            patch.setattr(binding, "encode_rans", lambda *_: None)
            assert coded == rans.encode(symbols, 49, contextual=contextual)


@settings(max_examples=100)
@given(st.data())
def test_damaged_rans_streams_have_the_results_of_the_reference(data: st.DataObject) -> None:
    counts = st.sampled_from([60, 300, 4500, 9000])
    count, contextual = data.draw(counts), data.draw(st.booleans())
    rans_alike(damaged(data, coded_symbols(count, contextual)), count, 40)


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize("contextual", [False, True])
def test_missing_words_and_unused_contexts_have_the_errors_of_the_reference(
    contextual: bool,
) -> None:
    r, count = random.Random(0), 17_000  # eight lanes
    symbols = skewed_symbols(count, 39)
    symbols[count // 8 - 1 :: count // 8] = (
        39  # the last symbol of each lane, so that nothing follows it
    )
    coded = rans.encode(symbols, 40, contextual=contextual)
    alphabet, contexts, table_bytes, words = rans.HEADER.unpack_from(coded)
    heard = set()
    for _ in range(20):
        kept = max(0, words - r.choice([0, 0, 1, 2, 5, 9, r.randrange(words)]))
        head = rans.HEADER.pack(alphabet, contexts, table_bytes, kept)
        changed = bytearray(head + coded[rans.HEADER.size : len(coded) - 2 * (words - kept)])
        for _ in range(r.choice([0, 1, 3])):
            # in tables or states: most bytes there change everything that follows
            at = r.randrange(rans.HEADER.size, rans.HEADER.size + table_bytes + 4 * 8)
            changed[at] ^= 1 << r.randrange(8)
        heard.add(rans_alike(bytes(changed), count, 40))
    assert any("ends early" in sentence for sentence in heard)
    assert not contextual or any("leads to an impossible" in sentence for sentence in heard)


def test_rans_streams_cut_anywhere_have_the_errors_of_the_reference() -> None:
    for contextual in (False, True):
        coded = rans.encode(skewed_symbols(100, 12), 12, contextual=contextual)
        for length in range(len(coded)):
            assert rans_alike(coded[:length], 100, 12)


def stream(tables: str, words: list[int], *, state: int = 1 << 16, head: tuple = (2, 1)) -> bytes:
    """Return a stream of one lane: `tables` are bits, `head` is alphabet and contexts."""
    numbers = np.packbits(np.array(list(tables), dtype=np.uint8), bitorder="little").tobytes()
    start = rans.HEADER.pack(*head, len(numbers), len(words))
    return start + numbers + struct.pack(f"<I{len(words)}H", state, *words)


# both symbols occur: k = 13, the frequency 8192 as 0 zero bits and 13 bits of 8191
EQUAL = "111" + "1011" + "1" + "1" * 13
ONLY_SECOND = "101" + "0000"
BROKEN = {
    "nothing": b"",
    "a header cut short": bytes(11),
    "another alphabet": stream(EQUAL, [], head=(3, 1)),
    "no context": stream(EQUAL, [], head=(2, 0)),
    "three contexts": stream(EQUAL, [], head=(2, 3)),
    "a byte more": stream(EQUAL, []) + b"\0",
    "a length beyond everything": rans.HEADER.pack(2, 1, 2**32 - 1, 2**32 - 1) + bytes(99),
    "no tables": stream("", []),
    "tables that end in zeros": stream("11110000" + "0" * 8, []),
    "tables that end in a number": stream(EQUAL[:16], []),
    "a large k": stream("111" + "1111" + "1" + "1" * 30, []),
    "a long number": stream("111" + "0000" + "0" * 15 + "1" + "1" * 30, []),
    "nothing for the last": stream("111" + "0111" + "01" + "0" * 15, []),
    "more than there is": stream("111" + "0111" + "01" + "1" * 15, []),
    "no symbol": stream("100" + "0000", []),
    "a byte of tables more": stream(EQUAL + "0" * 8, []),
    "a bit of tables more": stream(ONLY_SECOND + "1", []),
    "a state too low": stream(EQUAL, [], state=65535),
    "a state too low that ends as it should": stream(ONLY_SECOND, [0], state=1),
    "no word": stream(EQUAL, []),
    "the first context not used": stream("0", [0, 0, 0]),
    "the first context not used, but an end as it should be": stream("0", [1, 0]),
    "a second context not used": stream(ONLY_SECOND + "0", [7] * 9, head=(2, 2)),
    "the same, but an end as it should be": stream(
        ONLY_SECOND + "0", [0], state=65537, head=(2, 2)
    ),
    "a word left over": stream(ONLY_SECOND, [1]),
    "another state at the end": stream(ONLY_SECOND, [], state=65537),
}


@pytest.mark.usefixtures("build")
def test_broken_rans_streams_have_every_error_of_the_reference() -> None:
    heard = {re.sub(r"\d+", "", rans_alike(data, 2, 2)) for data in BROKEN.values()}
    assert heard == sentences(rans)


def test_messages_are_those_of_the_references() -> None:
    known = sentences(rans) | sentences(bits) | sentences(positions)
    assert {re.sub(r"\d+", "", text) for text in binding.MESSAGES.values()} < known
    header = Path(binding.__file__).with_name("decode.h").read_text()
    numbers = re.findall(r"MGS_[A-Z_]+ = (\d+),", header)
    assert [int(n) for n in numbers] == [0, 1, *binding.MESSAGES, binding.NO_MEMORY]


def sentences(module: ModuleType) -> set[str]:
    """Return the error messages of a module, without numbers."""
    texts = re.findall(r'raise InputError\(\s*f?"(.+?)"', inspect.getsource(module))
    return {re.sub(r"\{\w+\}|\d+", "", text) for text in texts}


# --- bits and positions


@given(st.data())
def test_bits_equal_the_reference(data: st.DataObject) -> None:
    widths = np.array(data.draw(st.lists(st.integers(0, 16), max_size=60)), dtype=np.int64)
    numbers = data.draw(stnp.arrays(np.uint64, len(widths), elements=st.integers(0, 2**16 - 1)))
    numbers &= (np.uint64(1) << widths.astype(np.uint64)) - np.uint64(1)
    packed = bits.pack_bits(numbers, widths)
    assert bits_alike(packed, widths) == ""
    if packed:
        bits_alike(damaged(data, packed), widths)
        bits_alike(packed[:-1] + b"\xff", widths)


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize("count", [1, 2, 60, 9000])
def test_positions_equal_the_reference(count: int) -> None:
    halves = np.random.default_rng(count).integers(0, 1 << 16, (count, 3), dtype=np.uint16)
    halves[(halves & 0x7C00) == 0x7C00] &= 0x83FF
    wild = torch.from_numpy(halves.view(np.float16))
    near = PositionGrid(torch.tensor([1.0, -2.0, 30.0]), 3.7).store(random_means(count))
    for stored in (wild, near, near[:1].expand(count, 3)):
        coded = positions.encode_positions(in_morton_order(stored))
        assert positions_alike(memoryview(b"?" + coded)[1:], count) == ""


@cache
def coded_places(count: int) -> bytes:
    return positions.encode_positions(
        in_morton_order(PositionGrid(torch.zeros(3), 1.0).store(random_means(count)))
    )


@settings(max_examples=100)
@given(st.data())
def test_damaged_positions_have_the_results_of_the_reference(data: st.DataObject) -> None:
    count = data.draw(st.sampled_from([1, 60, 5000]))
    positions_alike(damaged(data, coded_places(count)), count)


def test_broken_positions_cover_every_message() -> None:
    def coded(classes: list[int], rest: list[int]) -> bytes:
        symbols = rans.encode(np.array(classes, dtype=np.uint16), positions.CLASSES)
        widths = np.array([max(c - 1, 0) for c in classes])
        return (
            struct.pack("<I", len(symbols))
            + symbols
            + bits.pack_bits(np.array(rest, dtype=np.uint64), widths)
        )

    highest = (1 << 47) - 1
    broken = {
        "too short": b"\0\0\0",
        "classes beyond the end": struct.pack("<I", 2**32 - 1) + coded([1, 1], [0, 0])[4:],
        "off the grid": coded([48, 48], [0, 0]),
        "off the grid at last": coded([48, 1], [highest, 0]),
        "infinite": coded([48, 0], [highest, 0]),
        "zeros are not finite": coded([0, 0], [0, 0]),
        "not finite, then off the grid": coded([0, 48, 48], [0, highest, 0]),
        "not finite, and bits behind": coded([0, 2], [0, 0])[:-1] + b"\x02",
    }
    counts = {"not finite, then off the grid": 3}
    heard = {
        re.sub(r"\d+", "", positions_alike(data, counts.get(name, 2)))
        for name, data in broken.items()
    }
    assert heard == sentences(positions) | {"packed bits end in bits that are not zero"}
    assert "packed bits take" in positions_alike(coded([5, 9], [3, 3]) + b"\0", 2)
    assert "bits that are not zero" in positions_alike(coded([2, 1], [1, 0])[:-1] + b"\x02", 2)


# --- dequantisation and networks


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize(("books", "size", "length"), [(3, 64, 1), (1, 1, 1), (6, 4096, 2)])
def test_gathered_entries_equal_the_reference(books: int, size: int, length: int) -> None:
    centers = torch.randn(books, size, length, generator=seeded())
    codes = torch.randint(size, (1000, books), generator=seeded(), dtype=torch.int16)
    for rows in (codes, codes[:1], codes.flip(0)[::3]):
        found = binding.gather_entries(centers, rows)
        assert found is not None and torch.equal(found, gather_entries(centers, rows))


def test_indices_out_of_range_are_left_to_the_reference() -> None:
    coded = make_scene(CASES["nothing by direction"])
    books, rows = coded.codebooks["scale"].float(), coded.indices["scale"]
    for stray in (-1, 64):
        rows[-1, -1] = stray
        assert binding.gather_entries(books, rows) is None
    with pytest.raises(IndexError):
        coded.values()


def numbers(*shape: int, seed: int) -> torch.Tensor:
    return torch.randn(*shape, generator=seeded(seed))


@pytest.mark.parametrize("step", [0.0373, 1 / 256, 1e-5, 1e3])
def test_refinement_bits_equal_the_reference(build: None, step: float) -> None:
    step = float(np.float32(step))
    g = seeded()
    codes = torch.randint(-2047, 2048, (70_001, 3), generator=g, dtype=torch.int32)
    codes[0], codes[1] = 2047, torch.tensor([-2047, 2047, -2047])
    near = torch.randint(-90, 91, (20_000, 3), generator=g, dtype=torch.int32)
    for rows in (codes, near, codes[:0], codes[::2]):
        expected = refinement_bits(rows.float() * step).byte()
        assert torch.equal(refinement_bits_of(rows, step), expected)
        # the library does not take int64
        assert torch.equal(refinement_bits_of(rows.long(), step), expected)


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize(("count", "many"), [(0, 3), (1, 12), (1024, 1), (5001, 3)])
def test_joined_columns_equal_the_reference(
    count: int, many: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    draws = np.random.default_rng(0)
    columns = [draws.integers(0, 4096, count, dtype=np.uint16) for _ in range(many)]
    least = [-(1 << 14) - i for i in range(many)]
    expected = np.stack(columns, axis=1).astype(np.int32) + least
    beside = np.full(
        (count, 2 * many), -7, dtype=np.int32
    )  # not contiguous: the library does not take it
    for out in (np.empty((count, many), dtype=np.int32), beside[:, ::2]):
        join_columns(columns, least, out=out)
        assert np.array_equal(out, expected)
    assert (beside[:, 1::2] == -7).all()
    monkeypatch.setattr(binding, "decoders", lambda: None)
    by_reference = np.empty((count, many), dtype=np.int32)
    join_columns(columns, least, out=by_reference)
    assert np.array_equal(by_reference, expected)


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize(("count", "degree"), [(1, 1), (64, 2), (1000, 0), (1000, 3)])
def test_colours_equal_the_reference(degree: int, count: int) -> None:
    decoder = AppearanceDecoder(seeded(), degree)
    decoder.significand_bits = 6 if degree == 2 else 11
    places = numbers(count, 3, seed=1) * torch.logspace(-6, 9, count)[:, None]
    latents = numbers(count, 6, seed=2)
    found = decoder.decode(places, *latents.split(3, dim=1))
    expected = decoder(places, *latents.split(3, dim=1)).detach()
    assert_close(found, expected, atol=5e-6, rtol=1e-5)
    assert torch.equal(decoder.decode(places, *latents.T.contiguous().T.split(3, dim=1)), found)


@pytest.mark.usefixtures("build")
def test_positions_are_contracted_to_the_last_bit() -> None:
    # a network that outputs the highest octave of each axis, where an error of one bit is a third
    # of a degree
    decoder = AppearanceDecoder(seeded(), 0)
    for parameter in decoder.parameters():
        parameter.data.zero_()
    for axis, sign in itertools.product(range(3), (1, -1)):
        unit = 2 * axis + (sign > 0)
        decoder.context1.data[unit, axis * OCTAVES + OCTAVES - 1] = sign
        decoder.context2.data[axis, unit] = sign
        decoder.static1.data[unit, axis] = sign
        decoder.static2.data[axis, unit] = sign / 2
    places = numbers(50_000, 3, seed=5) * torch.logspace(-3, 3, 50_000)[:, None]
    none = torch.zeros_like(places)
    found = decoder.decode(places, none, none)[:, 0]
    turns = contract(places).double() * 2 ** (OCTAVES - 1)
    expected = (turns * torch.pi).sin() * (1 + 0.01) / 2
    assert (found - expected).abs().max() < 1e-6


SHAPES = [
    LobeShape(2, 12, (64,)),
    LobeShape(0, 0),
    LobeShape(0, 1),
    LobeShape(1, 0, (7, 5)),
    LobeShape(3, 32, (16, 1, 256)),
    LobeShape(3, 32, (256, 256, 255)),
]


def some_gaussians(count: int, degree: int) -> Gaussians:
    """Return Gaussians of many proportions, some beyond the range of float32."""
    log_scales = 2 * numbers(count, 3, seed=3)
    quats = numbers(count, 4, seed=4)
    if count > 5:
        log_scales[:5] = torch.tensor([[80.0], [50.0], [-30.0], [-110.0], [44.0]])
        quats[1] = 0
    sh = numbers(count, (degree + 1) ** 2, 3, seed=5)
    return Gaussians(quats[:, 1:], quats, log_scales, numbers(count, seed=6), sh)


@pytest.mark.usefixtures("build")
@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize(
    ("count", "degree", "base"), [(1, 1, True), (130, 0, False), (700, 3, True)]
)
def test_lobes_equal_the_reference(shape: LobeShape, count: int, degree: int, base: bool) -> None:
    decoder = LobeDecoder(shape, seeded())
    for parameter in decoder.parameters():
        parameter.data.copy_(0.3 * torch.randn(parameter.shape, generator=seeded(1)))
    latents, gaussians = numbers(count, shape.latents, seed=2), some_gaussians(count, degree)
    found = decoder.decode(latents, gaussians, base=base)
    expected = decoder(latents, gaussians, base=base).detach()
    assert_close(found, expected, atol=1e-5 * float(expected.abs().max()), rtol=1e-5)


def test_a_gaussian_does_not_depend_on_its_neighbours() -> None:
    # each tile belongs to one thread: then results do not depend on the number of threads either
    gaussians, latents = some_gaussians(1000, 1), numbers(1000, 12, seed=7)
    colors, lobes = AppearanceDecoder(seeded()), LobeDecoder(SHAPES[0], seeded())
    lobes.weights[-1].data.normal_(generator=seeded(8))
    parts = [slice(0, 1), slice(1, 64), slice(64, 129), slice(129, 1000)]

    def shown(rows: slice) -> torch.Tensor:
        some = gaussians.select(rows)
        sh = colors.decode(some.means, latents[rows, :3], latents[rows, 3:6])
        out = lobes.decode(latents[rows], some, base=True)
        return torch.cat([sh.flatten(1), out.flatten(1)], dim=1)

    assert torch.equal(torch.cat([shown(rows) for rows in parts]), shown(slice(None)))


@pytest.mark.parametrize("kind", [torch.float64, torch.float16])
def test_tensors_other_than_float32_go_to_the_reference(kind: torch.dtype) -> None:
    assert binding.supports(torch.zeros(2)) and not binding.supports(
        torch.zeros(2), torch.zeros(1).to(kind)
    )
    assert not binding.supports(torch.zeros(2, device="meta"))


# --- whole files


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """A function that removes the library until the end of the test."""

    def missing() -> None:
        raise binding.LibraryMissingError

    def take() -> None:
        monkeypatch.setattr(binding, "library", missing)
        binding.decoders.cache_clear()

    yield take
    binding.decoders.cache_clear()


@pytest.mark.parametrize("name", few(CASES, "one hidden layer", "scalars", "network"))
def test_files_open_the_same_without_the_library(name: str, alone: Callable[[], None]) -> None:
    data = encode_mgs(make_scene(CASES[name]))
    fast = decode_mgs(data)
    opened = fast.decode()
    alone()
    assert binding.decoders() is None
    plain = decode_mgs(data)
    assert scenes_equal(plain, fast)
    expected = plain.decode()
    for part, value in opened.gaussians.tensors().items():
        assert_close(value, getattr(expected.gaussians, part), atol=1e-5, rtol=1e-5)
    assert (opened.lobes is None) == (expected.lobes is None)
    if opened.lobes is not None and expected.lobes is not None:
        largest = float(expected.lobes.abs().max())
        assert_close(opened.lobes, expected.lobes, atol=1e-5 * largest, rtol=1e-5)


@pytest.mark.parametrize("library", [SimpleNamespace(), SimpleNamespace(mgs_interface=lambda: 0)])
def test_a_library_of_another_version_is_refused(
    library: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(binding.ctypes, "CDLL", lambda path: library)
    with pytest.raises(ImportError, match="another version of mobilegs: reinstall"):
        binding.library.__wrapped__()


@pytest.mark.skipif(sys.platform != "linux", reason="needs Linux")
def test_the_threads_are_those_of_torch() -> None:
    threads = binding.openmp_threads()
    before = torch.get_num_threads()
    try:
        for number in (1, 3):
            torch.set_num_threads(number)
            assert threads() == number
    finally:
        torch.set_num_threads(before)


def test_the_interface_is_that_of_the_header() -> None:
    header = Path(binding.__file__).with_name("decode.h").read_text()
    assert f"#define MGS_INTERFACE {binding.INTERFACE}\n" in header
