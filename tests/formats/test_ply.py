"""Reading and writing PLY scenes, and the errors for invalid files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, read_ply_scene, read_ply_up, write_ply
from mobilegs.gaussians import Gaussians
from mobilegs.render import Footprint
from mobilegs.scene_file import open_scene
from tests.support.node import javascript

NAMES = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()


def random_gaussians(n: int, degree: int, generator: torch.Generator) -> Gaussians:
    shapes = [(n, 3), (n, 4), (n, 3), (n,), (n, (degree + 1) ** 2, 3)]
    return Gaussians(*(torch.randn(shape, generator=generator) for shape in shapes))


def assert_equal(one: Gaussians, other: Gaussians) -> None:
    for name, value in one.tensors().items():
        assert torch.equal(value, other.tensors()[name]), name


def header(
    kind: str, names: Sequence[str], count: int, type_: str = "float", before: str = ""
) -> bytes:
    properties = "".join(f"property {type_} {name}\n" for name in names)
    text = f"ply\nformat {kind} 1.0\n{before}element vertex {count}\n{properties}end_header\n"
    return text.encode()


@pytest.mark.parametrize("degree", [0, 3])
def test_a_written_scene_is_read_back_exactly(
    degree: int, tmp_path: Path, generator: torch.Generator
) -> None:
    for count in (17, 0):
        gaussians = random_gaussians(count, degree, generator)
        write_ply(tmp_path / "scene.ply", gaussians)
        assert_equal(read_ply(tmp_path / "scene.ply"), gaussians)


def test_the_header_has_the_order_and_comment_that_other_tools_expect(
    tmp_path: Path, generator: torch.Generator
) -> None:
    write_ply(tmp_path / "scene.ply", random_gaussians(3, 1, generator))
    lines = (tmp_path / "scene.ply").read_bytes().split(b"end_header\n")[0].decode().splitlines()
    assert lines[2] == "element vertex 3"  # INRIA's viewer counts lines
    assert {"comment SplatRenderMode: default", "comment mobilegs blend sorted"} <= {*lines}
    names = [line.split()[2] for line in lines if line.startswith("property")]
    rest = [f"f_rest_{i}" for i in range(9)]
    expected = [*NAMES[:3], "nx", "ny", "nz", *NAMES[3:6], *rest, *NAMES[6:]]
    assert names == expected


@pytest.mark.parametrize(
    ("kind", "type_"),
    [("ascii", "float"), ("binary_little_endian", "double"), ("binary_big_endian", "float")],
)
def test_any_encoding_and_any_order_of_properties_is_read(
    kind: str, type_: str, tmp_path: Path, generator: torch.Generator
) -> None:
    names = [*reversed(NAMES), "segment"]  # the last one is not part of 3DGS
    table = torch.randn(5, len(names), generator=generator).numpy()
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(kind)
    if order:
        body = table.astype(order + {"float": "f4", "double": "f8"}[type_]).tobytes()
    else:
        body = "\n".join(" ".join(f"{x:.9g}" for x in row) for row in table).encode()
    (tmp_path / "scene.ply").write_bytes(header(kind, names, 5, type_) + body)
    gaussians = read_ply(tmp_path / "scene.ply")
    np.testing.assert_array_equal(gaussians.means[:, 0].numpy(), table[:, names.index("x")])
    np.testing.assert_array_equal(gaussians.quats[:, 3].numpy(), table[:, names.index("rot_3")])


def test_properties_of_mixed_types_and_tables_before_the_vertices_are_read(tmp_path: Path) -> None:
    row = np.dtype([("label", "u1"), *((name, "<f4") for name in NAMES)])
    rows = np.zeros(4, row)
    rows["y"], rows["rot_0"] = [1, 2, 3, 4], 1
    properties = "property uchar label\n" + "".join(f"property float {n}\n" for n in NAMES)
    text = (
        "ply\r\nformat binary_little_endian 1.0\r\ncomment made by hand\r\n"
        "element camera 2\r\nproperty double t\r\n"
        f"element vertex 4\r\n{properties}end_header\r\n"
    )
    (tmp_path / "scene.ply").write_bytes(text.encode() + bytes(16) + rows.tobytes())
    assert read_ply(tmp_path / "scene.ply").means[:, 1].tolist() == [1, 2, 3, 4]


HALF = {0.0: 0, 0.5: 0x3800, 1.0: 0x3C00, -2.0: 0xC000, 3.0: 0x4200}
RGB = ["red", "green", "blue"]
# types of properties that other tools write: those that are changed, their values and what is read
TYPES = {
    "half floats in ushort": ({name: "ushort" for name in NAMES}, [HALF[3.0]], [3.0]),
    "half floats": ({name: "half" for name in NAMES}, [-2.0], [-2.0]),
    "doubles": ({name: "double" for name in NAMES}, [-2.0], [-2.0]),
    "an opacity in bytes": ({"opacity": "uchar"}, [51, 0, 255], [-1.38629, -13.8155, 13.8023]),
    "colours in bytes": (dict.fromkeys(RGB, "uchar"), [255, 0], [1.77245, -1.77245]),
    "colours in 16 bits": (dict.fromkeys(RGB, "ushort"), [65535], [1.77245]),
    "CloudCompare's names": ({f"scalar_{n}": "float" for n in NAMES[3:]}, [3.0], [3.0]),
    "colours in floats": (dict.fromkeys(RGB, "float"), [1.0], [1.77245]),
}


def typed(types: dict[str, str], values: Sequence[float], kind: str = "<") -> bytes:
    """Return a file with a row per value, which properties of these types have; others are 1."""
    names = [n for n in NAMES if "red" not in types or not n.startswith("f_dc")]
    names = [n for n in names if f"scalar_{n}" not in types]
    columns = {name: "float" for name in names} | types
    numpy = {"ushort": "u2", "half": "f2", "double": "f8", "uchar": "u1", "float": "f4"}
    numpy |= {"int": "i4", "short": "i2"}
    table = np.ones(len(values), [(name, kind + numpy[type_]) for name, type_ in columns.items()])
    for name in types:
        table[name] = values
    properties = "".join(f"property {type_} {name}\n" for name, type_ in columns.items())
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(values)}\n{properties}"
    return text.encode() + b"end_header\n" + table.tobytes()


@pytest.mark.parametrize("case", TYPES)
def test_types_of_other_tools_are_read_as_what_they_are(case: str, tmp_path: Path) -> None:
    types, values, expected = TYPES[case]
    (tmp_path / "scene.ply").write_bytes(typed(types, values))
    found = read_ply(tmp_path / "scene.ply")
    read = found.logit_opacities if "opacity" in types else found.sh[:, 0, 2]
    assert read.tolist() == pytest.approx(expected, rel=1e-4)
    assert found.left_out == 0 and len(found) == len(values)


@pytest.mark.parametrize(
    ("name", "type_"),
    [
        ("opacity", "int"),
        ("scale_1", "uchar"),
        ("rot_0", "uchar"),
        ("f_dc_2", "uchar"),
        ("x", "short"),
    ],
)
def test_a_type_that_cannot_hold_its_property_is_named(
    name: str, type_: str, tmp_path: Path
) -> None:
    (tmp_path / "scene.ply").write_bytes(typed({name: type_}, [1]))
    with pytest.raises(InputError, match=f"stores {name} as {type_}, which cannot hold it"):
        read_ply(tmp_path / "scene.ply")


BINARY = "binary_little_endian"
INVALID = {
    "no PLY file": (b"PK\x03\x04 a zip", "is not a PLY file"),
    "a huge count": (header(BINARY, NAMES, 10**17), "cut off"),
    "one byte short": (header(BINARY, NAMES, 1) + bytes(55), "cut off"),
    "words": (header("ascii", NAMES, 1) + b"0 " * 13 + b"nought", "not a number"),
    "no opacity": (header(BINARY, NAMES[:6] + NAMES[7:], 0), "lack opacity"),
    "a point cloud": (header(BINARY, ["x", "y", "z"], 0), "not a 3DGS scene"),
    "one f_rest property": (header(BINARY, [*NAMES, "f_rest_0"], 0), "has 1 f_rest"),
    "a duplicate property": (header(BINARY, [*NAMES, "x"], 0), "'x' twice"),
    "an unknown type": (header(BINARY, NAMES, 0, "quad"), "not PLY"),
    "no vertices": (b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "no 'vertex'"),
    "lists before": (
        header(BINARY, NAMES, 0, before="element face 1\nproperty list uchar int i\n"),
        "lists",
    ),
    "a compressed one": (header(BINARY, ["packed_position"], 0, "uint"), "compressed PLY"),
}


@pytest.mark.parametrize("case", INVALID)
def test_an_invalid_file_raises_a_one_line_error(case: str, tmp_path: Path) -> None:
    content, words = INVALID[case]
    (tmp_path / "scene.ply").write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        read_ply(tmp_path / "scene.ply")
    assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="cannot read"):
        read_ply(tmp_path / "nowhere.ply")


@pytest.mark.parametrize(
    ("name", "count"), [("flowers_lod1", 210_422), ("playbot_125k_sh3pad", 125_000)]
)
def test_real_scenes_are_read(name: str, count: int, data_dir: Path) -> None:
    gaussians = read_ply(data_dir / "splats" / f"{name}.ply")
    assert len(gaussians) == count
    assert gaussians.sh_degree == 3
    assert all(value.isfinite().all() for value in gaussians.tensors().values())


def test_the_footprint_is_read_back(tmp_path: Path, generator: torch.Generator) -> None:
    path, gaussians = tmp_path / "scene.ply", random_gaussians(3, 1, generator)
    for footprint, mode in (
        (Footprint(), "default"),
        (Footprint(antialiased=True), "mip"),
        (Footprint(0.1, antialiased=True), "mip"),
        (Footprint(0.25), "default"),
    ):
        write_ply(path, gaussians, footprint=footprint)
        lines = path.read_bytes().split(b"end_header\n")[0].decode().splitlines()
        assert f"comment SplatRenderMode: {mode}" in lines
        assert any("blur" in line for line in lines) == (footprint.blur != 0.3)
        assert read_ply_scene(path)[1] == footprint == open_scene(path).footprint
        assert_equal(read_ply(path), gaussians)
    with pytest.raises(InputError, match="sorted blending has no soft edge"):
        write_ply(path, gaussians, footprint=Footprint(soft_edge=True))


@pytest.mark.parametrize("blur", ["0", "4.1", "nan", "x"])
def test_an_impossible_blur_is_refused(
    blur: str, tmp_path: Path, generator: torch.Generator
) -> None:
    path = tmp_path / "scene.ply"
    write_ply(path, random_gaussians(3, 1, generator), note=f"blur {blur}")
    for read in (read_ply, read_ply_scene):
        with pytest.raises(InputError, match="names the blur"):
            read(path)


COMMENTS: dict[str, tuple[list[str], list[float] | None]] = {
    "none": ([], None),
    "nerfstudio's": (["Generated by Nerstudio 1.1.5", "Vertical Axis: z"], [0, 0, 1]),
    "Brush's": (["Exported from Brush", "Vertical axis: y"], [0, -1, 0]),
    "another axis": (["Vertical Axis: w"], None),
    "ours": (["mobilegs up 0.000000 -3.000000 4.000000"], [0, -0.6, 0.8]),
    "the last one": (["Vertical Axis: z", "mobilegs up 1 0 0"], [1, 0, 0]),
    "a zero": (["Vertical Axis: z", "mobilegs up 0 0 0"], [0, 0, 1]),
    "four numbers": (["mobilegs up 0 1 0 0"], None),
    "a huge number": (["mobilegs up 0 1e400 1"], None),
}
READ_UP = """
const { readPly } = await import(`${process.argv[1]}/load/ply.js`);
const rows = JSON.parse(process.argv[2]).map((hex) => Uint8Array.from(Buffer.from(hex, "hex")));
console.log(JSON.stringify(rows.map((bytes) => readPly(bytes).up)));
"""


def test_the_upward_direction_is_read_here_and_in_the_web_viewer(
    tmp_path: Path, generator: torch.Generator
) -> None:
    write_ply(tmp_path / "scene.ply", random_gaussians(2, 0, generator))
    plain = (tmp_path / "scene.ply").read_bytes()
    files = []
    for name, (comments, expected) in COMMENTS.items():
        lines = "".join(f"comment {comment}\n" for comment in comments)
        files.append(plain.replace(b"end_header\n", f"{lines}end_header\n".encode()))
        (tmp_path / "named.ply").write_bytes(files[-1])
        for found in (read_ply_up(tmp_path / "named.ply"), open_scene(tmp_path / "named.ply").up):
            assert (None if found is None else found.tolist()) == pytest.approx(expected), name
    theirs = javascript(READ_UP, [file.hex() for file in files])
    for (name, (_, expected)), found in zip(COMMENTS.items(), theirs, strict=True):
        assert found == pytest.approx(expected), name


@pytest.mark.parametrize("up", [[0, 0, 1], [-0.004, -0.97, -0.243]])
def test_a_written_upward_direction_is_read_back(
    up: list[float], tmp_path: Path, generator: torch.Generator
) -> None:
    path, direction = tmp_path / "scene.ply", np.array(up) / np.linalg.norm(up)
    write_ply(path, random_gaussians(2, 0, generator), up=direction)
    found = read_ply_up(path)
    assert found is not None
    np.testing.assert_allclose(found, direction, atol=1e-6)
    assert (b"comment Vertical Axis: z\n" in path.read_bytes()) == (up == [0, 0, 1])
