"""The viewer's JavaScript decoder gives the same scenes and refusals as the Python decoder."""

import json
import struct
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs, inspect
from mobilegs.mgs.container import VERSION
from mobilegs.render import Weighting
from mobilegs.render.lobes import constant_lobes
from tests.support.node import assert_close, assert_same_refusals, decoded, refusals
from tests.support.quantized_scenes import join, places, split
from tests.support.scene_cases import CASES, Case, make_scene
from tests.support.selection import few


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return {name: encode_mgs(make_scene(case)) for name, case in CASES.items()}


# --- node


# --- scenes


@pytest.fixture(scope="module")
def whole(files: dict[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return decoded(tmp_path_factory.mktemp("whole"), files, seed=0)


@pytest.mark.parametrize("name", CASES)
def test_both_decoders_give_the_same_scene(
    name: str, files: dict[str, bytes], whole: dict[str, Any]
) -> None:
    coded, found = decode_mgs(files[name]), whole[name]
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
    coded, header = decode_mgs(files[name]), whole[name]["header"]
    assert header["meta"] == coded.meta and header["near"] == coded.near
    assert {**header["weighting"], "detached": False} == vars(coded.weighting)
    assert header["network"] == (coded.network is not None)
    assert header["lodSizes"] == list(coded.lod_sizes or [len(coded)])
    assert torch.equal(torch.tensor(header["background"]), coded.background)
    assert len(header["views"]) == len(coded.views) == 2
    for view, ours in zip(header["views"], coded.views, strict=True):
        assert (view["width"], view["height"]) == (ours.width, ours.height)
        assert torch.equal(torch.tensor(view["viewmat"]), ours.viewmat.reshape(-1))
        assert torch.equal(torch.tensor(view["K"]), ours.K.reshape(-1))


@pytest.mark.parametrize("seed", few([1, 2, 3], 1))
def test_files_in_pieces_give_the_same_arrays(
    seed: int, files: dict[str, bytes], whole: dict[str, Any], tmp_path: Path
) -> None:
    for name, scene in decoded(tmp_path, files, seed=seed).items():
        assert scene["header"] == whole[name]["header"]
        for key, values in scene["arrays"].items():
            assert torch.equal(values, whole[name]["arrays"][key]), (name, key)


def test_the_cases_cover_every_codec_and_context_count(
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


def test_trailing_bytes_are_refused_and_later_minor_versions_are_read(
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
            decode_mgs(start)
        assert sentence == str(error.value)


def test_an_unsupported_weighting_is_refused_by_name(tmp_path: Path) -> None:
    data = encode_mgs(replace(make_scene(Case(20)), weighting=Weighting("two_pass")))
    assert decode_mgs(data).weighting.name == "two_pass"
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
    "name",
    few(
        ["linear lobes", "nothing by direction", "scalars with lobes", "layers of scalars"],
        "layers of scalars",
    ),
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
    "name",
    few(
        ["linear lobes", "network", "one place", "scalars with lobes", "layers of scalars"],
        "layers of scalars",
    ),
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


def test_malformed_headers_are_refused_alike(tmp_path: Path) -> None:
    texts = ["", "[]", "1", "{", '{"streams":0}', '{"streams":[]}', "[" * 100_000, '{"count":NaN}']
    texts += ['{"near":' + "9" * 5000 + "}", '"\\ud800"', '{"streams":[1]}', '{"streams":[null]}']
    row = {"name": "a", "codec": "a", "bytes": 2**39, "crc32": 0}
    texts += [json.dumps({"streams": [row] * n}) for n in (1, 2, 257)]
    assert None not in assert_same_refusals(tmp_path, [join(text, b"") for text in texts])


@pytest.mark.parametrize("count", [2**26, 300_000, 41, 39])
def test_a_false_count_is_refused(count: int, files: dict[str, bytes], tmp_path: Path) -> None:
    header, body = split(files["linear lobes"])
    assert None not in assert_same_refusals(tmp_path, [join({**header, "count": count}, body)])
