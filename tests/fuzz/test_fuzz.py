"""The targets of `fuzz/` without clang and atheris: their seeds, their corpus, some mutations."""

import contextlib
import random
import shutil
import struct
import subprocess
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

import fuzz.compiled as compiled
from fuzz.__main__ import HELP, HERE, TARGETS, missing
from fuzz.agreement import ONLY_THERE, Agreement, decoded, difference, reference
from fuzz.captures import KINDS as CAPTURE_KINDS
from fuzz.captures import reader_of
from fuzz.findings import Findings
from fuzz.inputs import CORPUS, EXPECTED, KINDS, VIEWER_KINDS, corpus, seeds, short_seeds
from fuzz.javascript import loop
from fuzz.mutate import damaged, mutated
from fuzz.viewer import Viewer
from mobilegs.csrc import binding
from mobilegs.data.images import exif_number
from mobilegs.errors import InputError
from mobilegs.mgs import bits, positions, rans
from tests.support.memory_meter import RESET

CONFORMANCE = Path(__file__).parents[1] / "mgs" / "conformance"
MUTATIONS = 100  # of each kind
PATIENT = 600.0  # seconds: tests do not fail on busy machines
NEEDS_PROC = pytest.mark.skipif(not RESET.exists(), reason="needs Linux")
RANS, BITS, POSITIONS = range(3)  # ways of the target `cpp-decode`


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Compute in one thread: a second one only waits for its processor."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    with contextlib.closing(Viewer(tmp_path_factory.mktemp("node"), seconds=PATIENT)) as made:
        yield made


def verdicts(kind: str, inputs: list[bytes], viewer: Viewer, folder: Path) -> list[str | None]:
    """Return the verdicts of the Python reader; the viewer must agree on each `.mgs`."""
    folder.mkdir(exist_ok=True)
    ours = theirs = reader_of(kind, folder, PATIENT).verdicts(inputs)
    if kind in VIEWER_KINDS:
        theirs = viewer.ask(kind, inputs)["verdicts"]
    found: list[str | None] = []
    for i, (our, their) in enumerate(zip(ours, theirs, strict=True)):
        assert not isinstance(our, dict), f"input {i}: {our['error']}"
        assert not isinstance(their, dict), f"input {i}, viewer: {their['error']}"
        if kind == "mgs" and not (our is None and their and ONLY_THERE.search(their)):
            assert (our is None) == (their is None), f"input {i}: '{our}', viewer: '{their}'"
        found.append(our)
    return found


# --- all readers


@NEEDS_PROC
@pytest.mark.parametrize("kind", [*KINDS, *CAPTURE_KINDS])
def test_seeds_are_scenes_and_mutations_are_read_or_refused(
    kind: str, viewer: Viewer, tmp_path: Path
) -> None:
    valid, r = list(seeds(kind).values()), random.Random(0)
    found = verdicts(kind, valid, viewer, tmp_path)
    # a part of a capture that replaces another may be refused: it does not fit the rest
    assert len(found) - found.count(None) <= (2 if kind in CAPTURE_KINDS else 0), found
    short = short_seeds(kind)
    made = [mutated(kind, r, r.choice(short), short) for _ in range(MUTATIONS)]
    found = verdicts(kind, made, viewer, tmp_path / "mutations")
    assert MUTATIONS / 20 < found.count(None) < MUTATIONS, found


@NEEDS_PROC
@pytest.mark.parametrize("kind", [*KINDS, *CAPTURE_KINDS])
def test_kept_inputs_are_read_or_refused(kind: str, viewer: Viewer, tmp_path: Path) -> None:
    inputs = corpus(f"python-{kind}")
    inputs += corpus(f"javascript-{kind}") if kind in VIEWER_KINDS else []
    verdicts(kind, inputs, viewer, tmp_path)


@NEEDS_PROC
@pytest.mark.parametrize("kind", sorted({name.rpartition(".")[2] for name in EXPECTED}))
def test_files_are_opened_or_refused_as_expected(
    kind: str, viewer: Viewer, tmp_path: Path, subtests: pytest.Subtests
) -> None:
    names = [name for name in EXPECTED if name.endswith(f".{kind}")]
    inputs = [(CORPUS / "expected" / name).read_bytes() for name in names]
    ours = verdicts(kind, inputs, viewer, tmp_path)
    theirs = viewer.ask(kind, inputs)["verdicts"] if kind in VIEWER_KINDS else ours
    for name, our, their in zip(names, ours, theirs, strict=True):
        expected = EXPECTED[name]
        with subtests.test(name):
            assert (our is None) == (their is None) == (expected is None)
            assert expected is None or (our is not None and expected in our)


@NEEDS_PROC
@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("mgs", "tiny"),
        ("ply", "big"),
        ("spz", "version-3-degree-1"),
        ("spz", "version-4-degree-0-quick"),
        ("compressed", "degree-1"),
        ("glb", "degree-0"),
    ],
)
def test_a_file_cut_at_any_byte_is_refused(
    kind: str, name: str, viewer: Viewer, tmp_path: Path
) -> None:
    data = seeds(kind)[name]
    ends = [end for end in range(len(data)) if end < 600 or end % 5 == len(data) % 5]
    assert None not in verdicts(kind, [data[:end] for end in ends], viewer, tmp_path)


def test_the_kept_inputs_are_small_and_belong_to_targets() -> None:
    folders = [path for path in CORPUS.iterdir() if path.is_dir()]
    assert {folder.name for folder in folders} <= {"expected", *TARGETS}
    assert {path.name for path in (CORPUS / "expected").iterdir()} == EXPECTED.keys()
    assert sum(path.stat().st_size for folder in folders for path in folder.iterdir()) < 400_000


def test_missing_tools_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "compiler", lambda: None)
    assert missing(["cpp-decode", "cpp-networks", "agreement"]) == [HELP["clang"]]


def test_exif_numbers_are_far_from_underflow() -> None:
    assert exif_number((1e-320, 1)) == exif_number(1e-12) == 0 < exif_number(1e-4)


# --- coverage in JavaScript


@NEEDS_PROC
def test_coverage_tells_inputs_that_reach_new_code(tmp_path: Path) -> None:
    # the first input is read in pieces, too, and leaves memory for the next
    names = ("sq_constant", "sq_constant", "sq_constant", "nvq_layers", "nvq_layers")
    batch = [(CONFORMANCE / f"{name}.mgs").read_bytes() for name in names]
    with contextlib.closing(Viewer(tmp_path, "--coverage")) as viewer:
        novel, blocks, _ = viewer.run("mgs", batch)
    assert {0, 3} <= set(novel) and not {2, 4} & set(novel) and blocks > 100


@NEEDS_PROC
def test_the_loop_keeps_a_finding(viewer: Viewer, tmp_path: Path) -> None:
    found = Findings("javascript-ply", tmp_path / "findings")
    viewer.seconds = 0  # each input takes more
    loop("ply", partial(viewer.run, "ply"), found, tmp_path / "corpus", seconds=0)
    viewer.seconds = PATIENT
    assert found.known and len(list(found.folder.iterdir())) == len(found.known) + 1


# --- all decoders


@pytest.fixture(scope="module")
def agreement(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Agreement]:
    with contextlib.closing(Agreement(tmp_path_factory.mktemp("agreement"))) as made:
        yield made


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # read_mgs.py meets numbers that overflow
def test_decoders_agree_on_the_kept_inputs(agreement: Agreement) -> None:
    inputs = [path.read_bytes() for path in sorted(CONFORMANCE.glob("*.mgs"))]
    conforming = len(inputs)
    _, _, errors = agreement([*inputs, *corpus("agreement")])
    assert [error for error in errors if error] == []
    assert agreement.scenes >= conforming


def test_a_disagreement_is_told(agreement: Agreement) -> None:
    data = (CONFORMANCE / "sq_constant.mgs").read_bytes()
    arrays = decoded(data)
    assert not isinstance(arrays, str)
    right = arrays[1]
    assert agreement.disagreement(data, {"wasm": right}) is None
    assert "refused" in str(agreement.disagreement(data, {"wasm": "refused"}))
    for name in right:
        wrong = right | {name: right[name] + np.float32(1e-3) * np.abs(right[name]).max()}
        assert f"{name} differs" in str(agreement.disagreement(data, {"wasm": wrong}))
    assert "numbers instead of" in str(difference(right | {"sh": right["sh"][1:]}, right))


# --- C++


def symbols(way: int, stream: bytes, count: int, bound: int) -> np.ndarray | str:
    """Return the numbers in a stream, or the sentence of a refusal."""
    try:
        if way == BITS:
            return bits.unpack_short(stream, np.full(count, bound))
        if way == POSITIONS:
            return positions.decode_positions(stream, count).numpy()
        return rans.decode(stream, count, bound)
    except InputError as error:
        return str(error)


@pytest.mark.skipif(binding.decoders() is None, reason="needs the C++ library")
def test_cpp_decodes_streams_as_the_reference_does() -> None:
    r, taken = random.Random(0), 0
    # without the flags that only the target knows
    valid = [data for data in seeds("decode").values() if len(data) < 1000 and data[0] <= POSITIONS]
    for data in [*valid, *(r.choice(valid) for _ in range(600))]:
        way, count, bound = struct.unpack_from("<BIH", data)
        stream = data[7:]
        if r.random() < 0.8:
            stream = damaged(r, stream, as_long=r.random() < 0.7)
            count = max(1, count + r.choice([0, 0, 0, 0, 1, -1]))
        found = symbols(way, stream, count, bound)
        with reference():
            expected = symbols(way, stream, count, bound)
        assert type(found) is type(expected)
        assert np.array_equal(found, expected)
        taken += not isinstance(found, str)
    assert 100 < taken < 500


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
@pytest.mark.parametrize("kind", compiled.KINDS)
def test_targets_of_cpp_run_on_their_seeds_and_kept_inputs(kind: str, tmp_path: Path) -> None:
    sources = [HERE / "cpp" / "replay.cpp", *compiled.sources(kind)]
    program = tmp_path / kind
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
    flags = ["-std=c++17", "-O0", "-pthread", "-DLANES=4", *checks]
    build = ["c++", *flags, *sources, "-o", program]
    done = subprocess.run(build, capture_output=True, text=True)
    if done.returncode and "san" in done.stderr:
        pytest.skip("needs a compiler with sanitizers")
    assert done.returncode == 0, done.stderr
    files = [
        path for name in ("seeds/", "corpus/cpp-") for path in (HERE / f"{name}{kind}").iterdir()
    ]
    done = subprocess.run([program, *files], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
