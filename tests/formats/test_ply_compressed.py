"""Reading compressed `.ply`, and special values and comments of a plain one."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from mobilegs.errors import InputError
from mobilegs.formats.ply import read_ply, write_ply
from mobilegs.formats.ply_compressed import CHUNK
from mobilegs.spherical_harmonics import C0
from tests.support.format_files import encode_compressed_ply
from tests.support.random_scenes import (
    error_message,
    matched,
    max_error,
    random_scene,
    rotation_error,
)

OTHERS = Path(__file__).parent / "other_tools"


@pytest.mark.parametrize("degree", [0, 1, 2, 3])
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_compressed_scene_is_read_within_its_precision(
    degree: int, order: str, tmp_path: Path
) -> None:
    made = random_scene(700, degree)  # three chunks, the last one not full
    (tmp_path / "scene.compressed.ply").write_bytes(encode_compressed_ply(made, order=order))
    found = read_ply(tmp_path / "scene.compressed.ply")
    for first in range(0, 700, CHUNK):
        rows = slice(first, first + CHUNK)
        for name, bits in (("means", 10), ("log_scales", 10)):
            one, other = found.tensors()[name][rows], made.tensors()[name][rows]
            step = float((other.amax(0) - other.amin(0)).max()) / ((1 << bits) - 1)
            assert max_error(one, other) <= 0.5 * step + 1e-6
        one, other = found.sh[rows, 0], made.sh[rows, 0]
        assert (
            max_error(one, other) <= 0.5 * float((other.amax(0) - other.amin(0)).max()) / 255 + 1e-6
        )
    assert max_error(found.opacities, made.opacities) <= 0.5 / 255 + 1e-6
    if degree:
        assert max_error(found.sh[:, 1:], made.sh[:, 1:]) <= 8 / 256 / 2 + 1e-6
    assert rotation_error(found, made) <= 2 * math.sqrt(3) * 0.5 / 1023 * math.sqrt(2)


def test_a_file_of_splat_transform_is_read_as_by_itself() -> None:
    path = OTHERS / "theirs.compressed.ply"
    found, back = read_ply(path), read_ply(path.with_name(f"{path.name}.back.ply"))
    for name, value in found.tensors().items():
        assert torch.equal(value, back.tensors()[name]), name
    made = read_ply(OTHERS / "scene.ply")
    assert max_error(matched(found, made).means, made.means) < 0.01


def test_colours_without_bounds_lie_between_0_and_1(tmp_path: Path) -> None:
    made = random_scene(30, 0)
    (tmp_path / "old.ply").write_bytes(encode_compressed_ply(made, colors=False))
    expected = made.sh.clamp(-0.5 / C0, 0.5 / C0)
    assert max_error(read_ply(tmp_path / "old.ply").sh, expected) <= 0.5 / 255 / C0 + 1e-6


def test_an_empty_compressed_scene_is_read(tmp_path: Path) -> None:
    (tmp_path / "none.ply").write_bytes(encode_compressed_ply(random_scene(0, 1)))
    assert len(read_ply(tmp_path / "none.ply")) == 0


def test_double_bounds_and_more_sh_rows_than_vertices_are_read(tmp_path: Path) -> None:
    data = encode_compressed_ply(random_scene(2, 1), kinds=("double", "uint", "uchar"))
    head, end, body = data.partition(b"end_header\n")
    wide = np.frombuffer(body[:72], "<f4").astype("<f8")
    head = head.replace(b"element sh 2", b"element sh 3")
    path = tmp_path / "wide.ply"
    path.write_bytes(head + end + wide.tobytes() + body[72:] + bytes(9))
    assert len(read_ply(path)) == 2
    wide[[0, 3]] = 1e300  # infinite as float32
    path.write_bytes(head + end + wide.tobytes() + body[72:] + bytes(9))
    assert len(read_ply(path)) == 0


def test_gaussians_of_chunks_that_are_not_finite_are_dropped(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    data = encode_compressed_ply(random_scene(300, 0))
    at = data.index(b"end_header\n") + 11 + 18 * 4  # the second chunk's lower bound of x
    data = data[:at] + b"\0\0\xc0\x7f" + data[at + 4 :]
    (tmp_path / "nan.ply").write_bytes(data)
    with caplog.at_level(logging.WARNING):
        assert len(read_ply(tmp_path / "nan.ply")) == CHUNK
    assert "44 of 300 Gaussians" in caplog.text


SCENE = random_scene(3, 1)
VALID = encode_compressed_ply(SCENE)
INVALID = {
    "cut off": (VALID[:-1], "cut off"),
    "a huge count": (VALID.replace(b"vertex 3", b"vertex 999999999999999"), "cut off"),
    "too few chunks": (encode_compressed_ply(SCENE, chunks=0) + bytes(99), "only 0 chunks"),
    "no chunks": (VALID.replace(b"element chunk", b"element chank"), "its chunks lack bounds"),
    "no bound": (VALID.replace(b"max_scale_z", b"max_scale_q"), "its chunks lack bounds"),
    "half the colours": (VALID.replace(b" min_g", b" min_q"), "its chunks lack bounds"),
    "floats for words": (
        encode_compressed_ply(SCENE, kinds=("float", "float", "uchar")),
        "as uint",
    ),
    "no rotation": (VALID.replace(b"packed_rotation", b"packed_rotatoin"), "packed_rotation"),
    "a wrong SH name": (VALID.replace(b"f_rest_8", b"f_rest_9"), "do not fit"),
    "SH of 16 bits": (
        encode_compressed_ply(SCENE, kinds=("float", "uint", "ushort")) + bytes(99),
        "not uchar",
    ),
    "too few SH rows": (VALID.replace(b"element sh 3", b"element sh 2"), "do not fit"),
    "in text": (VALID.replace(b"binary_little_endian", b"ascii"), "as text"),
    "a duplicate element": (VALID.replace(b"element sh", b"element vertex"), "cut off"),
}


@pytest.mark.parametrize("case", INVALID)
def test_an_invalid_compressed_file_raises_a_one_line_error(case: str, tmp_path: Path) -> None:
    data, words = INVALID[case]
    assert words in error_message(read_ply, tmp_path / "bad.ply", data)


def test_the_header_of_a_plain_file_names_its_blending(tmp_path: Path) -> None:
    write_ply(tmp_path / "scene.ply", random_scene(2, 0))
    head = (tmp_path / "scene.ply").read_bytes().split(b"end_header")[0].splitlines()
    assert {b"comment SplatRenderMode: default", b"comment mobilegs blend sorted"} <= set(head)


def test_a_million_announced_vertices_allocate_no_memory(tmp_path: Path) -> None:
    head = VALID[: VALID.index(b"end_header")].replace(b" 3\n", b" 1000000\n")
    path = tmp_path / "head.ply"
    path.write_bytes(head.replace(b"chunk 1\n", b"chunk 3907\n") + b"end_header\n")
    with pytest.raises(InputError, match="cut off"):
        read_ply(path)


def test_infinite_logits_and_scales_of_zero_become_finite(tmp_path: Path) -> None:
    made = random_scene(4, 0)
    made.logit_opacities[:2] = torch.tensor([math.inf, -math.inf])
    made.log_scales[2, 1], made.log_scales[3, 0] = -math.inf, math.inf
    write_ply(tmp_path / "scene.ply", made)
    found = read_ply(tmp_path / "scene.ply")
    assert len(found) == 3
    assert found.opacities[0] > 1 - 1e-5 and found.opacities[1] < 1e-5
    assert found.scales[2, 1] < 1e-20
