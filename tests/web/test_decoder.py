"""The viewer's JavaScript decoder gives the same scenes and refusals as the Python decoder."""

import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from torch.nn.functional import normalize

from mobilegs.errors import InputError
from mobilegs.mgs.codec import decode_mgs, encode_mgs
from mobilegs.mgs.container import read_container, write_container
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.lobes import constant_lobes
from tests.support.mgs_parts import Piece, parse_parts
from tests.support.node import assert_close, assert_same_refusals, decoded, refusals
from tests.support.scene_cases import CASES, Case, make_scene


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return {name: encode_mgs(make_scene(case)) for name, case in CASES.items()}


@pytest.fixture(scope="module")
def whole(files: dict[str, bytes], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return decoded(tmp_path_factory.mktemp("whole"), files, seed=0)


@pytest.mark.parametrize("name", CASES)
def test_both_decoders_give_the_same_scene(
    name: str, files: dict[str, bytes], whole: dict[str, Any]
) -> None:
    coded, found = decode_mgs(files[name]), whole[name]
    assert_same_header(coded, found["header"])
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


def assert_same_header(coded: QuantizedScene, header: dict[str, Any]) -> None:
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


def test_files_in_pieces_give_the_same_arrays(
    files: dict[str, bytes], whole: dict[str, Any], tmp_path: Path
) -> None:
    for name, scene in decoded(tmp_path, files, seed=1).items():
        assert scene["header"] == whole[name]["header"]
        for key, values in scene["arrays"].items():
            assert torch.equal(values, whole[name]["arrays"][key]), (name, key)


def test_the_cases_cover_every_codec_and_context_count(files: dict[str, bytes]) -> None:
    parts = [parse_parts(data) for data in files.values()]
    codecs = {piece.codec for one in parts for piece in one.pieces}
    assert codecs == {"raw", "halves", "morton-class", "bits", "rans"}
    positions = [one.piece("positions").data for one in parts]
    assert {struct.unpack_from("<H", data, 6)[0] for data in positions} == {1, 49}


# --- refusals: those of damaged and crafted files are in tests/fuzz


def test_trailing_bytes_are_refused_and_later_minor_versions_are_read(
    files: dict[str, bytes], tmp_path: Path
) -> None:
    data = files["linear lobes"]
    parts = parse_parts(data)
    header, pieces = {**parts.header, "new": [1]}, [Piece("scale", "new", b"abc"), *parts.pieces]
    later = replace(parts, header=header, pieces=pieces, version=(2, 7)).to_bytes()
    cases = [data, later, data + b"\0", data + data]
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
    header, streams = read_container(encode_mgs(make_scene(Case(20))))
    header["weighting"]["name"] = "two_pass"
    data = write_container(header, list(streams.values()), major=2)
    (sentence,) = refusals(tmp_path, [data])
    assert sentence is not None and "has the weighting 'two_pass': known are" in sentence
    with pytest.raises(InputError, match="unknown weighting 'two_pass'"):
        decode_mgs(data)
