"""The targets of `fuzz/`, without clang and atheris: their valid files, and the inputs kept."""

import contextlib
import json
import random
import shutil
import struct
import subprocess
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

import fuzz.captures as captures
import fuzz.compiled as compiled
from fuzz.__main__ import HERE, TARGETS, corpus
from fuzz.agreement import Agreement, decoded, difference
from fuzz.findings import Findings
from fuzz.javascript import KINDS, Viewer, loop
from mobilegs.data.images import exif_number, open_image
from mobilegs.errors import InputError
from mobilegs.formats.glb import read_glb
from tests.fuzz.campaign import SEEDS
from tests.fuzz.readers import Reader
from tests.fuzz.seeds_formats import glb_seeds
from tests.support.memory_meter import RESET
from tests.support.mgs_parts import parse_parts

CONFORMANCE = Path(__file__).parents[1] / "mgs" / "conformance"
PATIENT = 600.0  # seconds: tests do not fail on busy machines
NEEDS_PROC = pytest.mark.skipif(not RESET.exists(), reason="needs Linux")


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Compute in one thread: a second one only waits for its processor."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def test_the_kept_inputs_are_small_and_belong_to_targets() -> None:
    folders = list((HERE / "corpus").iterdir())
    assert {folder.name for folder in folders} <= TARGETS.keys()
    assert sum(path.stat().st_size for folder in folders for path in folder.iterdir()) < 300_000


# --- Python


def reader_of(kind: str, folder: Path) -> Reader:
    if kind in captures.KINDS:
        return captures.CaptureReader(kind, folder, PATIENT)
    return Reader(kind, folder / f"input.{kind}", PATIENT)


@pytest.mark.parametrize("kind", [*SEEDS, *captures.KINDS])
def test_kept_inputs_are_read_or_refused_with_a_sentence(kind: str, tmp_path: Path) -> None:
    reader = reader_of(kind, tmp_path)
    with warnings.catch_warnings():
        if kind == "image":  # Pillow warns of damaged photos that it reads
            warnings.simplefilter("ignore")
        found = [reader.verdict(data, decode=True) for data in corpus(f"python-{kind}")]
    assert not [each for each in found if isinstance(each, dict)]


@pytest.mark.parametrize("kind", captures.KINDS)
def test_most_seeds_are_captures_and_mutations_of_all_are_read_or_refused(
    kind: str, tmp_path: Path
) -> None:
    reader, r = captures.CaptureReader(kind, tmp_path, PATIENT), random.Random(0)
    seeds = [seed.data for seed in captures.SEEDS[kind]().values()]
    verdicts = [reader.verdict(data, decode=True) for data in seeds]
    assert sum(verdict is None for verdict in verdicts) >= len(seeds) - 2, verdicts
    with warnings.catch_warnings():
        if kind == "image":
            warnings.simplefilter("ignore")
        made = [captures.mutated(kind, r, r.choice(seeds)) for _ in range(60)]
        found = [reader.verdict(data, decode=True) for data in made]
    assert not [each for each in found if isinstance(each, dict)]
    assert len(found) / 20 < found.count(None) < len(found)


def test_photos_of_formats_that_start_other_programs_are_refused(tmp_path: Path) -> None:
    page = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 4 4\n%%EndComments\n%%EOF\n"
    (tmp_path / "photo.png").write_bytes(page)
    with pytest.raises(InputError, match="cannot be read as an image"):
        open_image(tmp_path / "photo.png")


def test_a_moved_splat_that_is_not_finite_is_left_out_alone(tmp_path: Path) -> None:
    data = bytearray(glb_seeds()["nodes"].data)
    (length,) = struct.unpack_from("<I", data, 12)
    rotations = json.loads(data[20 : 20 + length])["bufferViews"][2]["byteOffset"]
    struct.pack_into("<f", data, 28 + length + rotations, float("nan"))
    (tmp_path / "moved.glb").write_bytes(data)
    assert len(read_glb(tmp_path / "moved.glb")) == 2


def test_exif_numbers_are_far_from_underflow() -> None:
    assert exif_number((1e-320, 1)) == exif_number(1e-12) == 0 < exif_number(1e-4)


# --- JavaScript


@pytest.mark.thorough
@NEEDS_PROC
@pytest.mark.parametrize("kind", KINDS)
def test_kept_inputs_pass_the_viewers_readers(kind: str, tmp_path: Path) -> None:
    found = Findings(kind, tmp_path / "findings")
    with contextlib.closing(Viewer(kind, tmp_path)) as viewer:
        loop(kind, viewer, found, tmp_path / "corpus", seconds=0)
        _, _, errors = viewer(corpus(f"javascript-{kind}"))
    assert not any(errors) and not found.known


@NEEDS_PROC
def test_coverage_tells_inputs_that_reach_new_code(tmp_path: Path) -> None:
    # the first input is read in pieces, too, and leaves memory for the next
    names = ("sq_constant", "sq_constant", "sq_constant", "nvq_layers", "nvq_layers")
    with contextlib.closing(Viewer("mgs", tmp_path)) as viewer:
        novel, blocks, _ = viewer([(CONFORMANCE / f"{name}.mgs").read_bytes() for name in names])
    assert {0, 3} <= set(novel) and not {2, 4} & set(novel) and blocks > 100


# --- all decoders


@pytest.fixture(scope="module")
def agreement(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Agreement]:
    made = Agreement(tmp_path_factory.mktemp("agreement"))
    yield made
    made.close()


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # read_mgs.py meets numbers that overflow
def test_decoders_agree_on_the_kept_inputs(agreement: Agreement) -> None:
    inputs = [path.read_bytes() for path in sorted(CONFORMANCE.glob("*.mgs"))]
    conforming = len(inputs)
    inputs += [*corpus("python-mgs"), *corpus("javascript-mgs"), *corpus("agreement")]
    _, _, errors = agreement(inputs)
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


def test_a_checksum_of_one_decoder_only_would_be_told(agreement: Agreement) -> None:
    parts = parse_parts((CONFORMANCE / "sq_constant.mgs").read_bytes())
    parts.piece("positions").row["crc32"] = 1
    _, _, errors = agreement([parts.to_bytes()])
    assert errors == [None]  # all refuse it
    told = agreement.disagreement(parts.to_bytes(), {"wasm": {}})
    assert told is not None and told.startswith("wasm: a scene, C++: '")


# --- C++


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
@pytest.mark.parametrize("kind", compiled.KINDS)
def test_targets_of_cpp_run_on_their_seeds_and_kept_inputs(kind: str, tmp_path: Path) -> None:
    sources = [HERE / "cpp" / "replay.cpp", HERE / "cpp" / f"{kind}.cpp"]
    program = tmp_path / kind
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
    flags = ["-std=c++17", "-O1", "-DLANES=4", *checks]
    build = ["c++", *flags, *sources, compiled.CSRC / "decode.cpp", "-o", program]
    done = subprocess.run(build, capture_output=True, text=True)
    if done.returncode and "san" in done.stderr:
        pytest.skip("needs a compiler with sanitizers")
    assert done.returncode == 0, done.stderr
    files = []
    for number, data in enumerate([*compiled.seeds(kind), *corpus(f"cpp-{kind}")]):
        files.append(tmp_path / f"{number}")
        files[-1].write_bytes(data)
    done = subprocess.run([program, *files], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
