"""Reading and writing `.glb`, files of splat-transform, and errors for invalid files."""

import json
import logging
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.glb import EXTENSION, SH_ATTRIBUTES, read_glb, write_glb
from mobilegs.formats.ply import read_ply
from tests.support.random_scenes import error_message, max_error, random_scene, rotation_error

OTHERS = Path(__file__).parent / "other_tools"


def parts_of(data: bytes) -> tuple[dict[str, Any], bytes]:
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def joined(content: object, body: bytes) -> bytes:
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(body))
    chunks = struct.pack("<I", len(text)), b"JSON", text, struct.pack("<I", len(body)), b"BIN\0"
    return head + b"".join(chunks) + body


def attribute(data: bytes, name: str) -> np.ndarray:
    content, body = parts_of(data)
    accessor = content["accessors"][content["meshes"][0]["primitives"][0]["attributes"][name]]
    view = content["bufferViews"][accessor["bufferView"]]
    kind = {5126: "<f4", 5121: "u1"}[accessor["componentType"]]
    part = body[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return np.frombuffer(part, kind).reshape(accessor["count"], -1)


@pytest.fixture
def valid(tmp_path: Path) -> bytes:
    """A valid file of three Gaussians."""
    write_glb(tmp_path / "valid.glb", random_scene(3, 1))
    return (tmp_path / "valid.glb").read_bytes()


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_a_written_scene_is_read_back_up_to_rounding(degree: int, tmp_path: Path) -> None:
    made = random_scene(300, degree)
    made.logit_opacities.clamp_(-10, 10)
    write_glb(tmp_path / "scene.glb", made)
    found = read_glb(tmp_path / "scene.glb")
    assert torch.equal(found.means, made.means)
    assert torch.equal(found.sh, made.sh)
    assert max_error(found.log_scales, made.log_scales) < 1e-6
    assert max_error(found.opacities, made.opacities) < 1.2e-7
    # half a unit in the last place of an opacity near 1, by the logit's slope there
    assert max_error(found.logit_opacities, made.logit_opacities) < 2**-24 * 2.3e4
    assert rotation_error(found, made) < 1e-6


def test_splat_transform_writes_the_same_values(tmp_path: Path) -> None:
    made = read_ply(OTHERS / "scene.ply")
    write_glb(tmp_path / "ours.glb", made)
    ours, theirs = (tmp_path / "ours.glb").read_bytes(), (OTHERS / "theirs.glb").read_bytes()
    names = ["POSITION", *(f"{EXTENSION}:{part}" for part in ("ROTATION", "SCALE", "OPACITY"))]
    for name in [*names, *SH_ATTRIBUTES]:
        np.testing.assert_allclose(attribute(ours, name), attribute(theirs, name), atol=2e-7)
    found = read_glb(OTHERS / "theirs.glb")
    assert torch.equal(found.means, made.means) and torch.equal(found.sh, made.sh)
    assert rotation_error(found, made) < 1e-6


def test_the_json_describes_the_splats(valid: bytes) -> None:
    content, _ = parts_of(valid)
    assert content["asset"]["generator"].startswith("mobilegs ")
    assert content["asset"]["extras"] == {"blend": "sorted"}
    assert content["extensionsUsed"] == [EXTENSION]
    (primitive,) = content["meshes"][0]["primitives"]
    about = {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}
    assert primitive["mode"] == 0 and primitive["extensions"] == {EXTENSION: about}
    places = attribute(valid, "POSITION")
    assert content["accessors"][0]["max"] == places.max(0).tolist()


def test_normalised_integers_with_a_stride_are_read(tmp_path: Path) -> None:
    made = random_scene(4, 0)
    write_glb(tmp_path / "scene.glb", made)
    content, body = parts_of((tmp_path / "scene.glb").read_bytes())
    attributes = content["meshes"][0]["primitives"][0]["attributes"]
    table = np.zeros(4, [("pad", "u1", 3), ("turn", "<i2", 4), ("opacity", "u1"), ("rest", "u1")])
    table["turn"] = np.rint(attribute(joined(content, body), f"{EXTENSION}:ROTATION") * 32767)
    table["opacity"] = [0, 100, 200, 255]
    view = {"buffer": 0, "byteOffset": len(body), "byteLength": table.nbytes, "byteStride": 13}
    content["bufferViews"].append(view)
    for name, at, kind, shape in (("ROTATION", 3, 5122, "VEC4"), ("OPACITY", 11, 5121, "SCALAR")):
        content["accessors"][attributes[f"{EXTENSION}:{name}"]] = {
            "bufferView": len(content["bufferViews"]) - 1,
            "byteOffset": at,
            "componentType": kind,
            "normalized": True,
            "count": 4,
            "type": shape,
        }
    (tmp_path / "packed.glb").write_bytes(joined(content, body + table.tobytes()))
    found = read_glb(tmp_path / "packed.glb")
    assert rotation_error(found, made) < 2 / 32767
    expected = torch.tensor([1e-12, 100 / 255, 200 / 255, 1 - 2.0**-24])
    assert max_error(found.opacities, expected) < 1e-6


def test_other_color_spaces_are_read_with_a_warning(
    valid: bytes, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    content, body = parts_of(valid)
    about = content["meshes"][0]["primitives"][0]["extensions"][EXTENSION]
    about["colorSpace"] = "lin_rec709_display"
    (tmp_path / "linear.glb").write_bytes(joined(content, body))
    with caplog.at_level(logging.WARNING):
        assert len(read_glb(tmp_path / "linear.glb")) == 3
    assert "drawn as sRGB" in caplog.text


def test_an_empty_scene_raises_an_error_and_infinite_gaussians_are_dropped(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="without Gaussians"):
        write_glb(tmp_path / "none.glb", random_scene(0, 0))
    made = random_scene(3, 0)
    made.log_scales[1, 1], made.log_scales[2, 2] = torch.inf, -200
    write_glb(tmp_path / "two.glb", made)
    found = read_glb(tmp_path / "two.glb")
    assert len(found) == 2 and bool(found.log_scales.isfinite().all())


Change = Callable[[dict[str, Any]], object]


def primitive_of(content: dict[str, Any]) -> dict[str, Any]:
    return content["meshes"][0]["primitives"][0]


def without(name: str) -> Change:
    return lambda content: primitive_of(content)["attributes"].pop(name)


def accessor(**values: object) -> Change:
    return lambda content: content["accessors"][2].update(values)


def view(**values: object) -> Change:
    return lambda content: content["bufferViews"][2].update(values)


def splats(**values: object) -> Change:
    return lambda content: primitive_of(content)["extensions"][EXTENSION].update(values)


def twice(content: dict[str, Any]) -> None:
    content["meshes"] *= 2


CHANGES: dict[str, tuple[Change, str]] = {
    "no splats": (lambda c: primitive_of(c).pop("extensions"), "has 0 sets of splats"),
    "two sets": (twice, "has 2 sets"),
    "no opacity": (without(f"{EXTENSION}:OPACITY"), "OPACITY"),
    "no SH of degree 0": (without(SH_ATTRIBUTES[0]), "SH_DEGREE_0"),
    "half a degree": (without(SH_ATTRIBUTES[2]), "has 3 SH"),
    "compressed": (splats(extensions={"KHR_x": {}}), "decompress it first"),
    "another kernel": (splats(kernel="cone"), "not Gaussians"),
    "a node with a rotation": (
        lambda c: c["nodes"][0].update(rotation=[0, 0, 0, 1]),
        "in its nodes",
    ),
    "another length": (accessor(count=2), "different lengths"),
    "a long accessor": (accessor(count=10**9), "does not fit"),
    "a huge accessor": (accessor(count=10**18), "does not fit"),
    "a negative count": (accessor(count=-1), "does not fit"),
    "a fractional count": (accessor(count=0.5), "does not fit"),
    "a boolean count": (accessor(count=True), "does not fit"),
    "another shape": (accessor(type="MAT4"), "does not fit"),
    "another type": (accessor(componentType=1), "does not fit"),
    "sparse": (accessor(sparse={}), "does not fit"),
    "no view": (accessor(bufferView=99), "does not fit"),
    "an offset beyond": (view(byteOffset=10**6), "does not fit"),
    "no stride": (view(byteStride=0), "does not fit"),
    "another buffer": (view(buffer=1), "does not fit"),
    "a file elsewhere": (lambda c: c["buffers"][0].update(uri="/etc/passwd"), "does not fit"),
    "a string as meshes": (lambda c: c.update(meshes="KHR"), "does not fit"),
    "a number as nodes": (lambda c: c.update(nodes=7), "does not fit"),
}


@pytest.mark.parametrize("case", CHANGES)
def test_an_inconsistent_file_raises_a_one_line_error(
    case: str, valid: bytes, tmp_path: Path
) -> None:
    content, body = parts_of(valid)
    change, words = CHANGES[case]
    change(content)
    assert words in error_message(read_glb, tmp_path / "bad.glb", joined(content, body))


def test_a_damaged_file_raises_a_one_line_error(valid: bytes, tmp_path: Path) -> None:
    path, (content, body) = tmp_path / "bad.glb", parts_of(valid)
    assert "not a .glb" in error_message(read_glb, path, b"")
    assert "version 1" in error_message(read_glb, path, valid[:4] + b"\1" + valid[5:])
    assert "cut off" in error_message(read_glb, path, valid[:-1])
    assert "cannot be read" in error_message(read_glb, path, joined(b"[" * 100_000, body))
    assert "cannot be read" in error_message(read_glb, path, joined(b'{"a":"\xff"}', body))
    assert "not an object" in error_message(read_glb, path, joined([], body))
    assert "bytes of JSON" in error_message(read_glb, path, joined(b" " * 10**6, body))
    assert "no binary part" in error_message(
        read_glb, path, joined(content, b"").replace(b"BIN", b"X12")
    )
    with pytest.raises(InputError, match="cannot read"):
        read_glb(tmp_path / "missing.glb")
