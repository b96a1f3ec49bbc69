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
from mobilegs.gaussians import Gaussians
from mobilegs.render.project import rotation_matrices
from mobilegs.spherical_harmonics import sh_colors
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


def with_nodes(data: bytes, *nodes: dict[str, Any], roots: list[int] | None = None) -> bytes:
    """Return a file with other nodes; `roots` are those of its scene, by default the first."""
    content, body = parts_of(data)
    content |= {"nodes": list(nodes), "scenes": [{"nodes": [0] if roots is None else roots}]}
    return joined(content, body)


def read_with_nodes(
    path: Path, data: bytes, *nodes: dict[str, Any], roots: list[int] | None = None
) -> Gaussians:
    path.write_bytes(with_nodes(data, *nodes, roots=roots))
    return read_glb(path)


def covariances(scene: Gaussians) -> torch.Tensor:
    shapes = rotation_matrices(scene.quats.double()) * scene.log_scales.double().exp()[:, None]
    return shapes @ shapes.mT


@pytest.fixture
def valid(tmp_path: Path) -> bytes:
    """A valid file of three Gaussians."""
    write_glb(tmp_path / "valid.glb", random_scene(3, 1))
    return (tmp_path / "valid.glb").read_bytes()


@pytest.mark.parametrize("degree", [0, 3])
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
    assert found.left_out == 1  # the opacity of 0
    assert rotation_error(found, made.select(slice(1, None))) < 2 / 32767
    expected = torch.tensor([100 / 255, 200 / 255, 1 - 2.0**-24])
    assert max_error(found.opacities, expected) < 1e-6


def test_identities_and_nodes_without_splats_change_no_bit(valid: bytes, tmp_path: Path) -> None:
    (tmp_path / "valid.glb").write_bytes(valid)
    plain = read_glb(tmp_path / "valid.glb").tensors()
    still = {"mesh": 0, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
    moved = {"camera": 0, "translation": [0, 1, 3]}
    for nodes in ([still], [{"mesh": 0}, moved], [{"children": [1, 2]}, moved, {"mesh": 0}]):
        roots = [0] if "children" in nodes[0] else list(range(len(nodes)))
        found = read_with_nodes(tmp_path / "scene.glb", valid, *nodes, roots=roots)
        for name, value in found.tensors().items():
            assert torch.equal(value, plain[name]), name


def test_a_node_moves_turns_and_scales_its_splats(tmp_path: Path) -> None:
    made = random_scene(200, 3)
    write_glb(tmp_path / "made.glb", made)
    made = read_glb(tmp_path / "made.glb")  # without -0
    # in glTF's axes: a quarter of a turn around y, which takes z to x, twice the size
    node = {"mesh": 0, "rotation": [0, 0.5**0.5, 0, 0.5**0.5], "scale": [2, 2, 2]}
    node["translation"] = [1, 2, 3]
    found = read_with_nodes(tmp_path / "moved.glb", (tmp_path / "made.glb").read_bytes(), node)
    # here x and y have the opposite signs, so that turn takes z to -x and x to z
    turn = torch.tensor([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]])
    expected = 2 * made.means @ turn.T + torch.tensor([-1.0, -2, 3])
    assert max_error(found.means, expected) < 1e-5
    both = turn.double() @ covariances(made) @ turn.T.double() * 4
    assert max_error(covariances(found) / both.abs().amax(), both / both.abs().amax()) < 1e-6
    directions = torch.nn.functional.normalize(made.means, dim=1)
    colors = sh_colors(made.sh, directions)
    assert max_error(sh_colors(found.sh, directions @ turn.T), colors) < 1e-5
    assert torch.equal(found.logit_opacities, made.logit_opacities)
    # the same as a matrix, column by column, and split between a node and its parent
    matrix = [0, 0, -2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 1, 2, 3, 1]
    parent = {"children": [1], "translation": [1, 2, 3], "scale": [2, 2, 2]}
    child = {"mesh": 0, "rotation": node["rotation"]}
    for nodes in ([{"mesh": 0, "matrix": matrix}], [parent, child]):
        data = (tmp_path / "made.glb").read_bytes()
        same = read_with_nodes(tmp_path / "same.glb", data, *nodes)
        assert max_error(same.means, found.means) < 1e-5
        assert max_error(covariances(same), covariances(found)) < 1e-6
        assert max_error(same.sh, found.sh) < 1e-5


def test_a_reflection_and_an_uneven_scale_change_shapes_exactly(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_glb(tmp_path / "made.glb", random_scene(200, 2))
    data, made = (tmp_path / "made.glb").read_bytes(), read_glb(tmp_path / "made.glb")
    directions = torch.nn.functional.normalize(made.means, dim=1)
    for scale, even in (([-1, 1, 1], True), ([1, -3, 0.5], False), ([1, 0, 1], False)):
        caplog.clear()
        found = read_with_nodes(tmp_path / "other.glb", data, {"mesh": 0, "scale": scale})
        change = torch.diag(torch.tensor(scale, dtype=torch.float64))
        assert max_error(found.means, made.means @ change.float()) < 1e-6
        expected = change @ covariances(made) @ change
        assert max_error(covariances(found), expected) < 1e-6 * float(expected.abs().max())
        assert ("view-dependent colours only turn: 0\n" in caplog.text) != even
        if even:
            colors = sh_colors(found.sh, directions @ change.float())
            assert max_error(colors, sh_colors(made.sh, directions)) < 1e-5


def test_the_splats_of_several_nodes_become_one_scene(
    valid: bytes, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    content, body = parts_of(valid)
    smaller = json.loads(json.dumps(content["meshes"][0]))
    for name in SH_ATTRIBUTES[1:]:
        smaller["primitives"][0]["attributes"].pop(name, None)
    content["meshes"] += [smaller, smaller]
    data = joined(content, body)
    up = {"mesh": 0, "translation": [0, 5, 0]}
    found = read_with_nodes(tmp_path / "a.glb", data, {"mesh": 1}, up, {"mesh": 1}, roots=[0, 1])
    plain = read_with_nodes(tmp_path / "b.glb", data, {"mesh": 0})
    assert len(found) == 6 and found.sh_degree == 1
    assert torch.equal(found.means[:3], plain.means)
    assert torch.equal(found.means[3:], plain.means - torch.tensor([0.0, 5, 0]))
    assert torch.equal(found.sh[3:], plain.sh) and not found.sh[:3, 1:].any()
    assert "no node of the scene holds: 1" in caplog.text  # the third mesh


def test_a_file_without_nodes_or_scenes_is_read(valid: bytes, tmp_path: Path) -> None:
    content, body = parts_of(valid)
    for name in ("scene", "scenes"):
        content.pop(name)
    content["nodes"] = [{"mesh": 0}, {"children": [0], "translation": [0, 0, 1]}]
    (tmp_path / "rootless.glb").write_bytes(joined(content, body))
    moved = read_glb(tmp_path / "rootless.glb")
    content.pop("nodes")
    (tmp_path / "bare.glb").write_bytes(joined(content, body))
    found = read_glb(tmp_path / "bare.glb")
    assert torch.equal(moved.means, found.means + torch.tensor([0.0, 0, 1]))


def test_a_long_chain_of_nodes_is_read(valid: bytes, tmp_path: Path) -> None:
    nodes = [{"children": [i + 1]} for i in range(20_000)]
    assert len(read_with_nodes(tmp_path / "deep.glb", valid, *nodes, {"mesh": 0})) == 3


def test_splats_in_too_many_nodes_are_refused(tmp_path: Path) -> None:
    write_glb(tmp_path / "made.glb", random_scene(200, 0))
    roots = list(range(2000))
    data = with_nodes((tmp_path / "made.glb").read_bytes(), *[{"mesh": 0}] * 2000, roots=roots)
    assert "too many nodes" in error_message(read_glb, tmp_path / "many.glb", data)


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


def splats(**values: object) -> Change:
    return lambda content: primitive_of(content)["extensions"][EXTENSION].update(values)


def nodes(*given: dict[str, Any]) -> Change:
    return lambda content: content.update(nodes=list(given))


CHANGES: dict[str, tuple[Change, str]] = {
    "no splats": (lambda c: primitive_of(c).pop("extensions"), "has no splats"),
    "no opacity": (without(f"{EXTENSION}:OPACITY"), "OPACITY"),
    "no SH of degree 0": (without(SH_ATTRIBUTES[0]), "SH_DEGREE_0"),
    "compressed": (splats(extensions={"KHR_x": {}}), "decompress it first"),
    "another kernel": (splats(kernel="cone"), "not Gaussians"),
    "no node with splats": (nodes({"camera": 0}), "no node of its scene holds them"),
    "a cycle": (nodes({"children": [1]}, {"children": [2]}, {"children": [1]}), "below itself"),
    "two parents": (nodes({"children": [1, 1]}, {"mesh": 0}), "node 1 has two parents"),
    "an overflow": (
        nodes(
            {"scale": [1e200, 1, 1], "children": [1]},
            {"scale": [1e200, 1, 1], "children": [2]},
            {"mesh": 0},
        ),
        "node 1 is not valid",
    ),
    "another length": (accessor(count=2), "different lengths"),
    "a long accessor": (accessor(count=10**9), "does not fit"),
    "a file elsewhere": (lambda c: c["buffers"][0].update(uri="/etc/passwd"), "does not fit"),
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
